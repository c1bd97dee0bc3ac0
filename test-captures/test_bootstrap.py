# SPDX-License-Identifier: GPL-2.0-or-later
"""./bootstrap says in a line why it cannot begin; check lists at its end what could not be run."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

BOOTSTRAP = Path(__file__).parent.parent / "bootstrap"
AS_NOBODY = ("setpriv", "--reuid=65534", "--regid=65534", "--clear-groups") if os.geteuid() == 0 else ()


@pytest.fixture
def checkout() -> Iterator[Path]:
    """A folder that everybody may enter, which tmp_path is not."""
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(BOOTSTRAP, folder)
        yield Path(folder)
        Path(folder).chmod(0o755)


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("part", ["demo", "test", "page", "docs", "release", "check"])
def test_a_folder_of_somebody_else(part: str, checkout: Path) -> None:
    checkout.chmod(0o555)
    ended = run(*AS_NOBODY, f"{checkout}/bootstrap", part)
    assert ended.stderr == f"bootstrap: cannot write to {checkout}/build: run this as root, or in a clone of your own\n"
    assert (ended.returncode, ended.stdout) == (1, "")


@pytest.mark.parametrize("target", [".", "nowhere"])
def test_a_build_folder_that_leads_elsewhere(checkout: Path, tmp_path: Path, target: str) -> None:
    (checkout / "build").symlink_to(tmp_path / target)
    ended = run(f"{checkout}/bootstrap", "test")
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == f"bootstrap: {checkout}/build is a link: replace it by a folder\n"
    assert not list(tmp_path.iterdir())


def test_a_build_folder_in_which_others_may_put_programs(checkout: Path) -> None:
    (checkout / "build").mkdir()
    (checkout / "build").chmod(0o777)
    ended = run(f"{checkout}/bootstrap", "test")
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr == f"bootstrap: others can write to {checkout}/build, and what is in it is run: delete it\n"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files to others")
@pytest.mark.parametrize("owner, is_taken", [(0, True), (65534, True), (65533, False)])
def test_root_in_a_checkout_of_somebody_else(checkout: Path, owner: int, is_taken: bool) -> None:
    """What is in build/ is run: its owner, but nobody else, may have put it there."""
    (checkout / "build").mkdir()
    os.chown(checkout, 65534, 65534)
    os.chown(checkout / "build", owner, 65534)
    ended = run("bash", "-c", 'source "$0" help >/dev/null; begin pwd', f"{checkout}/bootstrap")
    if is_taken:
        assert (ended.stdout, ended.stderr) == (f"{checkout}\n", "")
    else:
        assert ended.stdout == ""
        assert ended.stderr == f"bootstrap: others can write to {checkout}/build, and what is in it is run: delete it\n"


def parts(checkout: Path, *ends: str) -> subprocess.CompletedProcess[str]:
    """Run parts as check does, each a line of shell; at the end comes what was not run."""
    (checkout / "build").mkdir()
    script = 'source "$0" help >/dev/null; for part; do or_77 sh -c "$part"; done'
    return run("bash", "-c", script, f"{checkout}/bootstrap", *ends)


def test_nothing_is_listed_if_all_was_run(checkout: Path) -> None:
    ended = parts(checkout, "echo fine", "echo 'cat: not as it should be' >&2")
    assert (ended.returncode, ended.stdout) == (0, "fine\n")


def test_a_line_for_each_part_that_was_not_run(checkout: Path) -> None:
    ended = parts(
        checkout,
        "echo begun; echo noise >&2; echo 'drivers: not run: qemu is missing' >&2; exit 77",
        "echo 'bundle: not made: sis.dll for 4.4' >&2; echo 'bundle: not made: sis.dll for 4.6' >&2; exit 77",
        "exit 77 # silent",
    )
    assert ended.returncode == 0
    assert ended.stdout.splitlines() == [
        "begun",
        "",
        "== not run",
        "drivers: not run: qemu is missing",
        "bundle: not made: sis.dll for 4.4",
        "bundle: not made: sis.dll for 4.6",
        "sh -c exit 77 # silent: not run",
    ]
    assert "noise" in ended.stderr  # as it came


def test_a_part_that_fails_ends_it(checkout: Path) -> None:
    ended = parts(checkout, "echo 'part: not run: no qemu' >&2; exit 77", "exit 3", "echo never")
    assert (ended.returncode, ended.stdout) == (3, "\n== not run\npart: not run: no qemu\n")
