# SPDX-License-Identifier: GPL-2.0-or-later
"""A full disk or a closed output in every command: one line with the cure, exit code 1, nothing half written."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from commands import TIMEOUT_S
from portable import posix

from sistap.cli import COMMANDS
from sistap.tap.terminal import state

pytestmark = [posix("it has no /dev/full"), pytest.mark.thorough, pytest.mark.tap]
FULL = pytest.mark.attack(
    "the disk is full, in each command that writes", "one line with the cure; no part of a file stays"
)

CAPTURES = Path(__file__).parents[2] / "test-captures"
CAPTURE, OTHER = CAPTURES / "parameters.pcapng", CAPTURES / "exchanges.pcapng"
TABLE = "name,type,start_time,duration,data,error\n" + "".join(
    f'"Async Serial","data",{i / 500:.6f},0.001094,0x{i:02X},\n' for i in range(256)
)
LOG = "16.03.2026 09:00:00,123 TX: 02 D9 02 02 00 12 03 10 02 00\n" * 40

# `tables` makes a folder: test_tables.py. `capture` needs a line: test_capture.py.
PRINTING = [
    ["--help"],
    ["--version"],
    *([name, "--help"] for name in COMMANDS),
    ["ports"],
    ["bus", "--list"],
    ["parameters", CAPTURE],
    ["parameters", "--csv", CAPTURE],
    ["compare", CAPTURE, OTHER],
    ["report", "--format", "text", "-o", "-", CAPTURE],
    ["report", "--format", "html", "-o", "-", CAPTURE],
    ["annotate", "log.txt"],
    ["annotate", "--format", "html", "log.txt"],
    ["log", CAPTURE],
    ["doctor"],
    ["extcap", "--extcap-interfaces"],
    ["extcap", "--extcap-config", "--extcap-interface", "sistap-demo"],
]
# Each is followed by the name of its file.
WRITING = [
    ["annotate", "log.txt", "-o"],
    ["annotate", "log.txt", "--format", "html", "-o"],
    ["annotate", "log.txt", "-w"],
    ["log", CAPTURE, "-o"],
    ["import", "table.csv", "--baud", "9600", "-w"],
    ["bus", "-w"],
    ["parameters", CAPTURE, "-o"],
    ["compare", CAPTURE, OTHER, "-o"],
    ["report", CAPTURE, "--format", "text", "-o"],
    ["report", CAPTURE, "--format", "html", "-o"],
    ["report", CAPTURE, "--format", "svg", "-o"],
    ["report", CAPTURE, "--format", "json", "-o"],
]
Words = list[str | Path]


def name(words: Words) -> str:
    return " ".join(Path(word).name for word in words)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "table.csv").write_text(TABLE)
    (tmp_path / "log.txt").write_text(LOG)
    return tmp_path


def run(folder: Path, words: Words, stdout: Path) -> str:
    """Run a command that fails; return the line that it says."""
    with stdout.open("wb") as stream:
        done = subprocess.run(
            [sys.executable, "-m", "sistap", *map(str, words)],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.PIPE,
            check=False,
            timeout=TIMEOUT_S,
        )
    assert done.returncode == 1, done.stderr
    assert {path.name for path in folder.iterdir()} == {"table.csv", "log.txt"}
    (line,) = done.stderr.decode().splitlines()
    return line


@FULL
@pytest.mark.parametrize("words", PRINTING, ids=name)
def test_what_is_printed(words: Words, folder: Path, full: Path) -> None:
    line = run(folder, words, full)
    assert line.startswith("sistap") and "standard output" in line and "No space left on device" in line
    assert "make room" in line or "everything before it is saved" in line


@pytest.mark.attack("standard output is closed, in each command that prints", "exit code 1, and a line says so")
@pytest.mark.parametrize("words", PRINTING, ids=name)
def test_what_is_printed_nowhere(words: Words, folder: Path) -> None:
    command = ["sh", "-c", 'exec "$@" >&-', "sh", sys.executable, "-m", "sistap", *map(str, words)]
    done = subprocess.run(command, cwd=folder, stderr=subprocess.PIPE, text=True, check=False, timeout=TIMEOUT_S)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1), done.stderr
    assert "standard output is closed" in done.stderr


@FULL
@pytest.mark.parametrize("words", WRITING, ids=name)
def test_what_is_written(words: Words, folder: Path, full: Path) -> None:
    line = run(folder, [*words, full], Path(os.devnull))
    assert line.startswith("sistap") and f"{full}" in line and "No space left on device" in line
    assert "make room" in line or "everything before it is saved" in line


@FULL
def test_what_install_and_selftest_keep(tmp_path: Path, full: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They would write into folders of the system."""
    new = tmp_path / "new"

    def make(prefix: str, dir: Path) -> tuple[int, str]:
        new.touch()
        return os.open(full, os.O_WRONLY), str(new)

    monkeypatch.setattr(tempfile, "mkstemp", make)
    with pytest.raises(OSError, match="No space left on device; make room: .*/kept") as error:
        state.replace(tmp_path / "kept", b"x")
    assert error.value.errno == errno.ENOSPC
    assert not list(tmp_path.iterdir())
