# SPDX-License-Identifier: GPL-2.0-or-later
"""Damaged files of other tools through `sistap import`: one clear line, never a traceback, and nothing is lost.

Seeded: a mutant that fails has its number in the name of the test's folder.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from imported import Imported, run
from real_captures import truth, unpacked
from specification import TELEGRAMS
from usb_captures import RTAC, pcap

from sistap.tap.terminal.exits import DONE, FAILED, USAGE

FEW, MANY = 40, 400  # texts
COMMAND, REACTION = TELEGRAMS["2-12"], TELEGRAMS["2-13"]
SIGROK = [f'{1000 + 1200 * i}-{1800 + 1200 * i} uart-1: tx-data: "{i:02X}"\n' for i in range(64)]
PULSEVIEW = [f"{1000 + 1200 * i}-{1800 + 1200 * i} UART: RX data: {i:02X}\n" for i in range(64)]
LOGIC_2 = ["name,type,start_time,duration,data,error\n"] + [
    f'"Async Serial","data",{i / 500:.6f},0.001094,0x{i:02X},\n' for i in range(64)
]
# The descriptor of a CH340, then a transfer for each character.
USBMON = ["1 1 C Ci:1:002:0 0 18 = 12010001 ff000008 861a2375 62020002 0001\n"] + [
    f"{i:x} {2000 * i + 2} C Bi:1:002:2 0 1 = {i:02x}\n" for i in range(64)
]
TEXTS = {"sigrok-cli": SIGROK, "PulseView": PULSEVIEW, "Logic 2": LOGIC_2, "usbmon": USBMON}
PIECES = (
    "",
    "\0",
    '"',
    ",",
    "-",
    ":",
    ": ",
    "0x",
    "9" * 30,
    "1e309",
    "nan",
    "\ufeff",
    "\N{DEGREE SIGN}",
    "\udcff",
    "\r",
    "\n",
)


def damaged_line(chance: random.Random, line: str) -> str:
    """Cut a line, or put something into it."""
    start, end = sorted(chance.randrange(len(line)) for _ in range(2))
    return line[:start] + chance.choice(PIECES) + line[chance.choice((start, end)) :]


def damaged_bytes(chance: random.Random, content: bytes) -> bytes:
    """Change some bytes, take a part out, or cut the end off."""
    changed = bytearray(content)
    for _ in range(chance.choice((1, 3, 30))):
        changed[chance.randrange(len(changed))] = chance.choice((0, 1, 0x7F, 0x80, 0xFF, chance.randrange(256)))
    match chance.randrange(3):
        case 0:
            del changed[chance.randrange(len(changed)) :]
        case 1:
            start = chance.randrange(len(changed))
            del changed[start : start + chance.randrange(200)]
    return bytes(changed)


def imported(source: Path, capfd: pytest.CaptureFixture[str], *options: str) -> Imported:
    """Import, and check what applies to every file."""
    done = run(source, *options)
    out, said = capfd.readouterr()
    assert done.code in (DONE, FAILED, USAGE)
    assert out == ""
    assert "Traceback" not in said
    lines = said.splitlines()
    assert lines
    assert all(line.startswith("sistap: ") for line in lines), said
    assert done.code == DONE or len(lines) <= 3
    return done


@pytest.mark.parametrize("count", [FEW, pytest.param(MANY, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("kind", TEXTS)
def test_damaged_texts(tmp_path: Path, capfd: pytest.CaptureFixture[str], kind: str, count: int) -> None:
    """All characters outside damaged lines are imported: each has a unique value."""
    whole = TEXTS[kind]
    for seed in range(count):
        chance = random.Random(seed)
        lines = whole.copy()
        # The first line says what the file is: the lines behind it are damaged.
        damaged = chance.sample(range(1, len(lines)), chance.choice((1, 1, 3)))
        for number in damaged:
            lines[number] = damaged_line(chance, lines[number])
        source = tmp_path / f"{seed}.txt"
        source.write_text("".join(lines), encoding="utf-8", errors="surrogateescape")
        done = imported(source, capfd, "--baud", "9600", "--samplerate", "1000000")
        came = Counter(value for record in done.records for value in record.data)
        first = 1 if kind in ("Logic 2", "usbmon") else 0
        sound = Counter(number - first for number in range(first, len(lines)) if number not in damaged)
        # A quotation mark that nobody closes takes the following lines into its cell: they are one line then.
        swallowed = kind == "Logic 2" and any(lines[number].count('"') % 2 for number in damaged)
        if done.code == DONE and not swallowed:
            assert not sound - came, f"seed {seed}"


def test_what_a_damaged_file_says_is_quoted_on_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "x.csv"
    names = ("a", '"b\n\x1b[2J"', "c")
    source.write_text(LOGIC_2[0] + "".join(f"{name},data,0.1,0.001,0x02,\n" for name in names))
    assert imported(source, capfd, "--baud", "9600").code == USAGE


def rtac(path: Path) -> Path:
    head = bytes.fromhex("65000000 00000000 02 00 0000")
    return pcap(path, RTAC, [(i, head + data) for i, data in enumerate((COMMAND, REACTION) * 8)])


def usb(path: Path) -> Path:
    return unpacked("usbmon-ft232r-errors.pcapng", path.parent).rename(path)


def cdc(path: Path) -> Path:
    return unpacked("usbmon-cdc-acm.pcapng", path.parent).rename(path)


def old_format(path: Path) -> Path:
    return unpacked("usbmon-cdc-115200-8n1.pcap", path.parent).rename(path)


OTHERS = (cdc, old_format)


@pytest.mark.attack(
    "damaged captures of USB, RTAC and logic analysers", "imported up to the damage, or refused in a line"
)
@pytest.mark.parametrize("count", [1, pytest.param(20, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("original", [rtac, usb, *(pytest.param(one, marks=pytest.mark.thorough) for one in OTHERS)])
def test_damaged_captures(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], original: Callable[[Path], Path], count: int
) -> None:
    content = original(tmp_path / "whole").read_bytes()
    for seed in range(count):
        source = tmp_path / f"{seed}.pcap"
        source.write_bytes(damaged_bytes(random.Random(seed), content))
        imported(source, capfd, "--baud", "9600")


@pytest.mark.parametrize("share", [0.5, pytest.param(0.9, marks=pytest.mark.thorough)])
def test_a_capture_that_is_cut_has_all_before_the_cut(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], share: float
) -> None:
    source = unpacked("usbmon-ftdi-19200.pcapng", tmp_path)
    content = source.read_bytes()
    source.write_bytes(content[: int(len(content) * share)])
    done = run(source)
    assert done.code == DONE
    assert "its end is missing: it " in capfd.readouterr().err
    played = truth("usbmon-ftdi-19200")
    received, sent = (b"".join(record.data for record in done.records if record.line == line) for line in (1, 2))
    assert received
    assert played.received.startswith(received)
    assert played.sent.startswith(sent)
