# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap serve` and its listeners: each gets everything or is told what is missing, and none delays the tap."""

from __future__ import annotations

import os
import pty
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path

import pytest
from commands import refused, run
from independent import records
from test_passive import assert_only_listens

from sistap.commands.serve import listeners as module
from sistap.commands.serve.listeners import Listeners, PublishedReader
from sistap.tap.line.reader import PortError, Reader, open_reader
from sistap.tap.line.settings import Flag, Happening, LineSettings, Notice, Read
from sistap.tap.records.assembler import Assembler
from sistap.tap.records.record import Event, Record, Type
from sistap.tap.wire import distant, protocol, server
from sistap.tap.wire.protocol import Decoder, Hello, Kind, Lost, Message, Time

CAPTURE = Path(__file__).parents[1]
TELEGRAM = bytes.fromhex("02 D7 03 03 00 03 10 03 04 07 00")  # fig. 6-14
START_NS = 1_700_000_000_000_000_000
PATIENCE_S = 60
ABOUT = Hello(Kind.TAP, 0, START_NS, 0, "/dev/ttyUSB0", "FT232R", "uncertainty 1 ms", ("a note",))
LINE = LineSettings(19200, 8, "N", 2)

needs_strace = pytest.mark.skipif(not shutil.which("strace"), reason="strace is not installed (apt install strace)")


def reads(count: int, size: int = 1, start: int = 0) -> list[Read]:
    """Return characters whose times, errors and uncertainties are all different."""
    return [
        Read(
            0,
            START_NS + 1_040_003 * number,
            bytes((number + place) % 256 for place in range(size)),
            bytes([number % 16 & 0x1E]) * size,
            1000 + number,
            LINE,
        )
        for number in range(start, start + count)
    ]


@pytest.fixture
def told() -> list[str]:
    return []


@pytest.fixture
def served(tmp_path: Path, told: list[str]) -> Iterator[Listeners]:
    """Listeners at a path: its socket has smaller buffers than a network socket."""
    with closing(Listeners(str(tmp_path / "tap"), [], told.append)) as listeners:
        listeners.begin(ABOUT, LINE)
        yield listeners


def connect(served: Listeners) -> socket.socket:
    """Connect, and be let in."""
    connection = socket.socket(socket.AF_UNIX)
    connection.settimeout(PATIENCE_S)
    connection.connect(served.name.removeprefix("bus://"))
    served.attend(0)
    return connection


def heard(served: Listeners, connection: socket.socket, until: Callable[[list[Message]], bool]) -> list[Message]:
    """Return messages while the listeners are served."""
    messages: list[Message] = []
    decoder, end = Decoder(), time.monotonic() + PATIENCE_S
    connection.setblocking(False)
    while not until(messages) and time.monotonic() < end:
        served.attend(0)
        with suppress(BlockingIOError):
            messages += decoder.feed(connection.recv(1 << 16))
    return messages


def of_reads(messages: list[Message]) -> list[Read]:
    return [message for message in messages if isinstance(message, Read)]


def count(messages: list[Message]) -> int:
    """Count characters that came or are reported as lost."""
    lost = sum(message.characters for message in messages if isinstance(message, Lost))
    return lost + sum(len(read.data) for read in of_reads(messages))


# -- The tap's side ----------------------------------------------------------------------------------------------------


def test_the_first_messages_say_what_it_is(served: Listeners) -> None:
    with connect(served) as connection:
        hello, settings = heard(served, connection, lambda messages: len(messages) >= 2)
    assert isinstance(hello, Hello)
    assert hello._replace(time_ns=0) == ABOUT
    assert abs(hello.time_ns - time.time_ns()) < PATIENCE_S * 1e9
    assert settings == LINE


def test_a_stalled_listener_delays_nobody_and_is_told_how_much_it_misses(
    served: Listeners, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "ROOM", 10_000)
    sent = reads(1500, 300)  # 900 kB: several times what the system buffers
    with connect(served) as stalled, connect(served) as other:
        messages, decoder = [], Decoder()
        for read in sent:
            served.publish(read)
            served.attend(0)
            messages += decoder.feed(other.recv(1 << 16))
        messages += heard(served, other, lambda _: count(messages) + count(_) >= count([*sent]))
        late = heard(served, stalled, lambda messages: count(messages) >= count([*sent]))
        served.publish(after := reads(1, 7, start=5000)[0])
        late += heard(served, stalled, lambda messages: bool(of_reads(messages)))
    assert of_reads(messages) == [read._replace(settings=None) for read in sent]
    assert not any(isinstance(message, Lost) for message in messages)
    assert 0 < len(of_reads(late)) < len(sent)
    assert count(late) == count([*sent, after])
    lost = next(place for place, message in enumerate(late) if isinstance(message, Lost))
    assert of_reads(late[:lost]) == [read._replace(settings=None) for read in sent[: len(of_reads(late[:lost]))]]
    assert of_reads(late)[-1] == after._replace(settings=None)


def test_other_settings_come_before_the_first_character_with_them(served: Listeners) -> None:
    first, second = reads(2)
    other = LineSettings(38400)
    with connect(served) as connection:
        served.publish(first)
        served.publish(second._replace(settings=other))
        messages = heard(served, connection, lambda messages: len(of_reads(messages)) == 2)
    rest = [message for message in messages[2:] if not isinstance(message, Time)]
    assert rest == [first._replace(settings=None), other, second._replace(settings=None)]


def test_what_a_listener_says_is_thrown_away(served: Listeners, told: list[str]) -> None:
    said = [
        protocol.pack_settings(LineSettings(38400)),
        protocol.pack_read(reads(1, 100)[0]),
        b"GET / HTTP/1.1\r\n\r\n",
        b"\xff" * 100_000,
        b"R\x00\xff\xff" + b"\0" * 50,
    ]
    with ExitStack() as opened:
        hostile = [opened.enter_context(connect(served)) for _ in said]
        other = opened.enter_context(connect(served))
        for connection, text in zip(hostile, said, strict=True):
            connection.setblocking(False)
            with suppress(BlockingIOError):
                connection.sendall(text)
        sent = reads(200)
        for read in sent:
            served.publish(read)
            served.attend(0)
        messages = heard(served, other, lambda messages: len(of_reads(messages)) == len(sent))
    assert of_reads(messages) == [read._replace(settings=None) for read in sent]
    assert [message for message in messages if isinstance(message, LineSettings)] == [LINE]
    assert told == []


def test_a_listener_that_goes_away_is_forgotten(served: Listeners) -> None:
    connect(served).close()
    with connect(served) as other:
        for read in reads(100):
            served.publish(read)
            served.attend(0)
        assert len(list(served._peers)) == 1
        assert len(of_reads(heard(served, other, lambda messages: len(of_reads(messages)) == 100))) == 100


def test_who_never_answers_makes_room(served: Listeners, told: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    with connect(served) as silent, connect(served) as other:
        monkeypatch.setattr(module, "PATIENCE_NS", -1)
        other.sendall(protocol.pack_time(1))
        (first, second) = served._peers
        second.heard_ns = 1 << 62  # it has just answered
        served.attend(1 << 61)
        assert list(served._peers) == [second]
        assert told == ["closed a connection: no answer for -1 s"]
        silent.settimeout(PATIENCE_S)
        with suppress(ConnectionResetError):
            while silent.recv(4096):
                pass


@pytest.mark.attack("more connections than `sistap serve` allows (32)", "the next one is refused")
def test_no_more_than_a_limit_are_let_in(served: Listeners, told: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "MOST", 2)
    with ExitStack() as opened:
        some = [opened.enter_context(connect(served)) for _ in range(5)]
        assert len(list(served._peers)) == 2
        assert [connection.recv(4096) != b"" for connection in some] == [True, True, False, False, False]
    assert told == ["refused a connection: 2 are connected already"]  # once: repeated attempts are no news


@pytest.mark.parametrize(
    ("address", "comes"),
    [
        ("127.0.0.1", True),
        ("::1", True),
        ("192.168.7.9", True),
        ("::ffff:192.168.7.9", True),
        ("192.168.8.9", False),
        ("::ffff:192.168.8.9", False),
        ("10.0.0.1", True),
        ("10.0.0.2", False),
        ("fd00::7", True),
        ("fe80::1%eth0", False),
    ],
)
def test_only_whom_allow_names_is_let_in(
    address: str, comes: bool, told: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from sistap.commands.serve.command import _network

    networks = [*map(_network, ("192.168.7.0/24", "10.0.0.1", "fd00::/8"))]
    with closing(Listeners("127.0.0.1:0", networks, told.append)) as listeners:
        listeners.begin(ABOUT, LINE)
        real = server.plain_ip
        monkeypatch.setattr(server, "plain_ip", lambda _: real(address))
        port = int(listeners.name.rpartition(":")[2])
        with socket.create_connection(("127.0.0.1", port), PATIENCE_S) as connection:
            listeners.attend(0)
            assert bool(connection.recv(4096)) is comes
    plain = address.removeprefix("::ffff:").partition("%")[0]
    assert told == ([] if comes else [f"refused a connection: {plain} may not listen: name its network with --allow"])


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        (["--listen", "0.0.0.0:0"], 2, "--allow ADDRESS/BITS"),
        (["--listen", "[::]:0"], 2, "--allow ADDRESS/BITS"),
        (["--listen", "192.168.7.1:5000"], 2, "--allow ADDRESS/BITS"),
        (["--listen", "pi:5000"], 2, "give an address of this computer, not a name"),
        (["--listen", "5000"], 2, "neither HOST:PORT nor a PATH"),
        (["--listen", "203.0.113.1:5000", "--allow", "203.0.113.0/24"], 3, "choose another address with --listen"),
        (["--listen", "127.0.0.1:0"], 3, "/dev/nowhere does not exist"),
        (["--listen", "127.0.0.1:0", "--format", "9X9"], 2, "format '9X9'"),
        (["-i", "bus://127.0.0.1:5001"], 2, "is already shared"),
    ],
)
def test_wrong_usage(tmp_path: Path, options: list[str], code: int, words: str) -> None:
    refused(run(tmp_path, "serve", "-i", "/dev/nowhere", *options), code, words)


@pytest.mark.parametrize("network", ["192.168.7.1/24", "192.168.7.0/33", "everybody", "0/0", ""])
def test_what_is_no_network(tmp_path: Path, network: str) -> None:
    done = run(tmp_path, "serve", "-i", "/dev/nowhere", "--allow", network)
    assert done.returncode == 2
    assert "is not ADDRESS/BITS, such as 192.168.7.0/24" in done.stderr


class Repeated:
    """A reader that has these reads, and nothing more."""

    name, adapter, timing = "/dev/ttyUSB0", "FT232R", "uncertainty 1 ms"
    notes: tuple[str, ...] = ()
    line = 0

    def __init__(self, waiting: list[Read]) -> None:
        self.settings = LINE
        self.waiting = waiting
        self.asked: list[float] = []

    def read(self, timeout_s: float) -> Read | None:
        self.asked.append(timeout_s)
        return self.waiting.pop(0) if self.waiting else None

    def change(self, settings: LineSettings) -> None:
        self.settings = settings

    def close(self) -> None:
        pass


def test_listeners_have_their_turn_when_nothing_waits_to_be_read(
    served: Listeners, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    monkeypatch.setattr(served, "attend", asked.append)
    sent = reads(3)
    reader = Repeated([*sent])
    published = PublishedReader(reader, served)
    published._attended_ns = 1 << 62
    assert [published.read(0.1) for _ in range(3)] == sent
    assert asked == []
    assert published.read(0.1) is None
    assert len(asked) == 1
    assert reader.asked == [0, 0, 0, 0, 0.1]
    reader.waiting = reads(1)
    published._attended_ns = 0  # long ago
    assert published.read(0.1)
    assert len(asked) == 2


# -- The listener's side -----------------------------------------------------------------------------------------------


class Tap:
    """The other end: the test scripts it."""

    def __init__(self, path: Path) -> None:
        self.listening = socket.socket(socket.AF_UNIX)
        self.listening.bind(str(path))
        self.listening.listen()
        self.connection: socket.socket | None = None
        self.came = threading.Event()

    def greet(self, hello: Hello, settings: LineSettings = LINE) -> None:
        """Let the next one in."""
        self.came.clear()

        def accept() -> None:
            connection, _ = self.listening.accept()
            connection.sendall(protocol.pack_hello(hello) + protocol.pack_settings(settings))
            self.connection = connection
            self.came.set()

        threading.Thread(target=accept, daemon=True).start()

    def say(self, *messages: bytes) -> None:
        assert self.came.wait(PATIENCE_S)
        assert self.connection
        self.connection.sendall(b"".join(messages))

    def end(self) -> None:
        assert self.came.wait(PATIENCE_S)
        assert self.connection
        self.connection.close()


NOW = ABOUT._replace(time_ns=START_NS, place=1000)


@pytest.fixture
def listening(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Reader, Tap]]:
    monkeypatch.setattr(distant, "AGAIN_S", 0.01)
    tap = Tap(tmp_path / "tap")
    tap.greet(NOW)
    with closing(open_reader(f"bus://{tmp_path}/tap", LineSettings(9600))) as reader:
        yield reader, tap
    tap.listening.close()


def next_read(reader: Reader) -> Read:
    """Return what comes, without the times that the tap tells."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        read = reader.read(0.1)
        if read and (read.data or read.notices):
            return read
    raise AssertionError("nothing came")


def notice(reader: Reader) -> Notice:
    (told,) = next_read(reader).notices
    return told


def test_all_that_the_tap_says_of_itself_comes_along(listening: tuple[Reader, Tap]) -> None:
    reader, _ = listening
    assert reader.adapter == "/dev/ttyUSB0: FT232R"
    assert re.fullmatch(
        r"times are of the clock at bus://\S+/tap, \d+\.\d{4} s behind this one, within \d+\.\d ms; uncertainty 1 ms",
        reader.timing,
    )
    assert reader.notes == ("a note",)
    assert reader.settings == LINE
    assert isinstance(reader, distant.DistantReader)
    assert 0 <= reader.now_ns() - START_NS < PATIENCE_S * 1e9
    with pytest.raises(PortError, match="with the options of `sistap serve`"):
        reader.change(LineSettings(38400))


def test_reads_are_those_of_the_tap(listening: tuple[Reader, Tap]) -> None:
    reader, tap = listening
    sent = reads(40, 3)
    other = LineSettings(38400)
    later = reads(1, start=40)[0]
    tap.say(*map(protocol.pack_read, sent), protocol.pack_settings(other), protocol.pack_read(later))
    assert [next_read(reader) for _ in sent] == sent
    assert next_read(reader) == later._replace(settings=other)


def test_the_time_is_passed_on_and_answered(listening: tuple[Reader, Tap]) -> None:
    reader, tap = listening
    tap.say(protocol.pack_time(START_NS + 5))
    while (read := reader.read(PATIENCE_S)) is None:
        pass
    assert (read.time_ns, read.data) == (START_NS + 5, b"")
    assert tap.connection
    assert Decoder(protocol.FROM_LISTENER).feed(tap.connection.recv(100)) == [Time(START_NS + 5)]


def test_missing_characters_are_told_with_their_number(listening: tuple[Reader, Tap]) -> None:
    reader, tap = listening
    first, second = reads(2)
    tap.say(protocol.pack_read(first), protocol.pack_lost(123), protocol.pack_read(second))
    assert next_read(reader) == first
    told = notice(reader)
    assert told.happening == Happening.LOST
    assert told.text.startswith("123 characters missing: ")
    assert next_read(reader).flags[0] == second.flags[0] | Flag.LOST_BEFORE


@pytest.mark.parametrize(
    ("place", "happening", "text"),
    [
        (1010, Happening.MARKER, "no character is missing"),
        (1011, Happening.LOST, "1 character missing: connected again after "),
        (2010, Happening.LOST, "1000 characters missing: connected again after "),
    ],
)
def test_after_a_lost_connection_it_goes_on(
    listening: tuple[Reader, Tap], place: int, happening: Happening, text: str
) -> None:
    reader, tap = listening
    before, after = reads(2, 10)
    tap.say(protocol.pack_read(before))
    assert next_read(reader) == before
    tap.end()
    gone = next_read(reader)
    assert gone.time_ns == before.time_ns
    assert gone.notices[0].happening == Happening.GONE
    assert "is lost (its other end has closed it): trying until it is back" in gone.notices[0].text
    tap.greet(NOW._replace(time_ns=START_NS + 10**9, place=place))
    back = next_read(reader)
    assert back.time_ns == START_NS + 10**9
    assert back.notices[0].happening == happening
    assert text in back.notices[0].text
    tap.say(protocol.pack_read(after))
    again = next_read(reader)
    assert again.data == after.data
    assert bool(again.flags[0] & Flag.LOST_BEFORE) is (happening == Happening.LOST)


def test_a_tap_that_was_started_anew_has_another_clock(listening: tuple[Reader, Tap]) -> None:
    reader, tap = listening
    tap.end()
    assert notice(reader).happening == Happening.GONE
    tap.greet(NOW._replace(began_ns=1, time_ns=2, place=0), LineSettings(38400))
    told = notice(reader)
    assert told.happening == Happening.ANEW
    assert "how many characters are missing is not known" in told.text
    tap.say(protocol.pack_read(reads(1)[0]))
    read = next_read(reader)
    assert read.settings == LineSettings(38400)
    assert read.flags[0] & Flag.LOST_BEFORE


def test_a_tap_that_says_nothing_is_lost(listening: tuple[Reader, Tap], monkeypatch: pytest.MonkeyPatch) -> None:
    reader, _ = listening
    monkeypatch.setattr(distant, "PATIENCE_NS", 0)
    assert "nothing was heard for 0 s" in notice(reader).text


@pytest.mark.parametrize("junk", [b"HTTP/1.1 200 OK", b"\xff" * 100, protocol.pack_time(2**63), b"N\x09\x00\x00"])
def test_a_tap_that_says_something_else_is_left(listening: tuple[Reader, Tap], junk: bytes) -> None:
    reader, tap = listening
    tap.say(junk)
    assert "the other end of the socket is not a sistap bus or tap" in notice(reader).text


def test_nothing_that_a_tap_says_controls_a_terminal_or_makes_up_lines(listening: tuple[Reader, Tap]) -> None:
    reader, tap = listening
    tap.say(protocol.pack_notice(Notice(Happening.MARKER, "a\x1b[2Jb\u202ec\nd")))
    assert notice(reader).text == "a\\u001b[2Jb\\u202ec\\u000ad"
    strange = reads(1)[0]._replace(line=77, flags=b"\xff")
    tap.say(protocol.pack_read(strange))
    read = next_read(reader)
    assert (read.line, read.flags) == (0, bytes([Flag.FROM_READER]))


# -- Both --------------------------------------------------------------------------------------------------------------


def recorded(taken: list[Read]) -> list[Record]:
    assembler = Assembler()
    assembler.add_line(0, LINE, 0)
    for read in taken:
        assembler.take(read, 0, "")
    assembler.flush([0], 0)
    return list(assembler.due(0))


def test_records_are_those_of_a_local_capture(served: Listeners) -> None:
    """A reader's results reach the framer as they do without a network."""
    data = TELEGRAM * 20
    sent = [
        Read(0, START_NS + place * 999_999, data[place : place + 1], bytes([place % 97 == 0]) * 1, place, LINE)
        for place in range(len(data))
    ]
    sent = [read._replace(flags=bytes([read.flags[0] * Flag.CHARACTER_ERROR])) for read in sent]
    ended = threading.Event()

    def attend() -> None:
        while not ended.is_set():
            served.attend(time.monotonic_ns())
            ended.wait(0.001)

    thread = threading.Thread(target=attend)
    thread.start()
    try:
        reader = open_reader(served.name, LineSettings())
    finally:
        ended.set()
        thread.join()
    published = PublishedReader(Repeated([*sent]), served)
    while published.read(0):
        pass
    taken = [next_read(reader) for _ in sent]
    reader.close()
    assert taken == sent
    assert recorded(taken) == recorded(sent)
    assert sum(record.type == Type.FRAME for record in recorded(taken)) == 20


@contextmanager
def serving(*options: str) -> Iterator[tuple[subprocess.Popen[str], str, int]]:
    """Serve a pty: the process, its address, and the end that speaks."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    command = [sys.executable, "-m", "sistap", "serve", "-q", "-i", os.ttyname(slave), "--listen", *options]
    process = subprocess.Popen(command, cwd=CAPTURE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout
        yield process, process.stdout.readline().strip(), master
    finally:
        process.kill()
        process.communicate()
        os.close(slave)
        os.close(master)


def capturing(name: str, file: Path, *options: str) -> subprocess.Popen[str]:
    """Start a capture, and wait until it has connected."""
    command = [sys.executable, "-m", "sistap", "capture", "-i", name, "-w", str(file), *options]
    process = subprocess.Popen(command, cwd=CAPTURE, stderr=subprocess.PIPE, text=True)
    assert process.stderr
    assert "capturing on bus://" in process.stderr.readline()
    return process


def say(master: int, telegrams: int) -> None:
    for _ in range(telegrams):
        os.write(master, TELEGRAM)
        time.sleep(0.005)


@pytest.mark.attack("a stalled and a hostile listener beside two captures", "both captures have everything")
def test_two_captures_of_one_tap_with_a_stalled_and_a_hostile_one_beside_them(tmp_path: Path) -> None:
    files = [tmp_path / "one", tmp_path / "two"]
    with serving("127.0.0.1:0") as (process, name, master):
        port = int(name.rpartition(":")[2])
        with (
            socket.create_connection(("127.0.0.1", port)),  # it never reads
            socket.create_connection(("127.0.0.1", port)) as hostile,
        ):
            captures = [capturing(name, file, "-c", "50") for file in files]
            hostile.sendall(os.urandom(50_000))
            say(master, 50)
            assert [capture.wait(PATIENCE_S) for capture in captures] == [0, 0]
        process.terminate()
        assert process.wait(PATIENCE_S) == 0
    one, two = ([record for record in records(file) if record.type != Type.EVENT] for file in files)
    assert one == two
    assert b"".join(record.data for record in one) == TELEGRAM * 50
    started = next(record for record in records(files[0]) if record.event == Event.CAPTURE_STARTED)
    assert "(/dev/pts/" in started.data.decode()
    assert "times are of the clock at bus://127.0.0.1:" in started.data.decode()


@pytest.mark.thorough
def test_a_killed_tap_and_one_in_its_place(tmp_path: Path) -> None:
    path, file = tmp_path / "tap", tmp_path / "file"
    with serving(str(path)) as (process, name, master):
        capture = capturing(name, file)
        say(master, 5)
        assert capture.stderr
        process.kill()
        assert "is lost" in capture.stderr.readline()
    with serving(str(path)) as (process, name, master):
        assert "connected again after" in capture.stderr.readline()
        say(master, 5)
        process.terminate()  # it lets everybody have everything
        assert process.wait(PATIENCE_S) == 0
        assert "is lost" in capture.stderr.readline()
        capture.send_signal(signal.SIGINT)
        assert capture.wait(PATIENCE_S) == 0
    captured = records(file)
    assert [record.event for record in captured if record.event] == [
        Event.CAPTURE_STARTED,
        Event.ADAPTER_LOST,
        Event.CHARACTERS_LOST,
        Event.ADAPTER_LOST,
    ]
    assert b"".join(record.data for record in captured if not record.event).endswith(TELEGRAM * 5)
    first_again = next(record for record in captured[3:] if record.type == Type.FRAME and record.flags[0])
    assert first_again.flags[0] == Flag.LOST_BEFORE | Flag.INTERVAL_UNKNOWN


@pytest.mark.thorough
def test_a_port_that_is_lost_is_told(tmp_path: Path) -> None:
    with serving("127.0.0.1:0") as (process, name, master):
        capture = capturing(name, tmp_path / "file")
        os.dup2(os.open(os.devnull, os.O_RDONLY), master)  # the other end of the line goes
        assert process.wait(PATIENCE_S) == 1
        assert capture.stderr
        assert "the program at its other end has ended" in capture.stderr.readline()
        capture.send_signal(signal.SIGINT)
        assert capture.wait(PATIENCE_S) == 0


@pytest.mark.thorough
def test_the_rate_is_set_at_the_tap(tmp_path: Path) -> None:
    with serving("127.0.0.1:0", "--baud", "19200", "--format", "8N1") as (_, name, master):
        for options in (["--baud", "auto"], ["--follow-baud"]):
            refused(run(tmp_path, "capture", "-i", name, *options), 3, f"give {' '.join(options)} to `sistap serve`")
        capture = capturing(name, tmp_path / "file", "-c", "1", "--baud", "9600")
        say(master, 1)
        assert capture.wait(PATIENCE_S) == 0
    assert {record.settings for record in records(tmp_path / "file")} == {LineSettings(19200, 8, "N", 2)}


LISTEN_AND_STOP = """
import os, signal, socket, sys, threading, time
from sistap import cli
def listen():
    while True:
        try:
            connection = socket.create_connection(("127.0.0.1", int(sys.argv[2])))
            break
        except OSError:
            time.sleep(0.01)
    connection.sendall(b"S" + bytes(7) + b"hello" * 1000)
    heard = 0
    while heard < 2000:
        heard += len(connection.recv(4096))
    os.kill(os.getpid(), signal.SIGTERM)
threading.Thread(target=listen, daemon=True).start()
sys.exit(cli.main(["serve", "-i", sys.argv[1], "--listen", "127.0.0.1:" + sys.argv[2], "--follow-baud"]))
"""


@needs_strace
def test_serving_only_listens(tmp_path: Path) -> None:
    from test_passive import traced

    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    calls = traced(["-c", LISTEN_AND_STOP, "{port}", str(port)], tmp_path / "trace")
    assert_only_listens(calls)
