# SPDX-License-Identifier: GPL-2.0-or-later
"""The log of stations that answer a real master: what came, the answers, and the times."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from portable import terminals
from test_answering import LINE, MS, READ_PHASE, Over, Script
from test_bus import BUS, TIMEOUT_S, logged, octets, running

from sisbus.stations.making import make
from sisbus.wires.answering import Noting, serve
from sisbus.wires.wire import Log
from sistap.tap.sis.telegram import build

PHASE_4 = octets("02 C1 02 02 10 12 10 03 00 04")  # checksum by hand: the other bytes add up to 3F
FOR_ANOTHER = build(0x12, 16, 9)
WRONG_CHECKSUM = octets("02 DA 00 00 00 12 10 03")  # D9 would be right
CHARACTER_MS = LINE.character_ns / MS
EXCHANGED = 22  # telegrams of the master and its drives, if none is repeated
PAUSE_MS = 5 * CHARACTER_MS  # of a station without TzA: four characters, and one more

Line = tuple[float, bytes, list[str]]  # ms, bytes, marks


def log_of(path: Path, *arrivals: tuple[float, bytes]) -> list[Line]:
    """Let a station answer what arrives; return what the log has then."""
    log, script = Log(path.open("wb")), Script(*arrivals)
    with pytest.raises(Over):
        serve(script, make([{"address": 3}], 1), script, Noting(log, LINE))
    log.close()
    return [(entry.time_ns / MS, entry.sent, entry.marks) for entry in logged(path)]


def test_commands_and_reactions_with_their_times(tmp_path: Path) -> None:
    assert log_of(tmp_path / "log", (100, READ_PHASE), (400, READ_PHASE)) == [
        (100, READ_PHASE, []),
        (pytest.approx(100 + PAUSE_MS + CHARACTER_MS), PHASE_4, []),
        (400, READ_PHASE, []),
        (pytest.approx(400 + PAUSE_MS + CHARACTER_MS), PHASE_4, []),
    ]


def test_all_that_came_is_there(tmp_path: Path) -> None:
    heard = [FOR_ANOTHER, WRONG_CHECKSUM, b"DKC", READ_PHASE[:5]]
    arrivals = [(1500.0 * place, data) for place, data in enumerate(heard, start=1)]
    assert log_of(tmp_path / "log", *arrivals) == [
        (1500, FOR_ANOTHER, []),
        (3000, WRONG_CHECKSUM, ["damaged"]),
        (4500, b"DKC", ["damaged"]),
        (6000, READ_PHASE[:5], ["damaged"]),
    ]


def test_what_breaks_off_is_noted_after_a_second_and_before_an_answer(tmp_path: Path) -> None:
    noting = Noting(Log((tmp_path / "log").open("wb")), LINE)
    noting.heard(READ_PHASE[:5], 100 * MS)
    noting.heard(b"", 1099 * MS)
    assert logged(tmp_path / "log") == []
    noting.heard(b"", 1100 * MS)
    assert [entry.sent for entry in logged(tmp_path / "log")] == [READ_PHASE[:5]]
    noise = octets("02 00 FF FF")  # as if 259 characters were to follow; a station is not deceived
    lines = log_of(tmp_path / "other", (100, noise), (200, READ_PHASE))
    assert [data for _, data, _ in lines] == [noise, READ_PHASE, PHASE_4]


def test_a_rate_that_changes_tears_nothing(tmp_path: Path) -> None:
    accept = build(0x03, 16, 3, b"\x03\x07\x08\xff")
    lines = log_of(tmp_path / "log", (100, accept), (300, READ_PHASE))
    assert [data for _, data, _ in lines] == [
        accept,
        build(0x03, 16, 3, b"\x00\x03\x07\xff", reaction=True),
        READ_PHASE,
        PHASE_4,
    ]
    assert lines[-1][0] == pytest.approx(300 + 6 * CHARACTER_MS / 12)  # at 115200 Bd, twelve times 9600


def test_what_is_unfinished_when_a_rate_changes_is_noted(tmp_path: Path) -> None:
    test = octets("02 E0 05 05 00 03 10 03 00 08 F4 01 01")  # 19200 Bd for 500 ms
    lines = log_of(tmp_path / "log", (100, test), (500, READ_PHASE[:5]), (700, READ_PHASE))
    assert [data for _, data, _ in lines][2:] == [READ_PHASE[:5], READ_PHASE, PHASE_4]


def both_logs(folder: Path) -> tuple[str, Path, Path]:
    """Let a master ask drives through a pseudo terminal; return its name, the log of the drives and of the master."""
    ours, theirs = folder / "ours", folder / "theirs"
    with running("drives", "--baud", "115200", "--log", str(ours)) as (process, port):
        options = ["master", "--port", port, "--transmit", "--cycles", "2", "--baud", "115200", "--log", str(theirs)]
        subprocess.run([*BUS, *options], capture_output=True, timeout=TIMEOUT_S, check=True)
        process.terminate()
        process.wait(TIMEOUT_S)
    return port, ours, theirs


@terminals
def test_it_is_the_log_of_the_master_from_the_other_side(tmp_path: Path) -> None:
    for attempt in range(10):  # a busy computer can stop the drives: then the master gives up, or asks again
        (folder := tmp_path / str(attempt)).mkdir()
        port, ours, theirs = both_logs(folder)
        if len(logged(theirs)) == EXCHANGED and not any(entry.marks for entry in logged(theirs)):
            break
    assert [(entry.sent, entry.marks) for entry in logged(ours)] == [
        (entry.sent, entry.marks) for entry in logged(theirs)
    ]
    assert len(logged(ours)) == EXCHANGED
    first = ours.read_text().splitlines()[0]
    assert first.startswith(f"# 115200 8E1, {port}, time 0 is ")
    times = [entry.time_ns for entry in logged(ours)]
    assert times == sorted(times)
