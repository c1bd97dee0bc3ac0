# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters out of USB captures: values, errors, line settings, and between which times they were on the line.

Expected times are worked out by hand from the times of the transfers, in ms since the first.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from imported import run
from specification import TELEGRAMS
from usb_captures import (
    BULK,
    CLASS_REQUEST,
    FT232R,
    SET_BAUD_RATE,
    SET_DATA,
    SET_LATENCY_TIMER,
    SET_LINE_CODING,
    STATUS,
    T0,
    VENDOR_REQUEST,
    Device,
    Host,
    Usbmon,
    UsbPcap,
    cdc,
    ftdi,
    line_coding,
    pcap,
)

from sistap.commands.imports import cdc as cdc_says
from sistap.commands.imports import ftdi as ftdi_says
from sistap.commands.imports.dissected import nanoseconds
from sistap.commands.imports.usb_transfers import Setup
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings
from sistap.tap.records.record import Record

LINE = LineSettings()  # 9600 8E1
COMMAND, REACTION = TELEGRAMS["2-12"], TELEGRAMS["2-13"]
CHARACTER_MS = 11 / 9.6  # 8E1 at 9600 Bd
SHARED, RECEIVED, SENT = 0, 1, 2


def time_ms(record: Record) -> float:
    """Of its first character, since the capture began."""
    return (record.time_ns - T0 * 10**9) / 1e6


def uncertainty_ms(record: Record) -> float:
    return record.uncertainty_ns / 1e6


def characters(records: list[Record], line: int) -> bytes:
    return b"".join(record.data for record in records if record.line == line)


def dissected(capture: Path, *fields: str, only: str = "frame") -> list[str]:
    """Return what Wireshark's own dissectors say about the packets that pass a filter and have any of these fields."""
    arguments = ["-n", "-r", str(capture), "-Y", only, "-T", "fields"]
    arguments += [word for field in fields for word in ("-e", field)]
    with Tshark() as tshark:
        return [line for line in tshark.output(*arguments).splitlines() if line.strip()]


def test_the_fixtures_are_ftdi_to_wireshark(tmp_path: Path) -> None:
    host = ftdi()
    host.receive(4, 20, STATUS + REACTION)
    host.receive(20, 36, b"\x01\x66" + b"A")
    host.send(40, 40.2, COMMAND)
    source = host.save(tmp_path / "usb.pcap")
    fields = ["ftdi-ft.bRequest", "ftdi-ft.if_a_rx_payload", "ftdi-ft.if_a_tx_payload"]
    assert dissected(source, *fields) == [
        "3\t\t",
        "4\t\t",
        "9\t\t",
        f"\t{REACTION.hex()}\t",
        "\t41\t",
        f"\t\t{COMMAND.hex()}",
    ]
    assert dissected(source, "ftdi-ft.bRequest", only="ftdi-ft.hValue.parity == 2 && ftdi-ft.lValue == 8") == ["4"]
    assert dissected(source, "ftdi-ft.bRequest", only="ftdi-ft.lValue == 16") == ["9"]  # latency timer
    assert dissected(source, "ftdi-ft.if_a_rx_payload", only="ftdi-ft.line_status.b2 == 1") == ["41"]  # parity error


def test_the_fixtures_are_cdc_to_wireshark(tmp_path: Path) -> None:
    host = cdc()
    host.notify(10, 0x82, bytes.fromhex("A1 20 0000 0000 0200 0000"))
    fields = ["usbcom.control.request_code", "usbcom.interrupt.notification_code"]
    assert dissected(host.save(tmp_path / "usb.pcap"), *fields) == ["0x20\t", "\t0x20"]


@pytest.mark.thorough
@pytest.mark.parametrize("recorder", [Usbmon, UsbPcap])
def test_the_adapter_says_how_it_was_set(tmp_path: Path, recorder: type[Usbmon] | type[UsbPcap]) -> None:
    host = ftdi(recorder())
    host.receive(4, 20, STATUS + REACTION)
    done = run(host.save(tmp_path / "usb.pcap"))
    assert done.code == 0
    assert [(record.settings, record.data, record.flags) for record in done.records] == [
        (LineSettings(9600, 8, "E", 2), REACTION, bytes([0x20] + [0x01] * (len(REACTION) - 1)))
    ]
    assert "9600 Bd 8E1, as the adapter was set" in done.events[0]


def test_it_is_known_by_its_requests_or_by_its_status_alone(tmp_path: Path) -> None:
    host = Host(Usbmon())
    host.receive(4, 20, STATUS)
    host.receive(20, 36, STATUS + REACTION)
    done = run(host.save(tmp_path / "usb.pcap"), "--baud", "19200", "--format", "8N1")
    assert [(record.settings, record.data) for record in done.records] == [(LineSettings(19200, 8, "N", 2), REACTION)]
    assert "19200 Bd 8N1, as given" in done.events[0]


def test_without_a_rate_it_says_what_to_add(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    host = Host(Usbmon())
    host.receive(4, 20, STATUS + REACTION)
    source = host.save(tmp_path / "usb.pcap")
    assert run(source).code == 2
    said = capfd.readouterr().err
    assert said == (
        f"sistap: {source} does not say at which rate the bus ran (its port was opened before the capture began): add "
        "it, such as --baud 9600\n"
    )


@pytest.mark.parametrize(
    ("value", "place", "baud"),
    [
        (0x2710, 0, 300),  # 3 MHz / 10000
        (0x4138, 0, 9600),  # / 312.5
        (0x809C, 0, 19200),  # / 156.25
        (0xC04E, 0, 38400),  # / 78.125
        (0xC034, 0, 57600),  # / 52.125: 57554 Bd
        (0x001A, 0, 115200),  # / 26: 115385 Bd
        (0x001A, 1, 115200),  # the port, of a chip with several: as a fraction it would be 113744 Bd
        (0x04E2, 0x0201, 9600),  # 12 MHz / 1250, port 1
        (0x0068, 0x0201, 115200),  # 12 MHz / 104
        (0x0000, 0, 3_000_000),
        (0x0001, 0, 2_000_000),
        (0x0002, 0, 1_500_000),
        (0x0040, 0, 46_875),  # no usual rate is near
        (0xC013, 0, 156_863),  # / 19.125
        (0x8010, 0, 184_615),  # / 16.25
        (0x4010, 0, 181_818),  # / 16.5
    ],
)
def test_rates_of_ftdi(value: int, place: int, baud: int) -> None:
    assert ftdi_says.baud_rate(value, place) == baud


@pytest.mark.parametrize(
    ("value", "text"), [(0x0008, "8N1"), (0x0108, "8O1"), (0x0307, "7M1"), (0x0408, "8S1"), (0x1008, "8N2")]
)
def test_formats_of_ftdi(value: int, text: str) -> None:
    after = ftdi_says.settings_after(Setup(VENDOR_REQUEST, SET_DATA, value, 0), b"", LineSettings())
    assert after.format == text


def test_a_rate_that_changes_is_an_event(tmp_path: Path) -> None:
    host = ftdi()
    host.receive(4, 20, STATUS + b"A")
    host.request(30, VENDOR_REQUEST, SET_BAUD_RATE, 0x001A)
    host.receive(31, 40, STATUS + b"B")
    done = run(host.save(tmp_path / "usb.pcap"))
    assert [(record.settings.baud, record.data) for record in done.records] == [(9600, b"A"), (115200, b"B")]
    assert done.events[1:] == ["115200 Bd 8E1: as the adapter was set"]


def test_the_status_of_each_packet_is_taken_out(tmp_path: Path) -> None:
    first, second = bytes(range(62)), bytes(range(100, 110))
    host = ftdi()
    host.receive(4, 80, STATUS + first + b"\x01\x60" + second)
    high_speed = b"\x02\x60" + bytes(range(200)) + bytes(range(200)) + bytes(110)
    host.receive(80, 900, high_speed + b"\x02\x60" + second)
    done = run(host.save(tmp_path / "usb.pcap"))
    assert characters(done.records, SHARED) == first + second + high_speed[2:] + second


LOST, BAD, BREAK, SOMEWHERE = Flag.LOST_BEFORE, Flag.CHARACTER_ERROR, Flag.BREAK, Flag.UNLOCATED_ERROR


@pytest.mark.parametrize(
    ("status", "sent", "flags"),
    [
        (0x02, b"AB", [LOST | SOMEWHERE, SOMEWHERE]),  # overrun: before one of them
        (0x04, b"A", [BAD]),  # parity
        (0x08, b"A", [BAD]),  # framing
        (0x18, b"\0", [BREAK]),
        (0x04, b"AB", [SOMEWHERE, SOMEWHERE]),
        (0x1A, b"AB", [LOST | SOMEWHERE, SOMEWHERE]),
        (0x64, b"", []),  # reported again and again until it is fetched: says nothing
    ],
)
def test_line_errors_of_ftdi(status: int, sent: bytes, flags: list[int]) -> None:
    packets = list(ftdi_says.Packets().packets(bytes([0x01, status]) + sent))
    assert [flag for _, each in packets for flag in each] == flags


def test_line_errors_are_at_their_characters(tmp_path: Path) -> None:
    host = ftdi()
    host.receive(4, 20, b"\x01\x04" + b"A")
    host.receive(20, 80, STATUS + bytes(62) + b"\x01\x0a" + b"YZ")
    records = run(host.save(tmp_path / "usb.pcap")).records
    flags = [flag & Flag.FROM_READER for record in records for flag in record.flags]
    assert flags == [BAD, *[0] * 62, LOST | SOMEWHERE, SOMEWHERE]


@pytest.mark.thorough
def test_no_earlier_than_the_latency_timer(tmp_path: Path) -> None:
    """The host asks all the time, so a transfer comes every 5 ms; each can be a USB frame (1 ms) late."""
    host = ftdi(latency_ms=5)
    host.receive(4, 30, STATUS)
    host.receive(30, 40, STATUS + b"A")  # a host that was slow: but it asked
    host.receive(40, 43, STATUS + b"B")  # emptied 3 ms before
    records = run(host.save(tmp_path / "usb.pcap")).records
    assert [(time_ms(record), uncertainty_ms(record)) for record in records] == [(40, 6)]  # the worse of A and B
    host = ftdi(latency_ms=5)
    host.receive(4, 30, STATUS)
    host.receive(30, 33, STATUS + b"B")
    assert uncertainty_ms(run(host.save(tmp_path / "usb.pcap")).records[0]) == 4


def test_without_a_latency_timer_in_the_capture_it_is_16_ms(tmp_path: Path) -> None:
    host = ftdi(latency_ms=None)
    host.receive(4, 30, STATUS + b"A")
    done = run(host.save(tmp_path / "usb.pcap"))
    assert uncertainty_ms(done.records[0]) == 17
    assert "latency timer 16 ms, as by default" in done.events[0]


@pytest.mark.thorough
def test_the_latency_timer_of_the_time_when_characters_came(tmp_path: Path) -> None:
    """Before, another program had set it to 16 ms; closing the port restores it."""
    host = ftdi()
    host.request(4, VENDOR_REQUEST, SET_LATENCY_TIMER, 1)
    host.receive(5, 6, STATUS + b"A")
    host.request(40, VENDOR_REQUEST, SET_LATENCY_TIMER, 16)
    done = run(host.save(tmp_path / "usb.pcap"))
    assert "latency timer 1 ms, and a USB frame" in done.events[0]
    host.receive(50, 60, STATUS + b"B")
    done = run(host.save(tmp_path / "usb.pcap"))
    assert "latency timer 1 and 16 ms, and a USB frame" in done.events[0]


def test_a_host_that_does_not_ask_leaves_characters_waiting(tmp_path: Path) -> None:
    """Emptied at 30, asked at 80, delivered at once: it may have come right after 30."""
    host = ftdi()
    host.receive(4, 30, STATUS)
    host.receive(80, 80.5, STATUS + b"A")
    assert uncertainty_ms(run(host.save(tmp_path / "usb.pcap")).records[0]) == pytest.approx(51.5)


@pytest.mark.thorough
def test_a_full_transfer_does_not_empty_the_adapter(tmp_path: Path) -> None:
    """64 bytes are all that a packet holds: what comes at 84 may have waited since the transfer before, at 70."""
    host = ftdi()
    host.receive(4, 70, STATUS)
    host.receive(70, 82, STATUS + bytes(62))
    host.receive(82, 84, STATUS + b"A")
    records = run(host.save(tmp_path / "usb.pcap")).records
    assert uncertainty_ms(records[-1]) == 15


def test_windows_takes_the_time_from_a_clock_that_ticks(tmp_path: Path) -> None:
    """15.625 ms: the stamp is up to that too early, so the latest time is that much later."""
    host = ftdi(UsbPcap())
    host.receive(4, 30, STATUS + b"A")
    record = run(host.save(tmp_path / "usb.pcap")).records[0]
    assert (time_ms(record), uncertainty_ms(record)) == (45.625, 32.625)


def test_what_is_sent_leaves_one_after_the_other(tmp_path: Path) -> None:
    """Handed over at 100, taken at 100.2, and a frame of 1 ms: the line begins between 100 and 101.2."""
    host = ftdi()
    host.send(100, 100.2, COMMAND)
    host.receive(99, 140, STATUS + REACTION)
    done = run(host.save(tmp_path / "usb.pcap"))
    sent, received = done.records
    assert (sent.line, sent.data, received.line, received.data) == (SENT, COMMAND, RECEIVED, REACTION)
    assert time_ms(sent) == pytest.approx(101.2 + CHARACTER_MS, abs=1e-3)
    assert uncertainty_ms(sent) == pytest.approx(1.2)
    assert [interval / 1e6 for interval in sent.intervals[1:]] == pytest.approx([CHARACTER_MS] * 10, abs=1e-3)
    assert not any(flag & Flag.SAME_READ for flag in sent.flags)


def test_what_is_sent_waits_for_the_line(tmp_path: Path) -> None:
    """The second is handed over while the first, 11 characters, still leaves: 101.2 + 12 characters."""
    host = ftdi()
    host.send(100, 100.2, COMMAND)
    host.send(101, 101.2, b"Z")
    last = run(host.save(tmp_path / "usb.pcap")).records[-1]
    assert last.data == b"Z"
    assert time_ms(last) == pytest.approx(101.2 + 12 * CHARACTER_MS, abs=1e-3)
    assert uncertainty_ms(last) == pytest.approx(1.2)


def test_records_are_in_order_of_time(tmp_path: Path) -> None:
    """The last of 11 characters leaves at 113.8, the next telegram after it; what came at 110 goes between them."""
    host = ftdi()
    host.send(100, 100.2, COMMAND)
    host.send(105, 105.2, COMMAND)
    host.receive(99, 110, STATUS + REACTION)
    host.receive(110, 150, STATUS)
    records = run(host.save(tmp_path / "usb.pcap")).records
    assert [record.data for record in records] == [COMMAND, REACTION, COMMAND]


def test_what_the_adapter_has_not_taken_was_not_sent(tmp_path: Path) -> None:
    host = ftdi()
    host.send(100, 110, COMMAND, length=3)  # cancelled
    assert characters(run(host.save(tmp_path / "usb.pcap")).records, SHARED) == COMMAND[:3]


@pytest.mark.thorough
def test_what_is_on_its_way_at_the_end_is_not_lost(tmp_path: Path) -> None:
    host = ftdi()
    host.send(100, 110, COMMAND)
    host.packets.pop()
    (record,) = run(host.save(tmp_path / "usb.pcap")).records
    assert (record.data, record.uncertainty_ns) == (COMMAND, UNCERTAINTY_UNKNOWN)


@pytest.mark.thorough
def test_bytes_that_the_capture_does_not_have_are_marked(tmp_path: Path) -> None:
    host = ftdi()
    host.receive(4, 20, STATUS + b"A", length=40)
    host.receive(20, 36, STATUS + b"BC")
    host.receive(36, 52, b"", length=10)
    host.receive(52, 68, STATUS + b"D")
    records = run(host.save(tmp_path / "usb.pcap")).records
    flags = [flag & LOST for record in records for flag in record.flags]
    assert (characters(records, SHARED), flags) == (b"ABCD", [0, LOST, 0, LOST])


@pytest.mark.thorough
def test_bytes_sent_that_the_capture_does_not_have_are_marked(tmp_path: Path) -> None:
    """usbmon had room for two of eleven."""
    host = ftdi()
    host.send(10, 12, COMMAND[:2], length=11)
    host.packets[-2] = Usbmon().submit(10, BULK, 0x02, 5, COMMAND[:2], length=11)
    host.send(40, 42, b"Z")
    records = run(host.save(tmp_path / "usb.pcap")).records
    flags = [flag & LOST for record in records for flag in record.flags]
    assert (characters(records, SHARED), flags) == (COMMAND[:2] + b"Z", [0, 0, LOST])


def test_cdc(tmp_path: Path) -> None:
    """Two USB frames of 1 ms."""
    host = cdc()
    host.send(10, 10.2, COMMAND)
    host.receive(4, 40, REACTION)
    done = run(host.save(tmp_path / "usb.pcap"))
    assert [(record.line, record.data, record.settings) for record in done.records] == [
        (SENT, COMMAND, LineSettings(9600, 8, "E", 2)),
        (RECEIVED, REACTION, LineSettings(9600, 8, "E", 2)),
    ]
    assert (time_ms(done.records[1]), uncertainty_ms(done.records[1])) == (40, 2)
    assert "what the adapter itself adds is not known" in done.events[0]


@pytest.mark.parametrize(
    ("coding", "text"),
    [((19200, 0, 0, 8), "19200 Bd 8N1"), ((38400, 2, 1, 7), "38400 Bd 7O2"), ((57600, 1, 4, 5), "57600 Bd 5S1.5")],
)
def test_line_codings_of_cdc(coding: tuple[int, int, int, int], text: str) -> None:
    setup = Setup(CLASS_REQUEST, SET_LINE_CODING, 0, 0)
    assert str(cdc_says.settings_after(setup, line_coding(*coding), LineSettings())) == text


@pytest.mark.parametrize(
    "data", [line_coding(9600, 0, 5, 8), line_coding(9600, 3, 0, 8), line_coding(9600, 0, 0, 9), b"1"]
)
def test_line_codings_that_cannot_be(data: bytes) -> None:
    assert cdc_says.settings_after(Setup(CLASS_REQUEST, SET_LINE_CODING, 0, 0), data, LINE) is LINE


def test_line_coding_by_usbpcap_without_descriptors(tmp_path: Path) -> None:
    host = Host(UsbPcap(), 0x83, 0x04)
    host.request(2, CLASS_REQUEST, SET_LINE_CODING, 0, 0, line_coding(9600, 0, 2, 8))
    host.receive(4, 20, REACTION)
    (record,) = run(host.save(tmp_path / "usb.pcap")).records
    assert (record.data, str(record.settings)) == (REACTION, "9600 Bd 8E1")


NOTIFICATION = bytes.fromhex("A1 20 0000 0000 0200")


@pytest.mark.parametrize(("state", "flag"), [(0x40, LOST), (0x20, SOMEWHERE), (0x10, SOMEWHERE), (0x03, 0)])
def test_notifications_of_cdc(state: int, flag: int) -> None:
    """Overrun, parity, framing; carrier and data set ready are no errors."""
    assert cdc_says.errors(NOTIFICATION + bytes([state, 0])) == flag
    assert cdc_says.errors(NOTIFICATION) == 0


def test_a_notification_is_for_what_comes_next(tmp_path: Path) -> None:
    host = cdc()
    host.receive(4, 20, b"A")
    host.notify(21, 0x82, NOTIFICATION + b"\x60\x00")
    host.receive(22, 36, b"BC")
    records = run(host.save(tmp_path / "usb.pcap")).records
    flags = [flag & Flag.FROM_READER for record in records for flag in record.flags]
    assert flags == [0, LOST | SOMEWHERE, 0]


def two_adapters(folder: Path) -> Path:
    first, second = ftdi(), cdc(Usbmon(Device(2, 7)))
    first.receive(4, 20, STATUS + b"ABC")
    second.receive(4, 21, b"D")
    return pcap(folder / "usb.pcap", 220, sorted(first.packets + second.packets, key=lambda p: p[0]))


@pytest.mark.thorough
def test_of_several_adapters_one_has_to_be_chosen(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    source = two_adapters(tmp_path)
    assert run(source).code == 2
    listed = "1.5 (FTDI, 9600 Bd 8E1, 3 characters); 2.7 (CDC, 9600 Bd 8E1, 1 characters)"
    assert capfd.readouterr().err == f"sistap: {source} has several adapters: choose one with --device: {listed}\n"
    assert [record.data for record in run(source, "--device", "2.7").records] == [b"D"]
    assert [record.data for record in run(source, "--device", "1.5").records] == [b"ABC"]
    assert run(source, "--device", "1.6").code == 2
    assert f"no adapter 1.6 with characters, only {listed}" in capfd.readouterr().err


def test_the_second_port_of_a_chip(tmp_path: Path) -> None:
    """Endpoints 0x83 and 0x04; requests have the port, from 1, in their wIndex."""
    first, second = Host(Usbmon()), Host(Usbmon(), 0x83, 0x04)
    first.descriptor(0, 1, FT232R)
    second.request(1, VENDOR_REQUEST, SET_BAUD_RATE, 0x001A, 0x0002)
    second.request(2, VENDOR_REQUEST, SET_LATENCY_TIMER, 2, 0x0002)
    second.receive(4, 20, STATUS + b"B")
    source = pcap(tmp_path / "usb.pcap", 220, first.packets + second.packets)
    done = run(source)
    assert "FTDI adapter 1.5B" in done.events[0]
    assert [(record.data, record.settings.baud, uncertainty_ms(record)) for record in done.records] == [
        (b"B", 115200, 3)
    ]


def test_a_device_that_is_no_adapter(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    host = Host(Usbmon())
    host.receive(4, 20, b"USBC\0\0")
    assert run(host.save(tmp_path / "usb.pcap")).code == 2
    assert "has no characters of a serial adapter that is known, and no good telegrams" in capfd.readouterr().err


def test_a_capture_that_is_cut_before_its_characters(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    source = ftdi().save(tmp_path / "usb.pcap")
    source.write_bytes(source.read_bytes()[:-1])
    assert run(source).code == 2
    said = "no good telegrams; its end is missing: it appears to have been cut short in the middle of a packet; begin"
    assert said in capfd.readouterr().err


@pytest.mark.thorough
def test_a_capture_that_is_cut_anywhere(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    host = ftdi()
    host.send(10, 10.2, COMMAND)
    for number in range(3):
        host.receive(30 + 16 * number, 46 + 16 * number, STATUS + REACTION)
    whole = host.save(tmp_path / "usb.pcap").read_bytes()
    source = tmp_path / "cut.pcap"
    for length in (len(whole) - 90, len(whole) - 20, len(whole) - 1):
        source.write_bytes(whole[:length])
        done = run(source)
        assert done.code == 0
        assert characters(done.records, SENT) == COMMAND
        assert characters(done.records, RECEIVED) == 2 * REACTION
        assert "its end is missing: it " in capfd.readouterr().err


@pytest.mark.parametrize("seconds", ["-1.5", "18446744073709551615.000000000"])
def test_times_that_no_file_can_hold(seconds: str) -> None:
    assert 0 <= nanoseconds(seconds) <= 1 << 63


def at_one_baud(host: Host) -> None:
    host.request(3, CLASS_REQUEST, SET_LINE_CODING, 0, 0, line_coding(1, 0, 2, 8))


def with_one_number(host: Host) -> None:
    """All transfers have the same number, and are completed before they begin."""
    for packet in range(20):
        host.packets += [
            Usbmon().complete(10 + packet, BULK, 0x04, 7, b"", 99),
            Usbmon().submit(10.5 + packet, BULK, 0x04, 7, b"B" * 40),
        ]


def late_settings(host: Host) -> None:
    """Years between two transfers."""
    host.packets = [(time_ms - 1e12, packet) for time_ms, packet in host.packets]


def never_taken(host: Host) -> None:
    host.packets += [Usbmon().submit(20 + number, BULK, 0x04, 900 + number, b"A" * 400) for number in range(50)]


@pytest.mark.attack("a USB capture of what no adapter does", "all characters are imported; no traceback")
@pytest.mark.parametrize("what", [at_one_baud, with_one_number, late_settings, never_taken])
def test_what_no_adapter_does(tmp_path: Path, capfd: pytest.CaptureFixture[str], what: Callable[[Host], None]) -> None:
    host = cdc()
    what(host)
    host.send(30, 30.2, COMMAND)
    host.receive(40, 41, REACTION)
    done = run(host.save(tmp_path / "usb.pcap"))
    assert (done.code, "Traceback" in capfd.readouterr().err) == (0, False)
    assert characters(done.records, SENT).count(COMMAND) == 1
    assert characters(done.records, RECEIVED) == REACTION
