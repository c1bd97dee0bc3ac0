# SPDX-License-Identifier: GPL-2.0-or-later
"""Our files can be read by three independent readers: tshark, libpcap and python-pcapng."""

from __future__ import annotations

import ctypes
import ctypes.util
import struct
import subprocess
from decimal import Decimal
from pathlib import Path

import pytest
from pcapng import FileScanner
from pcapng.blocks import EnhancedPacket, InterfaceDescription, InterfaceStatistics, SectionHeader
from portable import libpcap
from specification import TELEGRAMS

from sistap.tap.files import pcapng, writer
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import LINK_TYPES, Interface, Statistics
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Record, Type, event

pytestmark = pytest.mark.tap

SETTINGS = LineSettings(9600)
START_NS = 1_700_000_000_123_456_789
TELEGRAM = TELEGRAMS["6-24"]
PCAP_TSTAMP_PRECISION_NANO = 1


def frame(line: int, number: int, *, flag: int = 0, checksum_bad: bool = False) -> Record:
    count = len(TELEGRAM)
    flags = bytes([flag]) + bytes(count - 1)
    return Record(
        START_NS + number, Type.FRAME, line, SETTINGS, TELEGRAM, [0] * count, flags, 1000, checksum_bad=checksum_bad
    )


# Line, flag of a character, checksum; and the packet flags (pcapng, epb_flags) that belong to it.
RECORDS = [
    (frame(0, 1), 0),
    (frame(1, 2), 0x00000001),
    (frame(2, 3), 0x00000002),
    (frame(0, 4, flag=Flag.CHARACTER_ERROR), 0x80000000),
    (frame(0, 5, flag=Flag.BREAK), 0x80000000),
    (frame(0, 6, checksum_bad=True), 0x01000000),
    (frame(2, 7, flag=Flag.CHARACTER_ERROR, checksum_bad=True), 0x81000002),
    (frame(0, 8, flag=Flag.SAME_READ | Flag.INTERVAL_UNKNOWN | Flag.LOST_BEFORE), 0),
    (frame(0, 9, flag=Flag.UNLOCATED_ERROR), 0x80000000),
]


def write(path: Path, link_type: str = "upper-pdu") -> Path:
    counters = Counters()
    output = Output(str(path))
    interface = Interface(
        LINK_TYPES[link_type], "/dev/ttyUSB0", "9600 Bd 8E1", 9600, "FT232R USB UART", "link[5] == 0x10"
    )
    file = writer.PcapngWriter(output, {0: interface}, counters)
    file.begin(event(START_NS, 0, SETTINGS, Event.CAPTURE_STARTED, "latency timer 16 ms"))
    for record, _ in RECORDS:
        counters.add_record(record)
        file.write(record)
    counters.accepted[0] -= 1
    counters.gaps[0] += 1
    file.end(START_NS + 1_000_000_000)
    output.close()
    return path


def tshark(path: Path, *fields: str) -> list[list[str]]:
    arguments = [part for field in fields for part in ("-e", field)]
    out = subprocess.run(
        ["tshark", "-r", str(path), "-T", "fields", *arguments], capture_output=True, text=True, check=True
    ).stdout
    return [line.split("\t") for line in out.splitlines()]


def libpcap_packets(path: Path) -> tuple[int, list[tuple[int, bytes]]]:
    """Link type, and time in ns and bytes of each packet."""

    class Header(ctypes.Structure):
        _fields_ = [("s", ctypes.c_long), ("ns", ctypes.c_long), ("captured", ctypes.c_uint32), ("n", ctypes.c_uint32)]

    pcap = ctypes.CDLL(ctypes.util.find_library("pcap"))
    pcap.pcap_open_offline_with_tstamp_precision.restype = ctypes.c_void_p
    error = ctypes.create_string_buffer(256)
    handle = pcap.pcap_open_offline_with_tstamp_precision(str(path).encode(), PCAP_TSTAMP_PRECISION_NANO, error)
    assert handle, error.value
    file = ctypes.c_void_p(handle)
    header, data = ctypes.POINTER(Header)(), ctypes.POINTER(ctypes.c_ubyte)()
    packets = []
    while (code := pcap.pcap_next_ex(file, ctypes.byref(header), ctypes.byref(data))) == 1:
        found = header.contents
        packets.append((found.s * 1_000_000_000 + found.ns, bytes(data[: found.captured])))
    link_type = pcap.pcap_datalink(file)
    pcap.pcap_close(file)
    assert code == -2  # the end, no error
    return link_type, packets


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("pcapng") / "x.pcapng")


def test_tshark_reads_times_flags_and_interfaces(file: Path) -> None:
    found = tshark(
        file, "frame.time_epoch", "frame.packet_flags", "frame.interface_name", "frame.interface_description"
    )
    times = [START_NS, *(record.time_ns for record, _ in RECORDS)]
    assert [Decimal(row[0]) for row in found] == [Decimal(ns).scaleb(-9) for ns in times]
    assert [int(row[1] or "0", 16) for row in found] == [0, *(flags for _, flags in RECORDS)]
    assert {row[2] for row in found} == {"/dev/ttyUSB0"}
    lines = [0, *(record.line for record, _ in RECORDS)]
    descriptions = {0: "9600 Bd 8E1", 1: "9600 Bd 8E1, line 1", 2: "9600 Bd 8E1, line 2"}
    assert [row[3] for row in found] == [descriptions[line] for line in lines]


def test_capinfos_names_adapter_speed_and_filter(file: Path) -> None:
    out = subprocess.run(["capinfos", str(file)], capture_output=True, text=True, check=True).stdout
    for text in ("Hardware = FT232R USB UART", "Speed = 9600", "Filter string = link[5] == 0x10", "nanoseconds (9)"):
        assert text in out
    assert "Number of interfaces in file: 3" in out


@libpcap
def test_libpcap_reads_times_and_bytes(file: Path) -> None:
    link_type, packets = libpcap_packets(file)
    assert link_type == 252
    wrapped = b"\x00\x0c\x00\x08sertap\0\0" + bytes(4)  # upper PDU: tag 12 "sertap", end of tags
    assert packets[1:] == [(record.time_ns, wrapped + record.pack()) for record, _ in RECORDS]
    assert packets[0][1].endswith(b"latency timer 16 ms")


def test_python_pcapng_reads_everything(file: Path) -> None:
    with file.open("rb") as stream:
        blocks = list(FileScanner(stream))
    assert isinstance(blocks[0], SectionHeader)
    assert blocks[0].options["shb_userappl"].startswith("sistap ")
    interfaces = [block for block in blocks if isinstance(block, InterfaceDescription)]
    assert [block.options["if_speed"] for block in interfaces] == [9600] * 3
    assert {block.options["if_name"] for block in interfaces} == {"/dev/ttyUSB0"}
    packets = [block for block in blocks if isinstance(block, EnhancedPacket)]
    assert [block.interface_id for block in packets] == [0, 0, 1, 2, 0, 0, 0, 2, 0, 0]
    statistics = [block for block in blocks if isinstance(block, InterfaceStatistics)]
    assert [(s.options["isb_ifrecv"], s.options["isb_filteraccept"], s.options["isb_osdrop"]) for s in statistics] == [
        (6, 5, 1),
        (1, 1, 0),
        (2, 2, 0),
    ]


@libpcap
@pytest.mark.parametrize(("name", "number"), [("user0", 147), ("user15", 162)])
def test_user_link_types_have_only_telegrams(tmp_path: Path, name: str, number: int) -> None:
    link_type, packets = libpcap_packets(write(tmp_path / "x.pcapng", name))
    assert link_type == number
    assert packets == [(record.time_ns, TELEGRAM) for record, _ in RECORDS]


@libpcap
def test_rtac_has_its_header_and_hands_the_telegram_on(tmp_path: Path) -> None:
    file = write(tmp_path / "x.pcapng", "rtac")
    assert libpcap_packets(file)[0] == 250
    found = tshark(file, "rtacser.timestamp", "rtacser.eventtype", "data.data")
    # Received; sent for line 2; parity error; break; data lost before.
    assert [int(row[1], 16) for row in found] == [2, 2, 1, 8, 9, 2, 8, 5, 2]
    assert {row[0] for row in found} == {"1700000000.123456000"}
    assert {row[2] for row in found} == {TELEGRAM.hex()}


def test_without_parity_an_error_is_one_of_framing() -> None:
    record = frame(0, 1, flag=Flag.CHARACTER_ERROR)
    assert writer.rtac_event(record._replace(settings=LineSettings(9600, 8, "N"))) == 7


@libpcap
def test_rtac_leaves_control_lines_and_footer_zero(tmp_path: Path) -> None:
    _, packets = libpcap_packets(write(tmp_path / "x.pcapng", "rtac"))
    # Seconds, microseconds, event, control lines, footer.
    assert packets[0][1] == struct.pack(">IIBBH", 1_700_000_000, 123_456, 2, 0, 0) + TELEGRAM


# By hand from the draft: type, length, what is in it, options, length.
SECTION = (
    "0A0D0D0A 34000000 4D3C2B1A 0100 0000 FFFFFFFFFFFFFFFF"  # byte order, version 1.0, length not known
    "0300 0500 4C696E7578 000000"  # shb_os
    "0400 0300 736973 00"  # shb_userappl
    "0000 0000 34000000"
)
LINE = (
    "01000000 28000000 FC00 0000 00000000"  # link type 252, reserved, no limit of a packet's length
    "0200 0400 74747930"  # if_name
    "0900 0100 09 000000"  # if_tsresol: ns
    "0000 0000 28000000"
)
PACKET = (
    "06000000 24000000 02000000 01000000 02000000 03000000 03000000"  # interface, time, lengths
    "616263 00 24000000"  # no options
)


COUNTERS = (
    "05000000 58000000 01000000 03000000 04000000"  # interface, time
    "0200 0800 03000000 01000000"  # isb_starttime
    "0300 0800 03000000 04000000"  # isb_endtime
    "0400 0800 0700000000000000"  # isb_ifrecv
    "0600 0800 0600000000000000"  # isb_filteraccept
    "0700 0800 0100000000000000"  # isb_osdrop
    "0000 0000 58000000"
)


@pytest.mark.parametrize(
    ("block", "by_hand"),
    [
        (pcapng.section_header("sis", "Linux"), SECTION),
        (pcapng.interface_description(Interface(252, "tty0")), LINE),
        (pcapng.enhanced_packet(2, (1 << 32) + 2, b"abc"), PACKET),
        (pcapng.interface_statistics(1, Statistics((3 << 32) + 1, (3 << 32) + 4, 7, 6, 1)), COUNTERS),
    ],
    ids=["section", "interface", "packet", "statistics"],
)
def test_a_block_is_as_the_draft_says(block: bytes, by_hand: str) -> None:
    assert block.hex(" ") == bytes.fromhex(by_hand).hex(" ")


def test_a_block_is_as_long_as_it_says() -> None:
    for size in range(9):
        block = pcapng.enhanced_packet(0, START_NS, bytes(size), 1)
        assert len(block) % 4 == 0
        assert block[4:8] == block[-4:] == len(block).to_bytes(4, "little")
