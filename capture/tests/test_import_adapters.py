# SPDX-License-Identifier: GPL-2.0-or-later
"""The same telegrams through adapters of several makers: the same characters, rate and format, however captured.

Registers are worked out by hand from the drivers of Linux (ch341, cp210x, pl2303) and AN571 of Silicon Labs.
"""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from imported import Imported, run
from usb_captures import (
    CDC_CONFIGURATION,
    CDC_DEVICE,
    CLASS_REQUEST,
    DATA_8E1,
    DIVISOR_9600,
    FT232R,
    SET_BAUD_RATE,
    SET_DATA,
    SET_LINE_CODING,
    STATUS,
    VENDOR_REQUEST,
    Device,
    Host,
    ShortUsbmon,
    Usbmon,
    UsbmonText,
    UsbPcap,
    ch340,
    ch340_by_its_maker,
    cp210x,
    cp210x_with_events,
    device_descriptor,
    line_coding,
    old_cp210x,
    pl2303,
)

from sistap.commands.imports import cdc as cdc_says
from sistap.commands.imports import ch340 as ch340_says
from sistap.commands.imports import cp210x as cp210x_says
from sistap.commands.imports.usb_transfers import Setup
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.sis.telegram import build

RECEIVED, SENT = 1, 2
LINE = LineSettings()  # 9600 8E1
LOST, BAD, BREAK, SOMEWHERE = Flag.LOST_BEFORE, Flag.CHARACTER_ERROR, Flag.BREAK, Flag.UNLOCATED_ERROR

# From public captures: write, read, and a reaction.
WRITE, READ, REACTION = (
    bytes.fromhex(text) for text in ("02D7030300031003040700", "026C000000920000", "02560202109200000002")
)
# Data that look like a status, or like the escape character of a CP210x, with what may follow it.
TRICKY = build(0x10, 16, 3, bytes.fromhex("3C 01 60 02 60 EC EC 00 EC 01 02 EC 02 EC 03 EC"), reaction=True)
LONG = build(0x10, 16, 3, bytes(range(180)), reaction=True)
TELEGRAMS = (WRITE, READ, REACTION, TRICKY, LONG)


def plain(characters: bytes) -> bytes:
    return characters


def with_status(characters: bytes) -> bytes:
    """Full speed: packets of 64 bytes, each with a status in front of 62 characters."""
    starts = range(0, len(characters), 62) or (0,)
    return b"".join(STATUS + characters[start : start + 62] for start in starts)


def with_high_speed_status(characters: bytes) -> bytes:
    """High speed: packets of 512 bytes."""
    starts = range(0, len(characters), 510) or (0,)
    return b"".join(b"\x02\x60" + characters[start : start + 510] for start in starts)


def escaped(characters: bytes) -> bytes:
    return characters.replace(b"\xec", b"\xec\x00")


def opened_ftdi(host: Host) -> None:
    host.request(1, VENDOR_REQUEST, SET_BAUD_RATE, DIVISOR_9600)
    host.request(2, VENDOR_REQUEST, SET_DATA, DATA_8E1)


def opened_cdc(host: Host) -> None:
    host.request(1, CLASS_REQUEST, SET_LINE_CODING, 0, 0, line_coding(9600, 0, 2, 8))
    host.request(2, CLASS_REQUEST, 0x22, 3)


class Form(NamedTuple):
    """An adapter, and how it says things."""

    name: str  # as sistap calls it
    endpoints: tuple[int, int]
    descriptor: bytes
    opened: Callable[[Host], None]
    wrapped: Callable[[bytes], bytes] = plain
    unnamed: str = ""  # its name without descriptors, if that is another
    unopened: str = "unknown"  # its name without requests, too


FORMS = {
    "ftdi": Form("FTDI", (0x81, 0x02), FT232R, opened_ftdi, with_status, unopened="FTDI"),
    "ft232h": Form("FTDI", (0x81, 0x02), FT232R, opened_ftdi, with_high_speed_status, unopened="FTDI"),
    "ch340": Form("CH340", (0x82, 0x02), device_descriptor(0x1A86, 0x7523), ch340),
    "ch340-maker": Form("CH340", (0x82, 0x02), device_descriptor(0x1A86, 0x7523), ch340_by_its_maker),
    "cp210x": Form("CP210x", (0x81, 0x01), device_descriptor(0x10C4, 0xEA60), cp210x),
    "cp210x-old": Form("CP210x", (0x81, 0x01), device_descriptor(0x10C4, 0xEA60), old_cp210x),
    "cp210x-events": Form(
        "CP210x",
        (0x82, 0x02),
        device_descriptor(0x10C4, 0xEA60),
        cp210x_with_events,
        escaped,
        unopened="CP210x with events",
    ),
    "pl2303": Form("PL2303", (0x83, 0x02), device_descriptor(0x067B, 0x2303), pl2303),
    "cdc": Form("CDC", (0x83, 0x04), CDC_DEVICE, opened_cdc),
}
RECORDERS: dict[str, type[Usbmon] | type[UsbPcap]] = {
    "text": UsbmonText,
    "usbmon": Usbmon,
    "usbmon-48": ShortUsbmon,
    "usbpcap": UsbPcap,
}
QUICK = [(form, "text") for form in FORMS] + [("ch340", "usbmon"), ("cp210x", "usbpcap")]
each = pytest.mark.parametrize(
    ("form", "recorder"),
    [
        pytest.param(form, recorder, marks=[] if (form, recorder) in QUICK else pytest.mark.thorough)
        for form in FORMS
        for recorder in RECORDERS
    ],
)


def exchange(form: Form, recorder: Usbmon | UsbPcap, *, described: bool, told: bool, seed: int = 0) -> Host:
    """The telegrams in both directions, in pieces: some fit into a transfer, some end in one of the next."""
    chance = random.Random(seed)
    most = 12 if isinstance(recorder, UsbmonText) else 200
    host = Host(recorder, *form.endpoints)
    if described:
        host.descriptor(0, 1, form.descriptor)
        if form.name == "CDC":
            host.descriptor(0.5, 2, CDC_CONFIGURATION)
    if told:
        form.opened(host)
    time_ms = 100.0
    received = b"".join(TELEGRAMS)
    while received:
        size = chance.randint(1, most)
        host.receive(time_ms, time_ms + 3, form.wrapped(received[:size]))
        received = received[size:]
        if chance.random() < 0.3:
            host.receive(time_ms + 4, time_ms + 5, form.wrapped(b""))
        time_ms += 400
    for telegram in TELEGRAMS:
        for start in range(0, len(telegram), 32):
            host.send(time_ms, time_ms + 1, telegram[start : start + 32])
            time_ms += 400
    return host


def telegrams(done: Imported, line: int) -> list[bytes]:
    return [record.data for record in done.records if record.line == line and record.is_good_frame]


def check(
    tmp_path: Path, form: Form, recorder: type[Usbmon] | type[UsbPcap], *, described: bool, told: bool
) -> Imported:
    host = exchange(form, recorder(), described=described, told=told)
    options = [] if told else ["--baud", "9600"]
    done = run(host.save(tmp_path / "usb"), *options)
    assert done.code == 0
    assert (telegrams(done, RECEIVED), telegrams(done, SENT)) == ([*TELEGRAMS], [*TELEGRAMS])
    assert sum(len(record.data) for record in done.records) == 2 * len(b"".join(TELEGRAMS))
    assert {record.settings for record in done.records} == {LINE}
    assert not any(flag & Flag.FROM_READER for record in done.records for flag in record.flags)
    return done


@each
def test_the_same_telegrams_through_each_adapter(tmp_path: Path, form: str, recorder: str) -> None:
    done = check(tmp_path, FORMS[form], RECORDERS[recorder], described=True, told=True)
    assert f"{FORMS[form].name} adapter 1.5" in done.events[0]
    assert "9600 Bd 8E1, as the adapter was set" in done.events[0]


@each
def test_without_descriptors(tmp_path: Path, form: str, recorder: str) -> None:
    """The requests say what it is. CDC and PL2303 share one request; the second has registers of its own."""
    done = check(tmp_path, FORMS[form], RECORDERS[recorder], described=False, told=True)
    assert f"times of USB transfers ({FORMS[form].name}: its requests" in done.events[0]
    assert "9600 Bd 8E1, as the adapter was set" in done.events[0]


@each
def test_without_descriptors_and_requests_the_telegrams_decide(tmp_path: Path, form: str, recorder: str) -> None:
    done = check(tmp_path, FORMS[form], RECORDERS[recorder], described=False, told=False)
    assert f"times of USB transfers ({FORMS[form].unopened}: 10 good telegrams; read as " in done.events[0]
    if form == "cp210x-events":  # one of them has escape characters
        assert "10 good telegrams; read as plain characters: 9)" in done.events[0]
    assert "9600 Bd 8E1, as given" in done.events[0]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("form", FORMS)
def test_however_the_transfers_are_cut(tmp_path: Path, form: str, seed: int) -> None:
    host = exchange(FORMS[form], UsbmonText(), described=seed % 2 == 0, told=True, seed=seed + 1)
    assert telegrams(run(host.save(tmp_path / "usb.txt")), RECEIVED) == [*TELEGRAMS]


# -- What is known goes before what it looks like ----------------------------------------------------------------------


def test_a_known_vendor_is_never_read_as_another(tmp_path: Path) -> None:
    """Characters that look like a status in each transfer: those of a CH340 are characters."""
    host = Host(UsbmonText(), 0x82, 0x02)
    host.descriptor(0, 1, device_descriptor(0x1A86, 0x7523))
    ch340(host)
    for time_ms in (100, 200, 300):
        host.receive(time_ms, time_ms + 3, STATUS + READ)
    done = run(host.save(tmp_path / "usb.txt"))
    assert b"".join(record.data for record in done.records) == 3 * (STATUS + READ)
    assert "CH340: vendor 1a86" in done.events[0]


def test_an_adapter_with_the_number_of_who_sells_it(tmp_path: Path) -> None:
    host = Host(UsbmonText())
    host.descriptor(0, 1, device_descriptor(0x0856, 0xAC01))
    opened_ftdi(host)
    host.receive(100, 110, STATUS + READ)
    done = run(host.save(tmp_path / "usb.txt"))
    assert [record.data for record in done.records] == [READ]
    assert "FTDI: its requests" in done.events[0]


def test_interfaces_of_cdc_go_before_the_vendor(tmp_path: Path) -> None:
    """The CH343 is of the maker of the CH340, and a CDC adapter."""
    host = Host(Usbmon(), 0x83, 0x04)
    host.descriptor(0, 1, device_descriptor(0x1A86, 0x55D3))
    host.descriptor(0.5, 2, CDC_CONFIGURATION)
    opened_cdc(host)
    host.receive(100, 110, READ)
    done = run(host.save(tmp_path / "usb.pcap"))
    assert "CDC: its interfaces" in done.events[0]
    assert [(record.data, record.settings) for record in done.records] == [(READ, LINE)]


def test_descriptors_of_another_device(tmp_path: Path) -> None:
    other, host = Host(UsbmonText(Device(1, 6))), Host(UsbmonText())
    other.descriptor(0, 1, device_descriptor(0x1A86, 0x7523))
    host.receive(100, 110, STATUS + READ)
    host.packets += other.packets
    done = run(host.save(tmp_path / "usb.txt"), "--baud", "9600")
    assert [record.data for record in done.records] == [READ]
    assert "FTDI adapter 1.5" in done.events[0]


def test_several_adapters_are_named(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    first, second = Host(UsbmonText(), 0x82), Host(UsbmonText(Device(1, 6)))
    ch340(first)
    opened_ftdi(second)
    first.receive(100, 110, WRITE)
    second.receive(101, 111, STATUS + READ)
    first.packets += second.packets
    source = first.save(tmp_path / "usb.txt")
    assert run(source).code == 2
    assert "1.5 (CH340, 9600 Bd 8E1, 11 characters); 1.6 (FTDI, 9600 Bd 8E1, 8 characters)" in capfd.readouterr().err
    assert [record.data for record in run(source, "--device", "1.6").records] == [READ]


def test_requests_of_other_devices_make_no_adapter(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A network adapter has vendor requests with the numbers of FTDI's."""
    host = Host(UsbmonText())
    for request in range(10):
        host.request(request, VENDOR_REQUEST, request, 0)
    host.receive(100, 110, bytes(range(32)))
    assert run(host.save(tmp_path / "usb.txt"), "--baud", "9600").code == 2
    assert "no good telegrams" in capfd.readouterr().err


def test_telegrams_of_another_framing_decide_too(tmp_path: Path) -> None:
    """3964R: data, DLE ETX and their parity, between STX, DLE and DLE."""
    host = Host(UsbmonText())
    for number, (line, data) in enumerate(((1, "02"), (2, "10"), (1, "0141421003 11"), (2, "10"))):
        at = 100 + 20 * number
        if line == 1:
            host.receive(at, at + 1, bytes.fromhex(data))
        else:
            host.send(at, at + 1, bytes.fromhex(data))
    done = run(host.save(tmp_path / "usb.txt"), "--baud", "9600", "--framing", "3964r")
    assert "(unknown: 1 good telegram)" in done.events[0]
    assert b"".join(record.data for record in done.records if record.line == RECEIVED) == bytes.fromhex(
        "020141421003 11"
    )


# -- How rate and format are told --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("registers", "baud"),
    [
        (0xD980, 300),  # 48 MHz / 4096 / 39
        (0xB282, 9600),  # / 64 / 78
        (0xB202, 9600),  # old drivers: without bit 7
        (0xD982, 19200),  # / 64 / 39
        (0xCC83, 115200),  # / 8 / 52: 115385 Bd
        (0xE083, 187500),  # / 8 / 32
        (0xF387, 921600),  # / 4 / 13: 923077 Bd
        (0x0080, 46),  # / 4096 / 256: 45.8 Bd
    ],
)
def test_rates_of_ch340(registers: int, baud: int) -> None:
    assert ch340_says.baud_rate(registers) == baud


@pytest.mark.parametrize(
    ("control", "text"),
    [(0xDB, "8E1"), (0xC3, "8N1"), (0xCB, "8O1"), (0xEB, "8M1"), (0xFB, "8S1"), (0xDA, "7E1"), (0xC7, "8N2")],
)
def test_formats_of_ch340(control: int, text: str) -> None:
    for setup in (Setup(0x40, 0x9A, 0x2518, control), Setup(0x40, 0xA1, control << 8 | 0x9C, 0xB282)):
        assert ch340_says.settings_after(setup, b"", LINE).format == text


@pytest.mark.parametrize(
    "setup",
    [
        Setup(0x40, 0x9A, 0x2518, 0x50),  # drivers before Linux 4.10: no format, the receiver is off
        Setup(0x40, 0xA1, 0x501F, 0xD90A),  # the same drivers: a fixed value
        Setup(0x40, 0x9A, 0x0F2C, 0x0C),  # the fraction of the divisor
        Setup(0x40, 0x9A, 0x2727, 0),  # flow control
        Setup(0xC0, 0x95, 0x1312, 0),  # read
    ],
)
def test_requests_of_ch340_that_set_nothing(setup: Setup) -> None:
    assert ch340_says.settings_after(setup, b"", LINE) == LINE


@pytest.mark.parametrize(
    ("setup", "data", "text"),
    [
        (Setup(0x41, 0x1E, 0, 0), "00c20100", "115200 Bd 8E1"),
        (Setup(0x41, 0x1E, 0, 0), "00c2", "9600 Bd 8E1"),  # cut
        (Setup(0x41, 0x01, 192, 0), "", "19200 Bd 8E1"),  # 3.6864 MHz / 192
        (Setup(0x41, 0x01, 0, 0), "", "9600 Bd 8E1"),
        (Setup(0x41, 0x03, 0x0800, 0), "", "9600 Bd 8N1"),
        (Setup(0x41, 0x03, 0x0712, 0), "", "9600 Bd 7O2"),
        (Setup(0x41, 0x03, 0x0541, 0), "", "9600 Bd 5S1.5"),
        (Setup(0x41, 0x03, 0x0900, 0), "", "9600 Bd 8E1"),  # nine bits cannot be
    ],
)
def test_settings_of_cp210x(setup: Setup, data: str, text: str) -> None:
    assert str(cp210x_says.settings_after(setup, bytes.fromhex(data), LINE)) == text


@pytest.mark.parametrize(
    ("coded", "baud"),
    [
        (0x80000480, 187500),  # 384 MHz / 128 / 4^2
        (0x80010400, 187500),  # of the types TA and TB: / 1024 / 2^1
        (0x8000089C, 9600),  # / 156 / 4^4: 9615 Bd
        (0x80000000, 384_000_000),  # no divisor at all
    ],
)
def test_divisors_of_pl2303(coded: int, baud: int) -> None:
    setup = Setup(CLASS_REQUEST, SET_LINE_CODING, 0, 0)
    assert cdc_says.pl2303_settings_after(setup, line_coding(coded, 0, 2, 8), LINE).baud == baud
    assert cdc_says.settings_after(setup, line_coding(coded, 0, 2, 8), LINE).baud == coded


def test_a_capture_without_the_format_says_so(tmp_path: Path) -> None:
    """Linux tells an old CH340 the rate only."""
    host = Host(UsbmonText(), 0x82, 0x02)
    host.request(1, 0x40, 0xA1, 0)
    host.request(2, 0x40, 0x9A, 0x1312, 0xB282)
    host.receive(100, 110, READ)
    assert "9600 Bd 8E1, the rate as the adapter was set;" in run(host.save(tmp_path / "usb.txt")).events[0]


@pytest.mark.parametrize(("recorder", "stalled"), [(Usbmon, -32), (UsbmonText, -32), (UsbPcap, 0xC0000004)])
def test_a_request_that_fails_sets_nothing(
    tmp_path: Path, recorder: type[Usbmon] | type[UsbPcap], stalled: int
) -> None:
    host = Host(recorder())
    cp210x(host)
    host.request(5, 0x41, 0x1E, 0, 0, (19200).to_bytes(4, "little"), status=stalled)
    host.receive(100, 110, READ)
    assert [record.settings for record in run(host.save(tmp_path / "usb.pcap")).records] == [LINE]


# -- Line errors -------------------------------------------------------------------------------------------------------


def test_events_of_cp210x() -> None:
    """Parity error of B; D after a loss; modem status; the escape character itself; a break."""
    data = b"A" b"\xec\1\4B" b"C" b"\xec\2\2D" b"\xec\3\x10" b"\xec\0" b"\xec\1\x18\0" b"Z"
    for cut in range(len(data)):
        events = cp210x_says.Events(cp210x_says.ESCAPE)
        packets = [packet for part in (data[:cut], data[cut:]) for packet in events.packets(part)]
        assert b"".join(characters for characters, _ in packets) == b"ABCD\xec\0Z"
        assert list(b"".join(flags for _, flags in packets)) == [0, BAD, 0, LOST, 0, BREAK, 0]


def test_an_event_of_cp210x_that_nobody_knows_is_characters() -> None:
    events = cp210x_says.Events(cp210x_says.ESCAPE)
    assert b"".join(characters for characters, _ in events.packets(b"A\xec\x07\xec\xec\0B")) == b"A\xec\x07\xec\xecB"


def test_events_of_cp210x_are_switched_on_and_off(tmp_path: Path) -> None:
    host = Host(UsbmonText(), 0x82, 0x02)
    cp210x(host)
    host.receive(50, 60, TRICKY[:30])
    host.request(70, 0x41, 0x15, 0xEC)
    host.receive(80, 90, escaped(TRICKY)[:20])
    host.receive(91, 99, escaped(TRICKY)[20:])
    host.request(100, 0x41, 0x15, 0)
    host.receive(110, 120, TRICKY[:30])
    done = run(host.save(tmp_path / "usb.txt"))
    assert b"".join(record.data for record in done.records) == 3 * TRICKY


@pytest.mark.parametrize(
    ("name", "notification", "flag"),
    [
        ("ch340", "08 3F 94 EE", 0),  # modem status
        ("pl2303", "A1 20 0000 0000 0200 2000", SOMEWHERE),  # parity
        ("pl2303", "A1 20 0000 0000 0200 4000", LOST),
        ("pl2303", "A1 20 0000 0000 0200 8300", 0),  # modem status
    ],
)
def test_what_interrupt_transfers_say(tmp_path: Path, name: str, notification: str, flag: int) -> None:
    form = FORMS[name]
    host = Host(UsbmonText(), *form.endpoints)
    form.opened(host)
    host.notify(50, 0x81, bytes.fromhex(notification))
    host.receive(100, 110, READ)
    (record,) = run(host.save(tmp_path / "usb.txt")).records
    assert record.data == READ
    assert [each & Flag.FROM_READER for each in record.flags] == [flag, *[0] * 7]


@pytest.mark.parametrize(
    ("recorder", "status", "flag"),
    [
        (Usbmon, -2, 0),  # cancelled, as when a port is closed
        (Usbmon, -75, SOMEWHERE),  # more data than the host has room for
        (UsbmonText, -71, SOMEWHERE),
        (UsbPcap, 0xC0010000, 0),
        (UsbPcap, 0xC0000005, SOMEWHERE),
    ],
)
def test_a_transfer_with_an_error(
    tmp_path: Path, recorder: type[Usbmon] | type[UsbPcap], status: int, flag: int
) -> None:
    host = Host(recorder(), 0x82, 0x02)
    ch340(host)
    host.receive(100, 110, READ, status=status)
    (record,) = run(host.save(tmp_path / "usb.pcap")).records
    assert record.data == READ
    assert {each & Flag.FROM_READER for each in record.flags} == {flag}


# -- The text of usbmon ------------------------------------------------------------------------------------------------


def text(folder: Path, *lines: str) -> Path:
    source = folder / "usbmon.txt"
    source.write_text("\n".join(lines) + "\n")
    return source


OUT = (
    "ffff88003c0e2000 3575914555 S Bo:1:002:2 -115 8 = 026c0000 00920000",
    "ffff88003c0e2000 3575914600 C Bo:1:002:2 0 8 >",
)
IN = "ffff88003c0e2001 3575950555 C Bi:1:002:1 0 12 = 01600256 02021092 00000002"


def test_a_text_of_usbmon(tmp_path: Path) -> None:
    """Behind what somebody has written above; tags and lengths are no characters."""
    done = run(text(tmp_path, "from the forum:", "", *(f"  {line}" for line in OUT), IN), "--baud", "9600")
    assert done.code == 0
    assert [(record.line, record.data) for record in done.records] == [(SENT, READ), (RECEIVED, REACTION)]
    assert "FTDI adapter 1.2" in done.events[0]


def test_the_oldest_form_of_usbmon(tmp_path: Path) -> None:
    """It does not name the bus."""
    done = run(text(tmp_path, *(line.replace(":1:002:", ":002:") for line in OUT)), "--baud", "9600")
    assert [record.data for record in done.records] == [READ]
    assert "adapter 0.2" in done.events[0]


@pytest.mark.parametrize(("last", "first", "elapsed_ms"), [(4_095_999_000, 1_000, 2), (4_294_967_000, 704, 1)])
def test_times_of_usbmon_begin_again(tmp_path: Path, last: int, first: int, elapsed_ms: float) -> None:
    """After 4096 s; in old kernels, after 2^32 us."""
    parts = "0160026c 0000", "01600092 0000"
    lines = [f"1 {us} C Bi:1:002:1 0 6 = {part}" for us, part in zip((last, first), parts, strict=True)]
    (record,) = run(text(tmp_path, *lines), "--baud", "9600").records
    assert record.data == READ
    assert max(record.intervals) / 1e6 == pytest.approx(elapsed_ms)


def test_data_that_the_text_does_not_have(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """usbmon shows 32 bytes of a transfer. A line that is cut is left out, and said."""
    cut = f"1 1000 C Bi:1:002:1 0 40 = {'0160 ' + '41424344 ' * 7 + '4546'}"
    damaged = "2 2000 C Bi:1:002:1 0 40 = 016"
    isochronous = "3 3000 C Zi:1:003:3 0:1:4:0 1 0:0:6 6 = 00000000 0000"
    whole = "4 4000 C Bi:1:002:1 0 10 = 0160026c 00000092 0000"
    done = run(text(tmp_path, cut, damaged, isochronous, whole), "--baud", "9600")
    characters = b"".join(record.data for record in done.records)
    flags = b"".join(record.flags for record in done.records)
    assert characters == b"ABCD" * 7 + b"EF" + READ
    assert [at for at, flag in enumerate(flags) if flag & LOST] == [30]
    assert "line 2 cannot be read" in capfd.readouterr().err


@pytest.mark.parametrize("is_pipe", [False, True])
def test_annotate_takes_no_bytes_from_it(tmp_path: Path, is_pipe: bool) -> None:
    source = text(tmp_path, "from the forum:", *OUT, IN)
    command = [sys.executable, "-m", "sistap", "annotate", "-" if is_pipe else str(source)]
    done = subprocess.run(command, input=source.read_bytes(), capture_output=True, check=False, timeout=60)
    name = "FILE" if is_pipe else source
    said = f"sistap: this is a text of usbmon, not a log: read it with `sistap import {name} -w x.pcapng`\n"
    assert (done.returncode, done.stdout.decode(), done.stderr.decode()) == (2, "", said)
