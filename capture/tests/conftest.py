# SPDX-License-Identifier: GPL-2.0-or-later
"""What the tests must not take from whoever runs them: signals as they were left, and the results of self-tests.

And what they need of the system.
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import once
import pytest
from hypothesis import settings
from portable import SIGNALS, WINDOWS, lacking
from sharkd import Sharkd

import sistap.tap.terminal.state
from sistap.dissected.wireshark.tshark import Tshark

SCRIPT = Path(__file__).parents[2] / "lua-fallback" / "sis.lua"

# `test` tries fewer examples than `check`; a busy machine is no failure of either.
settings.register_profile("quick", max_examples=25, deadline=None)
settings.register_profile("thorough", max_examples=300, deadline=None)
settings.load_profile("quick")

# What nohup ignores, children ignore: they would not end when their terminal goes.
if sys.platform != "win32":
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


class NotHere(pytest.Module):
    """A file of tests that this system cannot run: skipped, with the reason."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        pytest.skip(lacking(self.path), allow_module_level=True)


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module | None:
    return NotHere.from_parent(parent, path=module_path) if lacking(module_path) else None


@pytest.fixture(scope="session", autouse=True)
def _once(tmp_path_factory: pytest.TempPathFactory) -> None:
    once.begin(tmp_path_factory)


@pytest.fixture(scope="session")
def sharkd() -> Iterator[Sharkd]:
    """Run sharkd, which must have the plugin."""
    if WINDOWS:
        pytest.skip("the sharkd here knows no paths of Windows")
    with Sharkd() as program:
        assert program.has_field("sis.start"), "./bootstrap test sets WIRESHARK_PLUGIN_DIR"
        yield program


@pytest.fixture(scope="session")
def tshark() -> Iterator[Tshark]:
    """Yield a tshark with the plugin."""
    with Tshark() as program:
        assert "sis.so" in program.output("-G", "plugins"), "./bootstrap test sets WIRESHARK_PLUGIN_DIR"
        yield program


@pytest.fixture(params=["plugin", "script"])
def dissector(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the plugin that was built, and with sis.lua."""
    if request.param == "script":
        (tmp_path / "plugins").mkdir()
        shutil.copy(SCRIPT, tmp_path / "plugins")
        monkeypatch.setenv("WIRESHARK_PLUGIN_DIR", str(tmp_path / "plugins"))


@pytest.fixture(autouse=True)
def state(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An empty state folder (XDG_STATE_HOME) for the test."""
    folder = tmp_path_factory.mktemp("state")
    monkeypatch.setenv("XDG_STATE_HOME", str(folder))
    monkeypatch.setattr(sistap.tap.terminal.state, "FOR_ROOT", folder / "sistap")
    monkeypatch.setattr(
        sistap.tap.terminal.state, "ROOT", getattr(os, "getuid", lambda: 0)()
    )  # whoever runs the tests can play root
    return folder


@pytest.fixture
def full() -> Path:
    """The device that is always full. A file of that name would take everything, and a test that fills it never end."""
    path = Path("/dev/full")
    if WINDOWS or not path.is_char_device():
        pytest.skip("/dev/full is no character device here")
    return path


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 4 MB, which only root can make."""
    if WINDOWS:
        pytest.skip("not on Windows: no disk in memory")
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=4m", "tmpfs", folder], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip("no small disk can be made here: root can")
    yield folder
    subprocess.run(["umount", "--lazy", folder], check=True)


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """Restore the signal handlers after a command has run in this process."""
    handlers = [(number, signal.getsignal(number)) for number in SIGNALS]
    yield
    for number, handler in handlers:
        signal.signal(number, handler)
