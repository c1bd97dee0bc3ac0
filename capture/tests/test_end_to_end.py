# SPDX-License-Identifier: GPL-2.0-or-later
"""From the virtual bus through a real capture into a file: everything that was sent is there, once and in order."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from independent import Packet, packets
from portable import signals
from test_bus import MANY_FAULTS_TEXT, TIMEOUT_S, expected_of, finish, logged, running

from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import Record, Type
from sistap.tap.sis.telegram import checksum_good

# python-pcapng warns of itself.
pytestmark = pytest.mark.filterwarnings("ignore:Field type should not be:DeprecationWarning")

CAPTURE = [sys.executable, "-m", "sistap", "capture", "-q"]
CRC_ERROR, SYMBOL_ERROR = 1 << 24, 1 << 31


def frames(captured: list[Packet]) -> list[bytes]:
    return [packet.record.data for packet in captured if packet.record.type == Type.FRAME]


def received(captured: list[Packet]) -> list[tuple[int, int]]:
    """Join the characters of all records, with the reader's statements on each."""
    return [
        (value, flags & Flag.FROM_READER)
        for packet in captured
        if packet.record.type != Type.EVENT
        for value, flags in zip(packet.record.data, packet.record.flags, strict=True)
    ]


def capture(*options: str) -> int:
    result = subprocess.run([*CAPTURE, *options], capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert "Traceback" not in result.stderr
    return result.returncode


def tshark_counts(path: Path) -> int:
    with Tshark() as tshark:
        return len(tshark.output("-r", str(path), "-T", "fields", "-e", "frame.number").splitlines())


def test_every_telegram_goes_through_a_pty_into_the_file_once_in_order(tmp_path: Path) -> None:
    log, file = tmp_path / "log", tmp_path / "file.pcapng"
    with running("--baud", "115200", "--cycles", "1", "--log", str(log)) as (bus, port):
        # The end of the bus is an unplugged adapter: what came is saved, exit code 1.
        assert capture("-i", port, "--baud", "115200", "-w", str(file)) == 1
        assert finish(bus) == (0, "")
    captured = packets(file)
    sent = logged(log)
    assert frames(captured) == [played.sent for played in sent if "ascii" not in played.marks]
    assert all(checksum_good(frame) for frame in frames(captured))
    assert received(captured) == [(value, 0) for played in sent for value in played.sent]
    assert all(packet.flags == 0 for packet in captured)
    times = [packet.record.time_ns for packet in captured]
    assert times == sorted(times)
    assert tshark_counts(file) == len(captured)


@signals
def test_a_capture_may_end_while_the_bus_goes_on(tmp_path: Path) -> None:
    log, file = tmp_path / "log", tmp_path / "file.pcapng"
    with running("--baud", "115200", "--log", str(log)) as (bus, port):
        assert capture("-i", port, "--baud", "115200", "-w", str(file), "-c", "20") == 0
        bus.terminate()
        assert finish(bus) == (0, "")
    captured = [packet.record.data for packet in packets(file) if packet.record.type != Type.EVENT]
    assert len(captured) == 20
    assert captured == [played.sent for played in logged(log)][:20]


@pytest.mark.parametrize("most", [1, 10])
def test_faults_are_flagged_at_their_characters(tmp_path: Path, most: int) -> None:
    log, file = tmp_path / "log", tmp_path / "file.pcapng"
    options = ["--fast", "--cycles", "5", "--reads", str(most), "--faults", MANY_FAULTS_TEXT, "--log", str(log)]
    with running("--listen", "127.0.0.1:0", *options) as (bus, port):
        assert capture("-i", port, "-w", str(file)) == 1
        assert finish(bus) == (0, "")
    captured = packets(file)
    sent = logged(log)
    assert received(captured) == expected_of(sent)
    for record, _, flags in captured:
        errors = any(flag & (Flag.CHARACTER_ERROR | Flag.BREAK) for flag in record.flags)
        assert bool(flags & SYMBOL_ERROR) is errors
        wrong = record.type == Type.FRAME and not checksum_good(record.data)
        assert bool(flags & CRC_ERROR) is wrong
    # A pause disturbs no telegram; what is undisturbed is found whatever stood before it. (Checksums alone do not say
    # what is undisturbed: two parity errors can make up for each other.)
    whole = [played.sent for played in sent if all(mark.startswith("pause@") for mark in played.marks)]
    assert 0 < len(whole) < len(sent)
    assert [packet.record.data for packet in captured if undisturbed(packet.record)] == whole


def undisturbed(record: Record) -> bool:
    if record.type != Type.FRAME or not checksum_good(record.data):
        return False
    first = record.flags[0] & Flag.FROM_READER & ~Flag.LOST_BEFORE  # what was lost before it is not its own
    return not first and not any(flag & Flag.FROM_READER for flag in record.flags[1:])


def test_simulated_times_come_through_to_the_nanosecond(tmp_path: Path) -> None:
    log, file = tmp_path / "log", tmp_path / "file.pcapng"
    options = ["--fast", "--cycles", "2", "--faults", "pause=0.02", "--log", str(log)]
    with running("--listen", "127.0.0.1:0", *options) as (_, port):
        capture("-i", port, "-w", str(file))
    match = re.search(r"time 0 is (\d+) ns", log.read_text())
    assert match
    captured = [packet.record for packet in packets(file) if packet.record.type == Type.FRAME]
    sent = [played for played in logged(log) if "ascii" not in played.marks]
    assert len(captured) == len(sent)
    for record, played in zip(captured, sent, strict=True):
        assert record.time_ns - int(match[1]) == played.time_ns
        assert record.uncertainty_ns == 0
        # TzA is 5 ms at this rate
        late = {f"pause@{place}" for place, interval in enumerate(record.intervals) if place and interval > 5_000_000}
        assert late == set(played.marks)
