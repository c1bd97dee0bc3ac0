# SPDX-License-Identifier: GPL-2.0-or-later
"""From a recording of another tool through `sistap import` to Wireshark: verdicts as worked out by hand.

One character at 9600 Bd 8E1 takes 1.1458 ms. 0 ok, 1 exceeded, 2 unresolved.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from imported import run
from usb_captures import RTAC, STATUS, T0, ftdi, pcap

from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.sis.telegram import build

OK, EXCEEDED, UNRESOLVED = "0", "1", "2"
COMMAND = build(0x10, 16, 3, bytes.fromhex("3C 03 00 24 00"))  # 13 characters: read S-0-0036
REACTION = build(0x10, 16, 3, bytes.fromhex("00 3C 03 E8 03 00 00"), reaction=True)  # 15 characters
CHARACTER_MS = 11 / 9.6


def telegrams(tshark: Tshark, source: Path, *fields: str, tza: int = 0, trs: int = 0) -> list[list[str]]:
    """These fields of each telegram of an imported file, with limits in ms."""
    limits = ["-o", f"sis.tza_ms:{tza}", "-o", f"sis.trs_ms:{trs}", "-o", "sis.tza_from:start"]
    names = [word for field in fields for word in ("-e", field)]
    out = str(source) + ".imported"
    return [
        line.split("\t")
        for line in tshark.output("-r", out, "-2", "-Y", "sis", *limits, "-T", "fields", *names).splitlines()
    ]


@pytest.fixture(scope="module")
def exchange(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A master with an FTDI adapter, latency timer 16 ms.

    The command is handed over at 100 and taken at 100.2; with a USB frame, its last character is out between 114.9 and
    116.1. The reaction comes with the transfer at 150; the one before was at 134, so its first of 15 characters came
    between 133 and 150 - 14 characters = 134.0.
    """
    host = ftdi()
    host.send(100, 100.2, COMMAND)
    for time_ms in (86, 102, 118):
        host.receive(time_ms, time_ms + 16, STATUS)
    host.receive(134, 150, STATUS + REACTION)
    source = host.save(tmp_path_factory.mktemp("exchange") / "usb.pcap")
    assert run(source).code == 0
    return source


@pytest.mark.thorough
def test_an_exchange_of_a_usb_capture(tshark: Tshark, exchange: Path) -> None:
    fields = ["sis.talker", "sis.listener", "sis.parameter", "sis.command_in", "sertap.line", "sertap.format"]
    command, reaction = telegrams(tshark, exchange, *fields)
    assert command == ["16", "3", "S-0-0036", "", "2", "8E1"]
    assert reaction == ["3", "16", "S-0-0036", "3", "1", "8E1"]  # the command is packet 3, after an event for each line


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("limit_ms", "verdict"),
    [
        (15, EXCEEDED),
        (18, UNRESOLVED),
        (20, OK),
    ],  # between 133 - 116.1 = 16.9 and 134.0 (134.3 with 2 %) - 114.9 = 19.4
)
def test_reaction_time_over_usb(tshark: Tshark, exchange: Path, limit_ms: int, verdict: str) -> None:
    assert telegrams(tshark, exchange, "sis.trs.verdict", trs=limit_ms) == [[""], [verdict]]


@pytest.mark.parametrize(
    ("limit_ms", "command", "reaction"),
    [
        # Command: 1.15 +- 1.2. Reaction: 17 ms hold 15 characters, so no interval is longer than 17 - 13 * 1.12 = 2.4.
        (3, OK, OK),
        (2, UNRESOLVED, UNRESOLVED),
    ],
)
def test_intervals_over_usb(tshark: Tshark, exchange: Path, limit_ms: int, command: str, reaction: str) -> None:
    assert telegrams(tshark, exchange, "sis.tza.verdict", tza=limit_ms) == [[command], [reaction]]


def table(folder: Path, pause_ms: float) -> Path:
    """A command as Saleae Logic 2 exports it; with this time from the 4th character to the 5th."""
    lines = ["name,type,start_time,duration,data,error"]
    start_ms = 1.0
    for number, value in enumerate(COMMAND):
        lines.append(f'"Async Serial","data",{start_ms / 1000:.9f},0.00109375,0x{value:02X},')
        start_ms += pause_ms if number == 3 else CHARACTER_MS
    source = folder / "logic.csv"
    source.write_text("\n".join(lines) + "\n")
    return source


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("pause_ms", "options", "verdict"),
    [
        (5.5, [], EXCEEDED),
        (4.5, [], OK),
        (5.01, [], UNRESOLVED),  # a quarter of a bit is 0.026 ms
        (4.99, [], UNRESOLVED),
        (5.01, ["--samplerate", "1000000"], EXCEEDED),  # 0.001 ms
        (4.99, ["--samplerate", "1000000"], OK),
    ],
)
def test_intervals_of_a_logic_analyser(
    tshark: Tshark, tmp_path: Path, pause_ms: float, options: list[str], verdict: str
) -> None:
    """TzA counts from the start of the character before."""
    source = table(tmp_path, pause_ms)
    assert run(source, "--baud", "9600", *options).code == 0
    assert telegrams(tshark, source, "sis.tza.verdict", "sis.tza.position", tza=5) == [[verdict, "5"]]


@pytest.mark.thorough
def test_verdicts_stay_open_where_the_times_have_no_bound(tshark: Tshark, tmp_path: Path) -> None:
    """RTAC: the stamps are 30 ms apart, but their characters are unknown."""
    stamps = [(100, 1, COMMAND), (130, 2, REACTION)]
    packets = [
        (float(ms), T0.to_bytes(4) + (ms * 1000).to_bytes(4) + bytes([event, 0, 0, 0]) + data)
        for ms, event, data in stamps
    ]
    source = pcap(tmp_path / "rtac.pcap", RTAC, packets)
    assert run(source, "--baud", "9600").code == 0
    found = telegrams(tshark, source, "sis.trs.verdict", "sis.tza.verdict", "sis.command_in", tza=3, trs=10)
    assert found == [["", UNRESOLVED, ""], [UNRESOLVED, UNRESOLVED, "3"]]
