# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that no honest tool writes: captures, tables, scenarios and folders. A command says one line, or goes on."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from attacks import ROOT
from commands import refused, run
from portable import modes

from sistap.commands.parameters.writing import csv_line
from sistap.tap.files import pcapng
from sistap.tap.terminal.writing import mode_like

CAPTURE = ROOT / "capture"
TELEGRAM = bytes.fromhex("02 6C 00 00 00 92 00 00")
LATEST = (1 << 64) - 1  # ticks of a time stamp


def block(kind: int, body: bytes) -> bytes:
    body += bytes(-len(body) % 4)
    return struct.pack("<II", kind, 12 + len(body)) + body + struct.pack("<I", 12 + len(body))


def hostile(decimals: int, ticks: int) -> bytes:
    """Return a capture with a good packet, one of a strange time, and packets without any time."""
    data = pcapng.upper_pdu("sis", TELEGRAM)
    options = struct.pack("<HHB3xHH", 9, 1, decimals, 0, 0)
    packets = b"".join(
        block(6, struct.pack("<IIIII", 0, when >> 32, when & 0xFFFFFFFF, len(data), len(data)) + data)
        for when in (10**decimals * 1_700_000_000 % LATEST, ticks)
    )
    return (
        block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
        + block(1, struct.pack("<HHI", 252, 0, 0) + options)
        + packets
        + block(3, struct.pack("<I", len(data)) + data)  # Simple Packet Block
        + block(0xBAD, struct.pack("<I", 32473) + b"of somebody")  # Custom Blocks, the second not to be copied
        + block(0x40000BAD, struct.pack("<I", 32473) + b"of somebody")
    )


@pytest.mark.parametrize(
    "command",
    ["log", "report --format text", "report --format html", "parameters", "compare day.pcapng", "tables -o t"],
)
@pytest.mark.parametrize(("decimals", "ticks"), [(6, LATEST), (9, LATEST), (9, 0), (0, LATEST), (0, 1 << 40)])
@pytest.mark.attack("packets without a time, or with a time in no calendar", "read without it, or refused in one line")
def test_packets_without_a_time(tmp_path: Path, command: str, decimals: int, ticks: int) -> None:
    (tmp_path / "day.pcapng").write_bytes(hostile(decimals, ticks))
    words = command.split()
    done = run(tmp_path, words[0], "day.pcapng", *words[1:])
    assert done.returncode in (0, 1, 2), done.stderr
    assert done.returncode == 0 or done.stderr.count("\n") == 1, done.stderr


@pytest.mark.parametrize("first_line", ["Time [s],Value,Parity Error,Framing Error", "1104-1938 uart-1: 02", "0,M,00"])
@pytest.mark.attack("a table whose line never ends", "refused in one line")
def test_a_line_that_never_ends(tmp_path: Path, first_line: str) -> None:
    (tmp_path / "x.csv").write_text(f"{first_line}\n{'0' * 3_000_000}\n")
    how = ["--dissector", "synaxpcp"] if first_line.startswith("0") else ["--baud", "9600", "--samplerate", "1000000"]
    refused(run(tmp_path, "import", "x.csv", "-w", "x.pcapng", *how), 2, "x.csv:2: the line has more than")
    assert not (tmp_path / "x.pcapng").exists()


@pytest.mark.parametrize("begin", ["9999-12-31T23:59:59Z", "9999-12-31T23:59:59-14:00", "0001-01-01T00:00:00+14:00"])
@pytest.mark.attack("a scenario that begins when no file can say it", "refused in one line")
def test_a_scenario_of_the_year_9999(tmp_path: Path, begin: str) -> None:
    (tmp_path / "x.toml").write_text(f'title = ""\nbegin = {begin}\n[[station]]\naddress = 3\n')
    done = run(tmp_path, "bus", "x.toml", "-w", "x.pcapng")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "begin" in done.stderr and "between 1970 and 2095" in done.stderr


@pytest.mark.attack("a drive names a parameter like a formula of a spreadsheet", "a ' before it makes it text in CSV")
def test_no_cell_is_a_formula() -> None:
    hostile = ['=HYPERLINK("x")', "@SUM(1)", "-1+1|cmd", "+1+cmd|' /C calc'!A0", "-1 cmd|x!A1", "\t=1", "\r=1"]
    honest = ["-12.5 mm/min", "+1", "-3e-05", "-40 °C", "S-0-0036", "", "a=b", "3 - 2"]
    for cell in hostile:
        assert csv_line([cell]).lstrip('"').startswith(f"'{cell[:1]}")
    assert [csv_line([cell, ""]) for cell in honest] == [f"{cell}," for cell in honest]
    assert csv_line([-5, None, -0.5]) == "-5,,-0.5"


@modes
@pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() != 0, reason="only root gives files away")
@pytest.mark.attack("a file made from a private capture", "whoever may not read the capture may not read it")
def test_the_group_of_a_capture_is_not_that_of_the_user(tmp_path: Path) -> None:
    """The new file has the group of whoever makes it."""
    capture = tmp_path / "day.pcapng"
    capture.touch()
    for group, mode, expected in ((os.getegid(), 0o640, 0o640), (12345, 0o640, 0o600), (12345, 0o644, 0o644)):
        os.chown(capture, 0, group)
        capture.chmod(mode)
        assert mode_like([capture]) == expected


def entrances() -> Iterator[str]:
    """Yield each module that `python3 -m` can run."""
    for file in sorted((*CAPTURE.glob("sistap/**/*.py"), *CAPTURE.glob("sisbus/**/*.py"))):
        if file.stem == "__main__" or '__name__ == "__main__"' in file.read_text("utf-8"):
            yield ".".join(file.relative_to(CAPTURE).with_suffix("").parts).removesuffix(".__main__")


def entered(folder: Path, *module: str) -> str:
    """Run a module in a folder, by itself: it finds no other program. Return what it says."""
    done = subprocess.run(
        [sys.executable, *module, "--version"],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(CAPTURE), "PATH": ""},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return done.stdout


@pytest.fixture(scope="module")
def trapped(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a trap for each module but those that Python has before it comes to the one to be run."""
    folder = tmp_path_factory.mktemp("trapped")
    (folder / "nothing.py").write_text("import sys\nprint(*sys.modules)")
    for name in {*sys.stdlib_module_names, "serial", "pyarrow"} - {*entered(folder, "-m", "nothing").split()}:
        (folder / f"{name}.py").write_text("print('trapped by', __name__, flush=True)\nraise SystemExit(9)")
    return folder


@pytest.mark.parametrize("module", entrances())
@pytest.mark.attack(
    "`python3 -m` in a folder with a file for each module that Python has not loaded yet", "not imported"
)
def test_modules_of_a_foreign_folder_are_not_imported(trapped: Path, module: str) -> None:
    assert "trapped by" not in entered(trapped, "-m", module)


@pytest.mark.parametrize("words", [["-msistap"], ["-Bmsistap"], ["-W", "ignore", "-Bm", "sistap.cli"]])
def test_nor_are_they_if_options_are_written_together(trapped: Path, words: list[str]) -> None:
    assert "trapped by" not in entered(trapped, *words)


def test_a_program_that_uses_sistap_keeps_its_folder(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text("import sistap\nimport beside")
    (tmp_path / "beside.py").write_text("print('here')")
    package = tmp_path / "package"
    package.mkdir()
    (package / "__init__.py").write_text("import sistap\nimport beside")
    (package / "__main__.py").touch()
    assert [entered(tmp_path, "-m", module) for module in ("own", "package")] == ["here\n", "here\n"]
