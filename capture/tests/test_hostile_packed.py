# SPDX-License-Identifier: GPL-2.0-or-later
"""Compressed captures that Wireshark reads as they are: what is missing is said."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from commands import refused, run

CAPTURE = Path(__file__).parents[2] / "test-captures/parameters.pcapng"
UNTOLD = "is packed: tshark does not say if its end is missing"


def packed(folder: Path, program: str, suffix: str) -> Path:
    if not shutil.which(program):
        pytest.skip(f"no {program} here: apt-get install {program}")
    content = subprocess.run([program, "-c"], input=CAPTURE.read_bytes(), capture_output=True, check=True).stdout
    path = folder / f"day.pcapng.{suffix}"
    path.write_bytes(content)
    return path


@pytest.mark.thorough
@pytest.mark.attack("a capture packed with lz4 or zstd, and cut off", "a line says that nobody knows if all is there")
@pytest.mark.parametrize(("program", "suffix"), [("lz4", "lz4"), ("zstd", "zst")])
@pytest.mark.parametrize("command", ["log", "parameters", "report --format text -o -"])
def test_a_packed_capture_that_is_cut_off(tmp_path: Path, command: str, program: str, suffix: str) -> None:
    """tshark reads what comes before the cut, and says nothing."""
    path = packed(tmp_path, program, suffix)
    words = command.split()
    whole = run(tmp_path, *words, path.name)
    assert (whole.returncode, UNTOLD in whole.stderr) == (0, True)
    path.write_bytes(path.read_bytes()[:1000])
    cut = run(tmp_path, *words, path.name)
    assert UNTOLD in cut.stderr and f"`{program} -dk {path.name}` does" in cut.stderr
    assert len(cut.stdout) < len(whole.stdout)


@pytest.mark.parametrize("command", ["parameters", "report -o -", "tables -o tables", "compare --bad none --good"])
def test_among_others_it_is_refused(tmp_path: Path, command: str) -> None:
    """It may be a copy of one of them, and would count twice."""
    path = packed(tmp_path, "zstd", "zst")
    refused(run(tmp_path, *command.split(), CAPTURE, path.name), 2, "unpack it first, for example with `zstd -dk")


@pytest.mark.parametrize(("program", "suffix"), [("lz4", "lz4"), ("zstd", "zst")])
def test_what_cannot_read_it_says_how_to_unpack_it(tmp_path: Path, program: str, suffix: str) -> None:
    path = packed(tmp_path, program, suffix)
    for words in (["annotate", path.name], ["import", path.name, "-w", "x.pcapng"]):
        refused(run(tmp_path, *words), 2, f"unpack it first, for example with `{program} -dk {path.name}`")
