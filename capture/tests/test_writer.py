# SPDX-License-Identifier: GPL-2.0-or-later
"""Successive files: each can be read alone, and describes its lines as they are when it begins."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import Any

import independent
import pytest
from pcapng.blocks import EnhancedPacket, InterfaceDescription, InterfaceStatistics

from sistap.tap.files import writer
from sistap.tap.files.output import FileLimits, Output
from sistap.tap.files.pcapng import LINK_TYPES, LINKTYPE_USER0, LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import Blocks, PcapngWriter
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Record, Type, event
from sistap.tap.sis.telegram import build

# python-pcapng warns of itself.
pytestmark = [
    pytest.mark.tap,
    pytest.mark.filterwarnings("ignore:Field type should not be:DeprecationWarning"),
]

SLOW, FAST = LineSettings(9600), LineSettings(57600)
FIRST_NS, SECOND_NS, NOW_NS, LATER_NS = 1000, 2000, 9000, 9500


def frame(line: int, time_ns: int, settings: LineSettings = SLOW) -> Record:
    return Record(time_ns, Type.FRAME, line, settings, b"x" * 2000, [0] * 2000, bytes(2000))


def started(line: int, time_ns: int) -> Record:
    return event(time_ns, line, SLOW, Event.CAPTURE_STARTED, "from a test")


class Writing:
    """A writer of two lines in files of at least so many bytes, and what is in them."""

    def __init__(
        self, folder: Path, link_type: int = LINKTYPE_WIRESHARK_UPPER_PDU, *, files: int | None = None, size: int = 1000
    ) -> None:
        self.output = Output(str(folder / "x"), FileLimits(size=size, several=True, files=files))
        interfaces = {line: Interface(link_type, f"/dev/ttyS{line}") for line in (1, 2)}
        self.writer = PcapngWriter(self.output, interfaces, Counters())
        self.writer.begin(started(1, FIRST_NS), started(2, SECOND_NS))
        self._folder = folder

    def files(self) -> list[list[Any]]:
        """End the last file; return all blocks of each."""
        self.writer.end(LATER_NS)
        self.output.close()
        return [independent.blocks(path) for path in sorted(self._folder.iterdir())]


def of(kind: type, blocks: list[Any]) -> list[Any]:
    return [block for block in blocks if isinstance(block, kind)]


def records(blocks: list[Any]) -> list[Record]:
    return [independent.record_of(block) for block in of(EnhancedPacket, blocks)]


def test_each_file_describes_both_lines_though_one_is_silent(tmp_path: Path) -> None:
    writing = Writing(tmp_path)
    for time_ns in (SECOND_NS, NOW_NS):
        assert writing.writer.write(frame(2, time_ns))
    files = writing.files()
    assert len(files) == 2
    for blocks in files:
        names = [block.options["if_name"] for block in blocks[1:3]]  # before all packets
        assert names == ["/dev/ttyS1", "/dev/ttyS2"]
        assert len(of(InterfaceDescription, blocks)) == 2
        codes = [(block.interface_id, independent.record_of(block).event) for block in of(EnhancedPacket, blocks)]
        assert codes[:3] == [(0, Event.CAPTURE_STARTED), (1, Event.CAPTURE_STARTED), (1, Event.NONE)]
        assert [block.interface_id for block in of(InterfaceStatistics, blocks)] == [0, 1]


def test_after_the_last_file_no_other_is_begun(tmp_path: Path) -> None:
    writing = Writing(tmp_path, files=1)
    for time_ns in (SECOND_NS, NOW_NS):
        assert writing.writer.write(frame(2, time_ns))
    writing.writer.look(LATER_NS)
    (blocks,) = writing.files()
    assert [record.event for record in records(blocks)] == [Event.CAPTURE_STARTED] * 2 + [Event.NONE] * 2


def telegram(data: bytes, time_ns: int) -> Record:
    return Record(time_ns, Type.FRAME, 1, SLOW, data, [0] * len(data), bytes(len(data)))


def test_no_file_ends_between_a_command_and_its_reaction(tmp_path: Path) -> None:
    """Nor inside long data: bit 2 of the control byte 38 says that more follows."""
    writing = Writing(tmp_path)
    writing.writer.write(frame(1, SECOND_NS))  # the file is full
    read = build(0x10, 16, 3, b"\x3c\3\0\x24\0")
    long = [read, build(0x10, 16, 3, b"\0\x38\3A", reaction=True), read]
    last = build(0x10, 16, 3, b"\0\x3c\3B", reaction=True)
    for data in [*long, last, read]:
        writing.writer.write(telegram(data, NOW_NS))
    contents = [[one.data for one in records(blocks) if one.type == Type.FRAME] for blocks in writing.files()]
    assert contents == [[b"x" * 2000], [*long, last], [read]]


def test_a_file_does_not_wait_for_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """For a reaction, some records."""
    monkeypatch.setattr(writer, "MOST_AWAITED", 10)
    writing = Writing(tmp_path)
    command = build(0x12, 16, 3)
    for _ in range(100):
        writing.writer.write(telegram(command, NOW_NS))
    counts = [sum(one.type == Type.FRAME for one in records(blocks)) for blocks in writing.files()]
    assert len(counts) > 4 and max(counts) <= 20


def test_a_full_file_takes_so_many_records_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "MOST_AWAITED", 10)
    writing = Writing(tmp_path)
    writing.writer.write(telegram(build(0x12, 16, 3), NOW_NS))
    writing.writer.write(frame(2, NOW_NS))  # the file is full
    for _ in range(12):
        writing.writer.write(telegram(build(0x12, 16, 3), NOW_NS))
    first, second = ([one for one in records(blocks) if one.type == Type.FRAME] for blocks in writing.files())
    assert (len(first), len(second)) == (2 + 10, 2)


def test_a_file_names_the_system_of_its_tap() -> None:
    interfaces = {0: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "x")}
    here = f"{platform.system()} {platform.release()}".encode()
    assert here in Blocks(interfaces).section()
    assert here not in Blocks(interfaces, "").section()  # a simulated one
    assert b"Windows 11" in Blocks(interfaces, "Windows 11").section()


def test_what_was_told_leaves_room_for_records(tmp_path: Path) -> None:
    """It takes at most a quarter of a file; the newest stays. In it, 13 and 15 characters take 148 and 160 bytes."""
    writing = Writing(tmp_path, size=4000)
    for number in range(40):
        ident = bytes([0, number, 0])
        writing.writer.write(telegram(build(0x10, 16, 3, b"\x14\3" + ident), NOW_NS))
        writing.writer.write(telegram(build(0x10, 16, 3, b"\0\x14\3Name", reaction=True), NOW_NS))
    *_, blocks = writing.files()
    told = [one for one in records(blocks) if one.type == Type.BEFORE]
    first = next(one for one in records(blocks) if one.type == Type.FRAME).data[11]
    assert [one.data[11] for one in told[::2]] == [first - 3, first - 2, first - 1]


def test_what_an_older_capture_left_is_gone(tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(b"older" * 1000)
    output = Output(str(path), force=True)
    writer = PcapngWriter(output, {0: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "/dev/ttyS0")}, Counters())
    writer.begin(started(0, FIRST_NS))
    output.close()
    assert len(independent.blocks(path)) == 3


def test_the_link_types() -> None:
    """Those of tcpdump.org."""
    users = {f"user{number}": 147 + number for number in range(16)}
    assert {"upper-pdu": 252, "rtac": 250, **users} == LINK_TYPES


def test_a_file_begins_with_the_settings_of_now(tmp_path: Path) -> None:
    writing = Writing(tmp_path)
    writing.writer.write(frame(2, SECOND_NS, FAST))
    writing.writer.look(NOW_NS)
    _, blocks = writing.files()
    assert [(record.line, record.settings) for record in records(blocks)] == [(1, SLOW), (2, FAST), (2, FAST)]
    times = [block.timestamp_high << 32 | block.timestamp_low for block in of(EnhancedPacket, blocks)]
    assert times == [NOW_NS] * 3


def start_and_end_ns(statistics: Any) -> tuple[int, ...]:
    raw = [statistics.options.get_raw(name) for name in ("isb_starttime", "isb_endtime")]
    return tuple(int.from_bytes(value[:4], "little") << 32 | int.from_bytes(value[4:], "little") for value in raw)


def test_statistics_count_from_the_start_of_the_capture(tmp_path: Path) -> None:
    writing = Writing(tmp_path)
    writing.writer.write(frame(2, SECOND_NS))
    writing.writer.look(NOW_NS)
    first, second = writing.files()
    for blocks, end_ns in ((first, NOW_NS), (second, LATER_NS)):
        for statistics in of(InterfaceStatistics, blocks):
            assert start_and_end_ns(statistics) == (FIRST_NS, end_ns)


def test_a_link_type_without_a_place_for_it_leaves_it_out(tmp_path: Path) -> None:
    writing = Writing(tmp_path, LINKTYPE_USER0)
    assert not writing.writer.write(frame(1, NOW_NS)._replace(type=Type.OTHER))
    assert writing.writer.write(frame(1, NOW_NS))
    (blocks,) = writing.files()
    assert [block.packet_data for block in of(EnhancedPacket, blocks)] == [b"x" * 2000]
