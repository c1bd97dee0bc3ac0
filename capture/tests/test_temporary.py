# SPDX-License-Identifier: GPL-2.0-or-later
"""Folders of processes that were killed: the next one removes them, and nothing else."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from portable import modes, posix

from sistap.dissected.wireshark.tshark import NOBODY, Tshark
from sistap.tap.common import temporary

pytestmark = posix("no locks of folders, and no SIGKILL")
NAME = temporary.PREFIX + "abcdefgh"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Be where temporary files are."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


@pytest.fixture
def left(folder: Path) -> Path:
    """A folder of a process that was killed long ago."""
    made = folder / NAME
    made.mkdir(mode=0o700)
    (made / "capture-1").write_text("a secret")
    os.utime(made, (0, 0))
    return made


@pytest.mark.attack("SIGKILL while tshark has a copy of a capture", "the next start removes the copy")
def test_what_a_killed_process_leaves(folder: Path) -> None:
    """It is removed by the next one, but not while it lives."""
    program = (
        "from sistap.tap.common import temporary; made = temporary.Folder(); print(made.path, flush=True); input()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program],
        env=os.environ | {"TMPDIR": str(folder)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout
        made = Path(process.stdout.readline().strip())
        assert made.parent == folder
        os.utime(made, (0, 0))
        temporary.sweep()
        assert made.exists()
        process.send_signal(signal.SIGKILL)
    temporary.sweep()
    assert not made.exists()


def test_one_that_is_made_removes_it_and_itself(left: Path, folder: Path) -> None:
    with temporary.folder() as made:
        assert list(folder.iterdir()) == [made]
    assert not list(folder.iterdir())


def test_one_that_is_new_may_not_be_claimed_yet(left: Path) -> None:
    os.utime(left)
    temporary.sweep()
    assert left.exists()


def test_what_has_another_name_stays(left: Path) -> None:
    own = left.rename(left.with_name("sistap-captures"))
    temporary.sweep()
    assert own.exists()


def test_no_link_is_followed(folder: Path, left: Path) -> None:
    elsewhere = left.rename(folder / "elsewhere")
    (folder / NAME).symlink_to(elsewhere)
    temporary.sweep()
    assert (elsewhere / "capture-1").exists()
    inside = folder / (temporary.PREFIX + "inside")
    inside.mkdir()
    (inside / "link").symlink_to(elsewhere)
    os.utime(inside, (0, 0))
    temporary.sweep()
    assert not inside.exists()
    assert (elsewhere / "capture-1").exists()


@modes
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can make the folder of another")
def test_as_root_one_of_nobody_goes_and_one_of_somebody_else_stays(left: Path) -> None:
    for owner, stays in ((4711, True), (NOBODY, False)):
        os.chown(left, owner, owner)
        os.utime(left, (0, 0))
        with Tshark("sh"):
            assert left.exists() == stays


def test_it_is_found_from_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    """TMPDIR=. is the one relative name that Python leaves as it is."""
    monkeypatch.chdir(tempfile.gettempdir())
    monkeypatch.setattr(tempfile, "tempdir", os.curdir)
    with temporary.folder() as made:
        assert made.is_absolute()
