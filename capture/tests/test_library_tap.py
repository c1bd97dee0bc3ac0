# SPDX-License-Identifier: GPL-2.0-or-later
"""A tap of the library: time-outs, how it is closed and by whom, a port that goes, limits, wrong keywords."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import pytest
from portable import signals, terminals

import sistap
from sistap import cli, library
from sistap.tap.sis.telegram import build

READ = build(0x12, 16, 3)
ANSWER = build(0x12, 16, 3, b"\0\2", reaction=True)
LONG_S = 60.0  # nothing waits for so long: the test would hang


class Line:
    """A port, and what is at its other end."""

    def __init__(self) -> None:
        self.master, self.slave = os.openpty()
        self.name = os.ttyname(self.slave)

    def send(self, data: bytes) -> None:
        os.write(self.master, data)

    def go(self) -> None:
        """Vanish, as an unplugged adapter does."""
        for descriptor in (self.slave, self.master):
            if descriptor >= 0:
                os.close(descriptor)
        self.slave = self.master = -1


@pytest.fixture
def line() -> Iterator[Line]:
    line = Line()
    yield line
    line.go()


@pytest.fixture
def tap(line: Line) -> Iterator[sistap.Tap]:
    with sistap.Tap(line.name) as tap:
        started = tap.read(LONG_S)
        assert started and started.event == sistap.Event.CAPTURE_STARTED
        yield tap


@terminals
def test_a_read_that_nothing_ends_returns_none_at_its_time_out(
    line: Line, tap: sistap.Tap, monkeypatch: pytest.MonkeyPatch
) -> None:
    waited_s: list[float] = []

    def turn(timeout_s: float, real: Callable[[float], bool] = tap._capture.turn) -> bool:
        waited_s.append(timeout_s)
        return real(timeout_s)

    with monkeypatch.context() as patched:
        patched.setattr(tap._capture, "turn", turn)
        assert tap.read(0) is None
    assert waited_s == [library._SHORTEST_S]
    begun = time.monotonic()
    assert tap.read(timeout=0.3) is None
    assert time.monotonic() - begun >= 0.3
    tap.timeout = 0.01
    assert tap.read() is None
    assert tap.is_open
    line.send(READ)
    record = tap.read(LONG_S)
    assert record and record.data == READ


@terminals
def test_characters_that_make_no_telegram_do_not_delay_it(
    line: Line, tap: sistap.Tap, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As long as one comes before each look, or the read would never end."""
    left = iter(range(100))

    def come(_: float) -> bool:
        line.send(b"U")
        return next(left) >= 0

    monkeypatch.setattr(tap._capture, "turn", come)
    assert tap.read(0) is None
    assert next(left) == 1


@terminals
def test_the_time_out_of_the_tap_is_that_of_its_reads_and_not_of_a_loop(line: Line) -> None:
    with sistap.Tap(line.name, timeout=0.01) as tap:
        assert tap.read() is not None
        assert tap.read() is None
        threading.Timer(0.1, line.send, [READ]).start()
        assert next(iter(tap)).data == READ


@terminals
def test_what_waits_comes_without_waiting(line: Line, tap: sistap.Tap) -> None:
    line.send(READ + ANSWER)
    found = [tap.read(LONG_S), tap.read(0)]
    assert [record and record.data for record in found] == [READ, ANSWER]


@terminals
def test_a_loop_that_was_left_goes_on(line: Line, tap: sistap.Tap) -> None:
    """It does not begin anew, with the event that describes the capture."""
    line.send(READ + ANSWER)
    found = []
    for _ in range(2):
        for record in tap:
            found.append(record.data)
            break
    assert found == [READ, ANSWER]


@terminals
@pytest.mark.parametrize("way", ["loop", "read"])
def test_another_thread_closes_it(tap: sistap.Tap, way: str) -> None:
    results: list[object] = []
    reader = threading.Thread(target=lambda: results.append(list(tap) if way == "loop" else tap.read()))
    reader.start()
    tap.close()
    reader.join(LONG_S)
    assert not reader.is_alive()
    assert results == [[] if way == "loop" else None]
    assert not tap.is_open


@terminals
@signals
def test_a_signal_handler_closes_it(line: Line, tap: sistap.Tap) -> None:
    """As a program does that systemd stops."""
    before = signal.signal(signal.SIGALRM, lambda *_: tap.close())
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        line.send(READ[:5])
        assert [record.data for record in tap] == [READ[:5]]
    finally:
        signal.signal(signal.SIGALRM, before)
    assert not tap.is_open


@terminals
def test_closing_twice_and_reading_after(line: Line) -> None:
    tap = sistap.Tap(line.name)
    with closing(tap), tap:
        tap.close()
    tap.close()
    assert [record.event for record in tap] == [sistap.Event.CAPTURE_STARTED]
    with pytest.raises(sistap.PortError, match="the tap is closed: open a new one, or ask is_open before"):
        tap.read(1)
    assert list(tap) == []


@terminals
def test_what_was_no_whole_telegram_comes_when_it_is_closed(line: Line, tap: sistap.Tap) -> None:
    line.send(READ[:5])
    assert tap.read(0.1) is None
    tap.close()
    assert [(record.type, record.data) for record in tap] == [(sistap.Type.OTHER, READ[:5])]


@terminals
def test_its_time_is_over(line: Line) -> None:
    """It is open until everything was read."""
    with sistap.Tap(line.name, duration_s=0.1) as tap:
        found = []
        line.send(READ[:5])
        while tap.is_open:
            if record := tap.read(LONG_S):
                found.append(record.data)
    assert found[1:] == [READ[:5]]


@terminals
def test_a_port_that_goes(line: Line, tap: sistap.Tap) -> None:
    """What came before comes first. Any error of the library is an Error."""
    line.send(READ[:5])
    assert tap.read(0.1) is None
    line.go()
    found = []
    with pytest.raises(sistap.Error, match=f"{line.name}: the program .* has ended: start it") as caught:
        for record in tap:
            found.append(record)
    assert isinstance(caught.value, sistap.PortLost)
    assert [record.data for record in found if record.type != sistap.Type.EVENT] == [READ[:5]]
    assert found[-1].event == sistap.Event.ADAPTER_LOST
    assert not tap.is_open
    with pytest.raises(sistap.PortError, match="closed"):
        tap.read()


@terminals
def test_limits_are_those_of_the_command(line: Line, tmp_path: Path) -> None:
    """TzA and TrS: the same events as with --tza and --trs, in a file, too; the dissector judges by them."""
    command, library = tmp_path / "command.pcapng", tmp_path / "library.pcapng"
    options = ["-i", line.name, "--tza", "8", "--trs", "1", "-a", "duration:0.1", "-q", "-w", str(command)]
    assert cli.main(["capture", *options]) == 0
    with sistap.Tap(line.name, tza_ms=8, trs_ms=1) as tap, sistap.Writer(library) as writer:
        line.send(READ)
        for record in tap:
            writer.write(record)
            if record.data == READ:
                line.send(ANSWER)
            if record.data == ANSWER:
                break
    told = [
        [one.data for one in sistap.read(path) if one.event == sistap.Event.LIMITS_TOLD] for path in (command, library)
    ]
    assert told == [[b"TzA = 8 ms, TrS = 1 ms"]] * 2
    (reaction,) = (one for packet in sistap.dissect(library) for one in packet.telegrams if one.is_reaction)
    assert reaction.reaction and reaction.reaction.limit_s == 0.001
    assert reaction.pause and reaction.pause.limit_s == 0.008


KEYWORDS = "baud=, format=, framing=, follow_baud=, tza_ms=, trs_ms=, timeout=, duration_s="


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: sistap.Tap("/dev/x", limits="--trs 1"), f"Tap has no limits=; it has {KEYWORDS}"),  # type: ignore[call-arg]
        (lambda: sistap.Tap("/dev/x", baudrate=9600), f"Tap has no baudrate=; it has {KEYWORDS}"),  # type: ignore[call-arg]
        (lambda: sistap.Writer("x", overwrite=1), "Writer has no overwrite=; it has path=, description=, force="),  # type: ignore[call-arg]
        (lambda: sistap.play("demo", time=1), "play has no time=; it has name=, duration_s=, seed="),  # type: ignore[call-arg]
        (lambda: sistap.play("demo"), "missing 1 required keyword-only argument: 'duration_s'"),  # type: ignore[call-arg]
    ],
)
def test_a_keyword_that_does_not_exist(call: object, said: str) -> None:
    with pytest.raises(TypeError) as caught:
        call()  # type: ignore[operator]
    assert str(caught.value).endswith(said)


@pytest.mark.parametrize(
    ("keywords", "said"),
    [
        ({"baud": "fast"}, "'fast' is neither auto nor a rate from 1 to"),
        ({"baud": 0}, "'0' is neither auto nor a rate from 1 to"),
        ({"format": "9X9"}, "'9X9'"),
        ({"framing": "modbus"}, "'modbus'"),
        ({"tza_ms": 0}, "tza_ms: '0' is not a whole number of milliseconds from 1 to 65535"),
        ({"trs_ms": "20 ms"}, "trs_ms: '20 ms' is not a whole number of milliseconds from 1 to 65535"),
        ({"trs_ms": 20, "framing": "3964r"}, "--tza and --trs are kept only with SIS telegrams"),
        ({"baud": "auto", "framing": "3964r"}, "--baud auto needs SIS telegrams"),
        ({"follow_baud": True, "framing": "ascii"}, "--follow-baud needs SIS telegrams"),
        ({"timeout": -1}, "timeout=-1 is neither None nor a number of seconds from 0 on"),
        ({"duration_s": float("nan")}, "duration_s=nan is neither None nor a number of seconds"),
    ],
)
def test_a_value_that_is_wrong(keywords: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said.replace("(", r"\(")):
        sistap.Tap("/dev/no-such-port", **keywords)  # type: ignore[arg-type]


PORT = 'a port is a text or a Path such as "/dev/ttyUSB0" (the rate is baud=9600), not '


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda _: sistap.Tap("/dev/x", 9600), TypeError, f"{PORT}9600"),  # type: ignore[arg-type]
        (lambda _: sistap.Tap("/dev/x", 9600, 8), TypeError, f"{PORT}9600"),  # type: ignore[arg-type]
        (lambda _: sistap.Tap(5), TypeError, f"{PORT}5"),  # type: ignore[arg-type]
        (lambda _: sistap.Tap(None), TypeError, f"{PORT}None"),  # type: ignore[arg-type]
        (lambda _: sistap.Tap(["/dev/x"]), TypeError, f"{PORT}['/dev/x']"),  # type: ignore[arg-type]
        (lambda _: sistap.Tap(""), ValueError, "a port is empty"),
        (lambda _: sistap.Tap("/dev/x", timeout="a"), TypeError, "timeout is a number of seconds, not 'a'"),  # type: ignore[arg-type]
        (lambda _: sistap.Tap("/dev/x", format=8), TypeError, 'format is a text such as "8E1", not 8'),  # type: ignore[arg-type]
        (lambda _: sistap.Tap("/dev/x", framing=None), TypeError, 'framing is a text such as "sis", not None'),  # type: ignore[arg-type]
        (lambda _: sistap.play("demo", duration_s="x"), TypeError, "duration_s is a number of seconds, not 'x'"),  # type: ignore[arg-type]
        (lambda _: sistap.play("demo", duration_s=None), TypeError, "duration_s is a number of seconds, not None"),  # type: ignore[arg-type]
        (lambda _: sistap.play("demo", duration_s=-1), ValueError, "duration_s=-1 is neither None nor a number of"),
        (lambda _: sistap.play("demo", duration_s=1, seed="x"), TypeError, "seed is a whole number, not 'x'"),  # type: ignore[arg-type]
        (lambda _: sistap.play("no", duration_s=1), ValueError, "no is neither FILE.toml nor a built-in scenario"),
        (lambda _: sistap.Writer(None), TypeError, "path is a text or a Path, not None"),  # type: ignore[arg-type]
        (lambda path: sistap.Writer(path).write(None), TypeError, "what a Writer writes is a Record, not None"),  # type: ignore[arg-type]
        (lambda _: next(sistap.dissect([1])), TypeError, "what a Writer writes is a Record, not 1"),  # type: ignore[list-item]
    ],
)
def test_an_argument_that_is_wrong(
    call: Callable[[Path], object], kind: type[Exception], said: str, tmp_path: Path
) -> None:
    """At once, and with what is right."""
    with pytest.raises(kind) as caught:
        call(tmp_path / "new.pcapng")
    assert str(caught.value).startswith(said)


@terminals
def test_a_port_as_a_path(line: Line) -> None:
    with sistap.Tap(Path(line.name)) as tap:
        record = tap.read(LONG_S)
    assert record and line.name in record.data.decode()


def test_one_port_twice() -> None:
    with pytest.raises(ValueError, match="is the same port again: the second one is that of the other direction"):
        sistap.Tap("/dev/no-such-port", "/dev/no-such-port")


@terminals
def test_both_directions(line: Line, tmp_path: Path) -> None:
    """A command on one line and its reaction on the other are an exchange, in Wireshark, too."""
    other = Line()
    try:
        with sistap.Tap(line.name, other.name) as tap:
            line.send(READ)
            records = []
            for record in tap:
                records.append(record)
                if record.data == READ:
                    other.send(ANSWER)
                if record.data == ANSWER:
                    tap.close()
    finally:
        other.go()
    command, reaction = (record.telegram for record in records if record.telegram)
    assert [record.line for record in records if record.telegram] == [1, 2]
    assert reaction.command == command
    answered = [one for packet in sistap.dissect(records) for one in packet.telegrams if one.command_in]
    assert len(answered) == 1


def test_a_virtual_bus() -> None:
    bus = [sys.executable, "-m", "sistap", "bus", "demo", "--duration", "5", "--fast", "--listen", "127.0.0.1:0"]
    with subprocess.Popen(bus, stdout=subprocess.PIPE, text=True, cwd=Path(sistap.__file__).parents[1]) as process:
        assert process.stdout
        with sistap.Tap(process.stdout.readline().strip()) as tap:
            found: list[sistap.Telegram] = []
            while len(found) < 4 and (record := tap.read(LONG_S)):
                if record.telegram:
                    found.append(record.telegram)
        process.kill()
    assert all(later.command == earlier for earlier, later in pairwise(found) if later.is_reaction and later.command)
    assert any(one.command for one in found)
