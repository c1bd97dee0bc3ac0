# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters out of RTAC serial captures (link type 250), byte by byte, and out of our own."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from imported import run
from specification import TELEGRAMS
from usb_captures import RTAC, T0, pcap

from sistap.tap.files import pcapng
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Record, Type

COMMAND, REACTION = TELEGRAMS["2-12"], TELEGRAMS["2-13"]
STATUS, TX, RX, TX_END, RX_END, DATA_LOST, _, FRAMING, PARITY, BREAK, OVERFLOW = range(11)
SOMEWHERE, LOST = Flag.UNLOCATED_ERROR, Flag.LOST_BEFORE


def packet(time_ms: int, event: int, data: bytes = b"") -> tuple[float, bytes]:
    """Seconds, microseconds, event type, control lines, footer, data. The packet's own time is an hour later."""
    return 3_600_000 + time_ms, struct.pack(">IIBBH", T0, time_ms * 1000, event, 0, 0) + data


@pytest.mark.thorough
def test_both_directions(tmp_path: Path) -> None:
    source = pcap(tmp_path / "rtac.pcap", RTAC, [packet(1, TX, COMMAND), packet(40, RX, REACTION)])
    done = run(source, "--baud", "9600")
    assert [(record.line, record.data, record.time_ns - T0 * 10**9) for record in done.records] == [
        (2, COMMAND, 1_000_000),
        (1, REACTION, 40_000_000),
    ]
    assert {record.uncertainty_ns for record in done.records} == {UNCERTAINTY_UNKNOWN}


@pytest.mark.thorough
def test_one_direction_is_a_shared_line(tmp_path: Path) -> None:
    source = pcap(tmp_path / "rtac.pcap", RTAC, [packet(1, RX, COMMAND), packet(40, RX_END, REACTION)])
    assert [(record.line, record.data) for record in run(source, "--baud", "9600").records] == [
        (0, COMMAND),
        (0, REACTION),
    ]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("packets", "flags"),
    [
        pytest.param([(FRAMING, b"A")], [Flag.CHARACTER_ERROR], marks=pytest.mark.thorough),
        pytest.param([(PARITY, b"A")], [Flag.CHARACTER_ERROR], marks=pytest.mark.thorough),
        pytest.param([(BREAK, b"\0")], [Flag.BREAK], marks=pytest.mark.thorough),
        ([(PARITY, b"AB")], [SOMEWHERE, SOMEWHERE]),
        ([(DATA_LOST, b""), (TX, b"Z"), (RX, b"AB")], [LOST, LOST, 0]),  # of which line is not said
        ([(OVERFLOW, b""), (PARITY, b""), (TX, b"Z"), (RX, b"AB")], [0, LOST | SOMEWHERE, SOMEWHERE]),
        pytest.param([(STATUS, b""), (RX, b"A")], [0], marks=pytest.mark.thorough),
        pytest.param([(99, b"A")], [0], marks=pytest.mark.thorough),
    ],
)
def test_errors(tmp_path: Path, packets: list[tuple[int, bytes]], flags: list[int]) -> None:
    source = pcap(tmp_path / "rtac.pcap", RTAC, [packet(i, *each) for i, each in enumerate(packets)])
    done = run(source, "--baud", "9600")
    assert [flag & Flag.FROM_READER for record in done.records for flag in record.flags] == flags


def test_our_own_capture_with_this_link_type(tmp_path: Path) -> None:
    path = tmp_path / "own.pcapng"
    output = Output(str(path))
    writer = PcapngWriter(output, {0: Interface(pcapng.LINKTYPE_RTAC_SERIAL, "x")}, Counters())
    writer.begin()
    writer.write(Record(T0 * 10**9, Type.FRAME, 0, LineSettings(), COMMAND, [0] * 11, bytes(11)))
    output.close()
    assert [record.data for record in run(path, "--baud", "9600").records] == [COMMAND]


@pytest.mark.thorough
def test_a_header_that_is_cut(tmp_path: Path) -> None:
    source = pcap(tmp_path / "rtac.pcap", RTAC, [packet(1, RX, COMMAND), (2, b"\0" * 11), packet(3, RX, REACTION)])
    assert [record.data for record in run(source, "--baud", "9600").records] == [COMMAND, REACTION]


def test_the_rate_has_to_be_told(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    source = pcap(tmp_path / "rtac.pcap", RTAC, [packet(1, RX, COMMAND)])
    assert run(source).code == 2
    assert "does not say at which rate the bus ran" in capfd.readouterr().err
