# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture as Wireshark starts, controls and ends it: through its three pipes."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import threading
import tty
from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from queue import SimpleQueue
from typing import BinaryIO, NamedTuple

import pytest

from sistap.tap.line.settings import Flag
from sistap.tap.records.record import Event, Framing, Record, Type, unpack
from sistap.tap.sis.telegram import checksum_good

CAPTURE = Path(__file__).parents[1]
PATIENCE_S = 60
TELEGRAM = bytes.fromhex("02 D7 03 03 00 03 10 03 04 07 00")  # fig. 6-14

# Blocks of pcapng; in a packet the record is behind 20 bytes of header and the 16 of an exported PDU.
SECTION, INTERFACE, STATISTICS, PACKET = 0x0A0D0D0A, 1, 5, 6
BEFORE_THE_RECORD = 20 + 16

# Of the toolbar, as it is listed with the interfaces: rate, marker, counters, log.
RATE, MARKER, COUNTERS, LOG = range(4)
# doc/extcap of Wireshark: commands of its messages.
INITIALIZED, SET, ADD = 0, 1, 2


SISTAP = [sys.executable, "-m", "sistap"]
# The same, but root keeps what it has measured in the folder that comes next: no environment could tell it to.
KEEPING = """\
import sys
from pathlib import Path
from sistap import cli
from sistap.tap.terminal import state
state.FOR_ROOT = Path(sys.argv.pop(1))
sys.exit(cli.main())
"""


class Message(NamedTuple):
    control: int
    command: int
    text: str


def record_of(packet: bytes) -> Record:
    (length,) = struct.unpack_from("<I", packet, 12)
    return unpack(packet[BEFORE_THE_RECORD : 20 + length])


class Wireshark:
    """Starts a capture, and has the other ends of its pipes."""

    def __init__(
        self, folder: Path, interface: str, *options: str, toolbar: bool = True, sistap: Sequence[str] = SISTAP
    ) -> None:
        self.folder = folder
        pipes = {"--fifo": folder / "capture"}
        if toolbar:
            pipes |= {"--extcap-control-in": folder / "in", "--extcap-control-out": folder / "out"}
        for pipe in pipes.values():
            if not os.path.lexists(pipe):
                os.mkfifo(pipe)
        named = [str(word) for pipe in pipes.items() for word in pipe]
        self.process = subprocess.Popen(
            [*sistap, "extcap", "--capture", "--extcap-interface", interface, *named, *options],
            cwd=CAPTURE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._limit = threading.Timer(PATIENCE_S, self.process.kill)  # so that nothing here waits for ever
        self._limit.start()
        self.messages: SimpleQueue[Message | None] = SimpleQueue()
        self._control: BinaryIO | None = None
        self.capture = (folder / "capture").open("rb")

    def show_toolbar(self) -> None:
        """Open the pipes of the toolbar, as Wireshark does while the capture starts."""
        self._control = (self.folder / "in").open("wb", buffering=0)
        threading.Thread(target=self._listen, daemon=True).start()

    def say(self, command: int, control: int = 0, text: str = "") -> None:
        assert self._control
        self._control.write(struct.pack(">cBHBB", b"T", 0, len(text.encode()) + 2, control, command) + text.encode())

    def write(self, data: bytes) -> None:
        """Send something that may not be a message."""
        assert self._control
        self._control.write(data)

    def hide_toolbar(self) -> None:
        assert self._control
        self._control.close()

    def told(self, control: int, command: int) -> Iterator[str]:
        """Yield the texts of messages of one kind, until the capture closes the pipe."""
        while message := self.messages.get():
            if message[:2] == (control, command):
                yield message.text

    def blocks(self) -> Iterator[tuple[int, bytes]]:
        """Yield kind and body of each block until the capture ends; there is never a part of one."""
        while head := self.capture.read(8):
            kind, length = struct.unpack("<II", head)
            rest = self.capture.read(length - 8)
            assert len(rest) == length - 8
            assert rest[-4:] == head[4:]
            yield kind, rest[:-4]

    def records(self) -> Iterator[Record]:
        """Yield the records until the capture ends."""
        for kind, body in self.blocks():
            if kind == PACKET:
                yield record_of(body)

    def event(self, code: Event) -> Record:
        """Wait for an event."""
        return next(record for record in self.records() if record.event == code)

    def ended(self) -> tuple[int, str]:
        """Wait for the end; return exit code and standard error."""
        _, errors = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, errors

    def close(self) -> None:
        self._limit.cancel()
        self.process.kill()
        self.process.communicate()
        self.capture.close()
        if self._control:
            self._control.close()

    def _listen(self) -> None:
        with (self.folder / "out").open("rb") as pipe:
            while header := pipe.read(6):
                sync, high, low, control, command = struct.unpack(">cBHBB", header)
                assert sync == b"T"
                text = pipe.read((high << 16 | low) - 2).decode()
                self.messages.put(Message(control, command, text))
        self.messages.put(None)


@pytest.fixture
def demo(tmp_path: Path) -> Iterator[Wireshark]:
    """Capture the demo bus, with the toolbar shown and the capture started."""
    wireshark = Wireshark(tmp_path, "sistap-demo")
    try:
        wireshark.show_toolbar()
        wireshark.event(Event.CAPTURE_STARTED)
        yield wireshark
    finally:
        wireshark.close()


@pytest.fixture
def started(tmp_path: Path) -> Iterator[list[Wireshark]]:
    """Collect what is to be closed at the end."""
    captures: list[Wireshark] = []
    yield captures
    for capture in captures:
        capture.close()


def test_a_marker_comes_into_the_capture_and_out_of_its_field(demo: Wireshark) -> None:
    demo.say(INITIALIZED)
    demo.say(SET, MARKER, "Motor läuft")
    assert demo.event(Event.MARKER).data.decode() == "Motor läuft"
    assert next(demo.told(MARKER, SET)) == ""


def has_a_line_error(record: Record) -> bool:
    return any(Flag(flags) & Flag.CHARACTER_ERROR for flags in record.flags)


def has_a_wrong_checksum(record: Record) -> bool:
    """Without a line error, so the bus really said it so."""
    return record.type == Type.FRAME and not has_a_line_error(record) and not checksum_good(record.data)


def is_too_slow(record: Record) -> bool:
    """An interval in it is longer than TzA, which the master of the scenario sets to 5 ms."""
    return record.type == Type.FRAME and any(interval > 5_000_000 for interval in record.intervals[1:])


@pytest.mark.parametrize("is_one", [has_a_wrong_checksum, has_a_line_error, is_too_slow])
def test_the_demo_bus_has_faults_within_seconds(demo: Wireshark, is_one: Callable[[Record], bool]) -> None:
    """Those of the picture in the README, for whoever clicks the interface without its options."""
    first = next(demo.records()).time_ns
    assert next(record for record in demo.records() if is_one(record)).time_ns - first < 5e9


def test_the_demo_bus_without_faults(started: list[Wireshark], tmp_path: Path) -> None:
    started.append(wireshark := Wireshark(tmp_path, "sistap-demo", "--faults", "checksum=0", toolbar=False))
    records = islice(wireshark.records(), 60)  # 2 s
    assert not any(has_a_wrong_checksum(record) or has_a_line_error(record) for record in records)


def message(control: int, command: int, text: bytes) -> bytes:
    return b"T" + (len(text) + 2).to_bytes(3, "big") + bytes([control, command]) + text


NO_MESSAGES = {
    "shorter than a control and a command": b"T\0\0\0" b"T\0\0\1\0",
    "does not begin with T": b"\0\xff{}" * 1000,
    "another control, another command": message(200, SET, b"x") + message(MARKER, 99, b"x"),
    "a rate of 5000 digits": message(RATE, SET, b"9" * 5000),
    "a rate that no record can hold": message(RATE, SET, b"4294967296"),
    "no rate": b"".join(message(RATE, SET, text) for text in (b"0", b"-1", b"1e4", b"\xb2", b"\xff")),
    "digits of another script": message(RATE, SET, "١٢".encode()),
    "a marker of no characters": message(MARKER, SET, b" \n"),
    "counters, before there are any": message(COUNTERS, SET, b""),
}


@pytest.mark.thorough
@pytest.mark.attack("the toolbar's pipe delivers something that is not a message", "ignored; the next message works")
def test_messages_that_no_wireshark_sends_end_nothing(demo: Wireshark) -> None:
    demo.say(INITIALIZED)
    for text, sent in NO_MESSAGES.items():
        demo.write(sent)
        demo.say(SET, MARKER, text)
        assert demo.event(Event.MARKER).data.decode() == text
    demo.write(message(MARKER, SET, b"invalid: \xff\xe2\x80"))
    assert demo.event(Event.MARKER).data == rb"invalid: \xff\xe2\x80"
    demo.write(message(MARKER, SET, b"x" * 0xFFFFF0))
    assert set(demo.event(Event.MARKER).data) == {ord("x")}
    demo.write(message(MARKER, SET, b"cut off")[:-1])
    demo.hide_toolbar()
    assert [kind for kind, _ in demo.blocks()][-1] == STATISTICS
    assert demo.ended() == (0, "")


def test_what_was_set_for_the_last_capture_does_not_count(demo: Wireshark) -> None:
    demo.say(SET, MARKER, "old")
    demo.say(SET, RATE, "19200")
    demo.say(INITIALIZED)
    demo.say(SET, MARKER, "new")
    marker = demo.event(Event.MARKER)
    assert marker.data == b"new"
    assert marker.settings.baud == 9600


def test_the_rate_is_changed_and_found_again(demo: Wireshark) -> None:
    demo.say(INITIALIZED)
    demo.say(SET, RATE, "19200")
    assert demo.event(Event.SETTINGS_CHANGED).settings.baud == 19200
    assert "19200" in demo.told(RATE, SET)
    demo.say(SET, RATE, "auto")
    found = demo.event(Event.SETTINGS_CHANGED)
    while b"found" not in found.data:
        found = demo.event(Event.SETTINGS_CHANGED)
    assert found.settings.baud == 9600
    assert "9600" in demo.told(RATE, SET)


def test_a_rate_is_looked_for_only_with_sis(tmp_path: Path, started: list[Wireshark]) -> None:
    started.append(wireshark := Wireshark(tmp_path, "sistap-demo", "--scenario", "s5"))
    wireshark.show_toolbar()
    wireshark.event(Event.CAPTURE_STARTED)
    wireshark.say(INITIALIZED)
    wireshark.say(SET, RATE, "auto")
    assert any("sistap can search for the rate of SIS telegrams only" in text for text in wireshark.told(LOG, ADD))


def test_counters_and_log_are_shown(demo: Wireshark) -> None:
    demo.say(INITIALIZED)
    assert next(demo.told(LOG, SET)) == ""  # the log of the last capture goes
    assert "capturing on bus://" in next(demo.told(LOG, ADD))
    assert any(re.match("[1-9][0-9]* telegrams", text) for text in demo.told(COUNTERS, SET))
    demo.say(SET, COUNTERS)
    assert any("longest interval" in text for text in demo.told(LOG, ADD))


@pytest.fixture
def line() -> Iterator[tuple[int, str]]:
    """Yield a pseudo terminal that plays a serial port: its other end, and the interface that it is."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    yield master, "sistap-" + os.ttyname(slave).removeprefix("/dev/")
    os.close(master)
    os.close(slave)


def test_a_signal_ends_it_and_loses_nothing(tmp_path: Path, line: tuple[int, str], started: list[Wireshark]) -> None:
    master, interface = line
    started.append(wireshark := Wireshark(tmp_path, interface, toolbar=False))
    wireshark.event(Event.CAPTURE_STARTED)
    os.write(master, 100 * TELEGRAM + TELEGRAM[:5])
    wireshark.process.send_signal(signal.SIGTERM)
    blocks = list(wireshark.blocks())
    assert [kind for kind, _ in blocks] == [PACKET] * 101 + [STATISTICS]
    assert b"".join(record_of(body).data for _, body in blocks[:-1]) == 100 * TELEGRAM + TELEGRAM[:5]
    assert wireshark.ended() == (0, "")


def test_both_directions_are_lines_of_one_capture(
    tmp_path: Path, line: tuple[int, str], started: list[Wireshark]
) -> None:
    _, interface = line
    other, slave = pty.openpty()
    second = "sistap-" + os.ttyname(slave).removeprefix("/dev/")
    started.append(wireshark := Wireshark(tmp_path, interface, "--second-port", second, toolbar=False))
    wireshark.event(Event.CAPTURE_STARTED)
    os.write(other, TELEGRAM)
    frame = next(record for record in wireshark.records() if record.type == Type.FRAME)
    assert (frame.line, frame.data) == (2, TELEGRAM)
    os.close(other)
    os.close(slave)


def test_limits_of_the_dialog_are_in_the_capture(
    tmp_path: Path, line: tuple[int, str], started: list[Wireshark]
) -> None:
    _, interface = line
    started.append(wireshark := Wireshark(tmp_path, interface, "--tza", "8", toolbar=False))
    assert wireshark.event(Event.LIMITS_TOLD).data == b"TzA = 8 ms"


def test_3964r_is_cut_where_it_is_chosen(tmp_path: Path, line: tuple[int, str], started: list[Wireshark]) -> None:
    master, interface = line
    started.append(wireshark := Wireshark(tmp_path, interface, "--framing", "3964r", toolbar=False))
    assert b"blocks of procedure 3964R" in wireshark.event(Event.CAPTURE_STARTED).data
    os.write(master, b"\x02\x10A\x10\x03R")
    frames = [next(wireshark.records()).data for _ in range(3)]
    assert frames == [b"\x02", b"\x10", b"A\x10\x03R"]


def test_the_demo_bus_is_cut_as_its_scenario_says(tmp_path: Path, started: list[Wireshark]) -> None:
    started.append(wireshark := Wireshark(tmp_path, "sistap-demo", "--scenario", "s5", toolbar=False))
    wireshark.event(Event.CAPTURE_STARTED)
    first = [next(wireshark.records()) for _ in range(3)]
    assert [(record.framing, record.line, record.data[:4].hex()) for record in first] == [
        (Framing.PROCEDURE_3964R, 1, "02"),
        (Framing.PROCEDURE_3964R, 2, "10"),
        (Framing.PROCEDURE_3964R, 1, "00004544"),
    ]


def test_a_lost_port_is_said_once_the_capture_has_ended(tmp_path: Path, started: list[Wireshark]) -> None:
    master, slave = pty.openpty()
    name = os.ttyname(slave)
    started.append(wireshark := Wireshark(tmp_path, "sistap-" + name.removeprefix("/dev/"), toolbar=False))
    wireshark.event(Event.CAPTURE_STARTED)
    os.close(slave)
    os.close(master)
    assert wireshark.event(Event.ADAPTER_LOST)
    code, errors = wireshark.ended()
    assert code == 1
    assert errors.startswith(f"sistap: {name}: ") and errors.count("\n") == 1


def test_a_toolbar_that_closes_ends_it(demo: Wireshark) -> None:
    demo.say(INITIALIZED)
    demo.hide_toolbar()
    assert [kind for kind, _ in demo.blocks()][-1] == STATISTICS
    assert demo.ended() == (0, "")


@pytest.mark.thorough
def test_a_reader_that_leaves_ends_it_without_a_word(demo: Wireshark) -> None:
    demo.capture.close()
    assert demo.ended() == (0, "")


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("interface", "options", "code", "says"),
    [
        ("sistap-ttyNONE", [], 3, "/dev/ttyNONE does not exist"),
        ("sistap-demo", ["--extcap-capture-filter", "link[5] ="], 2, "filter 'link[5] ='"),
        ("sistap-demo", ["--faults", "pause=often"], 2, "'pause=often'"),
        ("sistap-demo", ["--other-baud", "0"], 2, "'0' is neither auto nor a rate"),
        ("sistap-demo", ["--format", "9Z9"], 2, "format '9Z9'"),
    ],
)
def test_what_cannot_be_captured_is_said_in_one_line_and_in_the_capture(
    tmp_path: Path, started: list[Wireshark], interface: str, options: list[str], code: int, says: str
) -> None:
    started.append(wireshark := Wireshark(tmp_path, interface, *options, toolbar=False))
    assert says in wireshark.event(Event.MARKER).data.decode()
    ended, errors = wireshark.ended()
    assert ended == code
    assert errors.startswith("sistap: ") and errors.count("\n") == 1
    assert says in errors


@pytest.mark.thorough
def test_a_wireshark_that_opens_the_toolbar_late_is_waited_for(tmp_path: Path, started: list[Wireshark]) -> None:
    started.append(wireshark := Wireshark(tmp_path, "sistap-ttyNONE"))
    assert list(wireshark.blocks())  # all of the capture: it has failed
    ended = os.pidfd_open(wireshark.process.pid)
    assert not select.select([ended], [], [], 0.5)[0]
    os.close(ended)
    wireshark.show_toolbar()  # would wait for ever
    assert any("ttyNONE" in text for text in wireshark.told(LOG, ADD))
    assert wireshark.ended()[0] == 3


@pytest.mark.thorough
def test_a_self_test_before_the_capture_says_how_exact_it_is(
    tmp_path: Path, line: tuple[int, str], started: list[Wireshark], state: Path
) -> None:
    keeping = [sys.executable, "-c", KEEPING, str(state / "sistap")]
    started.append(
        wireshark := Wireshark(tmp_path, line[1], "--uncertainty", "selftest", toolbar=False, sistap=keeping)
    )
    assert b"measured by selftest on" in wireshark.event(Event.CAPTURE_STARTED).data
    assert (state / "sistap/selftest.json").exists()
