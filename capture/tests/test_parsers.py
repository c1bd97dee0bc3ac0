# SPDX-License-Identifier: GPL-2.0-or-later
"""Whatever bytes a parser gets: it returns, or raises what its docstring says. Its result does not depend on pieces.

Bytes are random, or valid ones with a part replaced: those get behind the first check.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sistap.commands.annotate import notations
from sistap.commands.annotate.stamps import TimestampParser
from sistap.commands.annotate.textlog import LineCutter
from sistap.commands.extcap.toolbar import _received
from sistap.commands.imports import ch340, ftdi, usbmon
from sistap.commands.imports.usb_kinds import KINDS
from sistap.commands.imports.usb_transfers import Setup
from sistap.commands.parameters import backup
from sistap.dissected.captures import reading
from sistap.dissected.telegrams import values
from sistap.dissected.telegrams.attribute import Attribute
from sistap.dissected.wireshark import rows
from sistap.tap.files import pcapng
from sistap.tap.files.pcapng import Interface
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records import record
from sistap.tap.records.cut import PROCEDURE_3964R, SIS, Cut
from sistap.tap.records.record import Record, Type
from sistap.tap.sis import telegram
from sistap.tap.sis.initialization import Follow
from sistap.tap.sis.told import Told
from sistap.tap.terminal.exits import UsageError
from sistap.tap.wire import protocol
from sistap.tap.wire.protocol import Decoder, Hello

START_NS = 1_700_000_000_000_000_000
TELEGRAM = telegram.build(0x10, 16, 3, b"\x3c\x00\x24\x00", number=5, subaddresses=b"\x02")
RECORD = Record(
    START_NS, Type.FRAME, 0, LineSettings(9600), TELEGRAM, (0,) * len(TELEGRAM), bytes(len(TELEGRAM))
).pack()
CAPTURE = b"".join(
    [
        pcapng.section_header("", ""),
        pcapng.interface_description(Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "line")),
        pcapng.enhanced_packet(0, START_NS, pcapng.upper_pdu("sertap", RECORD)),
    ]
)
WIRE = b"".join(
    [
        protocol.pack_hello(Hello(START_NS, "adapter", "timing")),
        protocol.pack_settings(LineSettings()),
        protocol.pack_read(Read(1, START_NS, b"abc", bytes(3), 5)),
        protocol.pack_time(START_NS),
    ]
)
TOOLBAR = struct.pack(">cBHBB", b"T", 0, 8, 1, 2) + b"marker"


@st.composite
def bytes_like(draw: st.DrawFn, valid: bytes) -> bytes:
    """Draw random bytes, or the valid ones with a part replaced."""
    if draw(st.integers(0, 3)) == 0:
        return draw(st.binary(max_size=400))
    start = draw(st.integers(0, len(valid)))
    end = draw(st.integers(start, min(start + 9, len(valid))))
    return valid[:start] + draw(st.binary(max_size=9)) + valid[end:]


def pieces(data: bytes, size: int) -> Iterator[bytes]:
    return (data[start : start + size] for start in range(0, len(data), size))


@given(bytes_like(CAPTURE))
def test_captures(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = Path(tmp_path_factory.getbasetemp()) / "x.pcapng"
    path.write_bytes(data)
    with suppress(reading.NotCaptured):
        list(reading.packets(path))
    with suppress(reading.NotCaptured):
        list(reading.records(path))


@given(bytes_like((Path(__file__).parent / "drive.par").read_bytes()))
def test_backups_of_drives(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = Path(tmp_path_factory.getbasetemp()) / "x.par"
    path.write_bytes(data)
    with suppress(backup.Damaged):
        for drive in backup.drives(path):
            for saved in drive.parameters:
                values.decoded(saved.attribute, saved.data or b"")


@given(st.integers(0, (1 << 32) - 1), st.text("0123456789.-+eExXabSPinf \n", max_size=50))
def test_values_of_backups(bits: int, text: str) -> None:
    with suppress(values.Unreadable):
        values.encoded(Attribute(bits), text)


@given(bytes_like(RECORD))
def test_records(data: bytes) -> None:
    with suppress(ValueError, IndexError):
        assert record.unpack(data, START_NS).time_ns == START_NS


@given(bytes_like(WIRE), st.integers(1, 40))
def test_the_wire(data: bytes, size: int) -> None:
    def fed(parts: Iterator[bytes]) -> list[protocol.Message]:
        decoder, messages = Decoder(), []
        with suppress(ValueError):
            for part in parts:
                messages += decoder.feed(part)
        return messages

    at_once, in_pieces = fed(iter([data])), fed(pieces(data, size))
    assert in_pieces[: len(at_once)] == at_once  # an error takes what came in the same piece


@given(bytes_like(TELEGRAM * 3), st.sampled_from([SIS, PROCEDURE_3964R]), st.integers(1, 40))
def test_framers_keep_every_character(data: bytes, cut: Cut, size: int) -> None:
    def framed(parts: Iterator[bytes]) -> list[tuple[Type, bytes]]:
        framer = cut.framer(0, LineSettings(9600))
        made: list[Record] = []
        for number, part in enumerate(parts):
            made += framer.feed(Read(0, START_NS + number, part, bytes(len(part)), 0))
        return [(one.type, one.data) for one in made + framer.flush()]

    whole, in_pieces = framed(iter([data])), framed(pieces(data, size))
    assert b"".join(characters for _, characters in whole) == data
    assert b"".join(characters for _, characters in in_pieces) == data
    if cut is SIS:
        assert [one for one in in_pieces if one[0] == Type.FRAME] == [one for one in whole if one[0] == Type.FRAME]


@given(bytes_like(TELEGRAM).filter(lambda data: len(data) >= telegram.STATIC_LENGTH))
def test_telegrams(data: bytes) -> None:
    header = telegram.parse(data)
    telegram.status(header)
    told, follow = Told(), Follow(9600)
    for time_ns in (START_NS, 0):
        told.take(data, time_ns)
        follow.take(data, time_ns)
        follow.due(START_NS)
    assert sum(len(said.telegram) for said in told.telegrams(1000)) <= 1000


def runs(text: str) -> None:
    for notation in notations.NOTATIONS:
        for run in notation.runs(text)[0]:
            assert len(run.data) == len(run.spans())


@given(bytes_like("16.03.2026 09:00:00,123 TX: 02 6C 00 00 00 92 00 00 |.l......|\n".encode("utf-16")))
@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_lines_of_logs(encoding: str, data: bytes) -> None:
    cutter = LineCutter()
    for line in (*cutter.feed(data), *cutter.end()):
        text = getattr(line, "text", "")
        runs(text)
        TimestampParser().find(text)
    text = data.decode(encoding, errors="replace")
    runs(text)
    with suppress(ValueError):
        notations.parse(text)
    rows.columns(("a", "b"), text)


@given(
    st.lists(
        st.from_regex(r"(\d{1,4}[-./]\d\d?[-./]\d{1,4}[T ])?\d\d?:\d\d(:\d\d([.,]\d{1,9})?)?( ?[ap]m)?", fullmatch=True)
    )
)
def test_stamps(texts: list[str]) -> None:
    parser = TimestampParser()
    for text in texts:
        for stamped in parser.find(text):
            assert 0 <= stamped.stamp.time_ns < 1 << 63
        parser.find_date(text)


@given(bytes_like(TOOLBAR * 3))
def test_the_toolbar(data: bytes) -> None:
    assert all(control <= 255 for control, _, _ in _received(io.BytesIO(data)))


@given(st.integers(0, 255), st.integers(0, 255), st.integers(0, 0xFFFF), st.integers(0, 0xFFFF), st.binary(max_size=20))
def test_requests_to_usb_adapters(kind: int, request: int, value: int, place: int, data: bytes) -> None:
    setup = Setup(kind, request, value, place)
    for adapter in KINDS:
        settings = adapter.settings_after(setup, data, LineSettings())
        assert settings.baud >= 0 and 5 <= settings.data_bits <= 8
        transfers = adapter.transfers()
        transfers.asked(setup)
        packets = list(transfers.packets(data))
        assert all(len(characters) == len(flags) for characters, flags in packets)
        assert sum(len(characters) for characters, _ in packets) <= len(data)
        adapter.notified(data)
    assert ftdi.baud_rate(value, place) > 0 and ch340.baud_rate(place) > 0
    assert not data or ftdi.looks_like(data) in (True, False)


USBMON = (
    b"a 1 S Ci:1:002:0 s 80 06 0100 0000 0012 18 <\n"
    b"a 2 C Ci:1:002:0 0 18 = 12010001 ff000008 861a2375 62020002 0001\n"
)


@given(bytes_like(USBMON))
def test_texts_of_usbmon(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    path = Path(tmp_path_factory.getbasetemp()) / "usbmon.txt"
    path.write_bytes(data)
    with suppress(UsageError):
        assert all(transfer.time_ns >= 0 for transfer in usbmon.Transfers(path))
