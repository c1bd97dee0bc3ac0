# SPDX-License-Identifier: GPL-2.0-or-later
"""The checks of a driver: bytes, flags, messages and exit codes of sistap in the guest, never times."""

from __future__ import annotations

import json
import signal
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import truth
from machine import Guest, Program, eventually

from drivers import Driver, Line, ProgramLine, Settings, State, Watch
from sistap.dissected.captures.reading import records
from sistap.tap.line.settings import ERROR_FLAGS, Flag
from sistap.tap.records.record import Event, Type
from sistap.tap.terminal.exits import NotCaptured

# A telegram that reads S-0-0036 of station 3. It has zeros, which a wrong break detection would take for breaks.
TELEGRAM = bytes.fromhex("02 71 05 05 00 10 10 03 3c 00 24 00 00")
EVERY_VALUE = bytes(range(256))  # including FF, which a terminal doubles
BREAKS = 20
SHORT_SILENCE = "silence:20"
FIFO = 16  # characters of a 16550
JUDGED = 8000  # characters with known errors

# Rates and formats, and whether each driver must support them. It may refuse the others. If it accepts one, the device
# must really have it.
MUST_OPEN = (
    *("9600 8E1", "9600 8N1", "9600 8O1", "9600 7E1", "9600 8N2"),
    *("19200 8E1", "38400 8E1", "57600 8N1", "115200 8E1"),
)
MAY_OPEN = ("9600 8M1", "9600 8S1", "9600 6E1", "12000 8E1", "76800 8E1", "187500 8E1", "4000000 8E1")
CHANGES = ("19200 8E1", "187500 8E1", "12345 8N1", "76800 8E1", "115200 8E1", "9600 6E1", "9600 8E1")
BEARABLE = 0.03  # largest error of a rate


class NotJudged(Exception):
    """The device of this driver cannot do it here."""


class Seen(NamedTuple):
    """What one capture showed."""

    captured: Captured
    played: bytes
    lines: list[State]  # DTR and RTS
    states: list[dict[str, object]]  # of the port before, during and after it


@dataclass
class Bench:
    """A driver, and what was seen of it so far."""

    guest: Guest
    driver: Driver
    usbmon: Program
    looped: list[int] = field(default_factory=lambda: [0, 0])  # characters that the self-test sent
    _seen: Seen | None = None

    @property
    def seen(self) -> Seen:
        """What one capture showed, which several checks judge."""
        if self._seen is None:
            self._seen = _captured(self)
        return self._seen

    def start(self) -> None:
        """Make the ports."""
        self.driver.start(self.guest)
        self.watch: Watch = self.driver.watch(self.guest, self.usbmon)

    @property
    def line(self) -> Line:
        """The first port."""
        line: Line = self.driver.lines[0]
        return line

    def can(self, what: str) -> None:
        """Raise NotJudged if the device cannot do this."""
        if what not in self.driver.can:
            raise NotJudged(what)


class Capture:
    """A capture that runs in the guest."""

    def __init__(self, guest: Guest, *ports: str, user: str = "tap", framing: str = SHORT_SILENCE) -> None:
        """Start it, and wait until it listens. Short silences cut its records, so they are in the file at once."""
        self._guest = guest
        self.file = "/tmp/capture.pcapng"
        guest.run("rm", "-f", self.file)
        interfaces = [word for port in ports for word in ("-i", port)]
        options = ("--force", "--framing", framing, "-w", self.file)
        self.program: Program = guest.start("sistap", "capture", *interfaces, *options, user=user)
        self.program.until("capturing on")

    def read(self) -> Captured:
        """Return what is in the file so far."""
        return Captured.of(self._guest.read(self.file))

    def until(self, count: int, line: int = 0) -> None:
        """Wait for that many characters."""
        eventually(
            lambda: len(self.read().data(line)) >= count,
            lambda: f"{len(self.read().data(line))} of {count} characters came; {self.program.look()}",
        )

    def stop(self) -> Captured:
        """End it as Ctrl-C does."""
        done = self.program.stop()
        assert done.code == 0, f"exit code {done.code}: {done.said}"
        return self.read()


@dataclass
class Captured:
    """The contents of a capture file."""

    characters: dict[int, list[tuple[int, Flag]]]  # values and all flags
    events: list[tuple[Event, str]]

    @classmethod
    def of(cls, content: bytes) -> Captured:
        """Read it."""
        captured = cls({}, [])
        with tempfile.NamedTemporaryFile(suffix=".pcapng") as file:
            file.write(content)
            file.flush()
            try:
                for record in records(Path(file.name)):
                    if record.type == Type.EVENT:
                        captured.events.append((record.event, record.data.decode()))
                        continue
                    flags = map(Flag, record.flags)
                    captured.characters.setdefault(record.line, []).extend(zip(record.data, flags, strict=True))
            except NotCaptured:
                pass
        return captured

    def data(self, line: int = 0) -> bytes:
        """Return the characters of a line."""
        return bytes(value for value, _ in self.characters.get(line, ()))

    def flags(self, line: int = 0) -> list[Flag]:
        """Return their line errors."""
        return [flag & ERROR_FLAGS for _, flag in self.characters.get(line, ())]


def ports(bench: Bench) -> None:
    """The list has the port, its adapter and its driver."""
    bench.can("list")
    done = bench.guest.run("sistap", "ports", user="tap")
    device = bench.guest.run("readlink", "-f", bench.line.port).said.strip()
    row = next((row for row in done.said.splitlines() if row.split()[:1] == [device]), "")
    assert done.code == 0 and row, f"no {device}: {done.said}"
    assert all(words in row for words in bench.driver.described), row


def doctor(bench: Bench) -> None:
    """It opens the port for a permitted user, and tells others the cure."""
    done = bench.guest.run("sistap", "doctor", "-i", bench.line.port, user="tap")
    of_port = done.said.partition("good  port  ")[2]
    assert "bad  " not in of_port, done.said
    for words in ("good  rights", "good  opens", "good  adapter"):
        assert words in of_port, done.said
    done = bench.guest.run("sistap", "doctor", "-i", bench.line.port, user="outsider")
    assert "bad   rights" in done.said and "dialout" in done.said and done.code == 3, done


def capture(bench: Bench) -> None:
    """The capture has exactly the played characters, without an error."""
    _same(bench.seen.captured.data(), bench.seen.played)
    flags = bench.seen.captured.flags()
    assert not any(flags), f"false errors at {_where(flags)}"
    (started,) = (text for event, text in bench.seen.captured.events if event == Event.CAPTURE_STARTED)
    assert bench.driver.tells.clause in started, started


def formats(bench: Bench) -> None:
    """A setting that is not refused is what the device has; the settings of SIS are not refused."""
    program = bench.guest.start("opened", bench.line.port)
    program.until("{}")
    wrong = []
    for step in (*MUST_OPEN, *MAY_OPEN, "9600 8E1", *(f"change {change}" for change in CHANGES)):
        answers = len(program.lines())
        bench.watch.mark()
        program.say(step)
        eventually(lambda seen=answers: len(program.lines()) > seen, lambda: program.said)  # type: ignore[misc]
        answer = json.loads(program.lines()[-1])
        wished = _settings(step.removeprefix("change "))
        if "refused" in answer:
            if step in MUST_OPEN:
                wrong.append(f"{step}: {answer['refused']}")
        elif not _is_set(bench.watch, wished):
            wrong.append(f"{step}: recorded as {answer['settings']}, the device has {bench.watch.settings()}")
    program.kill()
    assert not wrong, "; ".join(wrong)


def breaks(bench: Bench) -> None:
    """Each break is marked, and nothing else."""
    bench.can("break")
    if not bench.driver.tells.breaks:
        raise NotJudged("break")
    running = Capture(bench.guest, bench.line.port)
    for number in range(BREAKS):
        bench.line.play(TELEGRAM[:9])
        bench.line.settle()
        bench.line.send_break()
        bench.line.play(TELEGRAM[9:])
        running.until((number + 1) * (len(TELEGRAM) + 1))
    captured = running.stop()
    flags = captured.flags()
    marked = [index for index, flag in enumerate(flags) if flag & Flag.BREAK]
    assert len(marked) == BREAKS, f"{len(marked)} of {BREAKS} breaks are marked"
    others = [index for index, flag in enumerate(flags) if flag and index not in marked]
    assert not others, f"{len(others)} characters beside the breaks are marked"
    data = bytearray(captured.data())
    assert {data.pop(index) for index in reversed(marked)} == {0}
    _same(bytes(data), TELEGRAM * BREAKS)


def errors(bench: Bench) -> truth.Figures:
    """What the driver says of characters with errors is told, and nothing else: judged by what was sent."""
    bench.can("errors")
    line = bench.line
    assert isinstance(line, ProgramLine)
    line.say(sticky=True)
    sent = truth.traffic(JUDGED)
    running = Capture(bench.guest, line.port)
    for part in truth.bursts(sent):
        line.play_characters(part)
    running.until(len(sent))
    found = running.stop().characters[0]
    line.say(sticky=False)
    return truth.judged(sent, found, bench.driver.tells, doubts_00=not bench.driver.tells.breaks)


def overrun(bench: Bench) -> None:
    """Lost characters are reported: at the character after them, and in the last line."""
    bench.can("overrun")
    if not bench.driver.tells.counts:
        raise NotJudged("overrun")
    running = Capture(bench.guest, bench.line.port)
    bench.line.play(TELEGRAM)
    running.until(len(TELEGRAM))
    if "errors" in bench.driver.can:
        bench.line.play(TELEGRAM, truth.LOST)
        running.until(2 * len(TELEGRAM))
    else:  # a FIFO that nobody can empty, with more breaks than it has room for
        bench.guest.monitor("stop")
        for _ in range(2 * FIFO):
            bench.line.send_break()
        bench.guest.monitor("cont")
        running.until(len(TELEGRAM) + FIFO)
    captured = running.stop()
    lost = [index for index, flag in enumerate(captured.flags()) if flag & Flag.LOST_BEFORE]
    assert lost and lost[0] >= len(TELEGRAM), f"characters lost are told at {lost}"
    assert captured.data().startswith(TELEGRAM)


def unplug(bench: Bench) -> None:
    """A lost port ends the capture with code 1, an event and a complete file; it comes back by the same name."""
    bench.can("unplug")
    running = Capture(bench.guest, bench.line.port)
    bench.line.play(TELEGRAM * 3)
    running.until(3 * len(TELEGRAM))
    bench.driver.unplug(bench.guest)
    try:
        done = running.program.wait()
    finally:
        bench.driver.plug(bench.guest)
    captured = running.read()
    assert done.code == 1 and "is gone: plug the adapter in" in done.said, done
    _same(captured.data(), TELEGRAM * 3)
    assert Event.ADAPTER_LOST in {event for event, _ in captured.events}, captured.events
    again = Capture(bench.guest, bench.line.port)
    bench.line.play(TELEGRAM)
    again.until(len(TELEGRAM))
    _same(again.stop().data(), TELEGRAM)


def two_lines(bench: Bench) -> None:
    """Both lines are complete; if one is unplugged, the other goes on, and the code is 1."""
    bench.can("unplug")
    one, other = bench.driver.lines
    running = Capture(bench.guest, one.port, other.port)
    for _ in range(8):
        one.play(TELEGRAM)
        other.play(EVERY_VALUE[:40])
    running.until(8 * len(TELEGRAM), 1)
    running.until(8 * 40, 2)
    bench.driver.unplug(bench.guest)
    try:
        if bench.driver.apart:
            running.program.until("the other line goes on")
            other.play(TELEGRAM)
            running.until(8 * 40 + len(TELEGRAM), 2)
            running.program.stop()
        done = running.program.wait()
    finally:
        bench.driver.plug(bench.guest)
    captured = running.read()
    _same(captured.data(1), TELEGRAM * 8)
    _same(captured.data(2), EVERY_VALUE[:40] * 8 + (TELEGRAM if bench.driver.apart else b""))
    assert done.code == 1, done


def selftest(bench: Bench) -> None:
    """With its lines joined, everything it sends comes back; without --transmit it sends nothing."""
    bench.can("loop")
    done = bench.guest.run("sistap", "selftest", "-i", bench.line.port)
    assert done.code == 2 and "add --transmit" in done.said, done
    before = len(bench.line.sent)
    bench.line.loop(on=True)
    options = "--transmit --baud 115200 --format 8N1 --duration 1".split()
    # At real-time priority it would leave no time to an adapter in software.
    done = bench.guest.run("sistap", "selftest", "-i", bench.line.port, *options, user="tap")
    bench.line.loop(on=False)
    bench.looped[0] += len(bench.line.sent) - before
    counted = int(next((line.split()[0] for line in done.said.splitlines() if "how late they were" in line), "0"))
    assert counted > 0 and counted == bench.looped[0], f"{bench.looped[0]} were sent: {done}"
    assert done.code == 0 or "are too few for p99.9" in done.said, done


def extcap(bench: Bench) -> None:
    """As Wireshark uses it: listed, captured into its pipe, ended by it. A user without rights gets code 3 and a
    reason.
    """
    bench.can("list")
    guest = bench.guest
    device = Path(bench.line.port).name
    listed = guest.run("sistap", "extcap", "--extcap-interfaces", user="tap").said
    assert f"{{value=sistap-{device}}}" in listed, listed
    asked = ("sistap", "extcap", "--capture", "--extcap-interface", f"sistap-{device}", "--fifo")
    guest.run("rm", "-f", "/tmp/pipe")
    guest.write("/tmp/piped", "")
    guest.run("mkfifo", "-m", "666", "/tmp/pipe")
    wireshark = guest.start("sh", "-c", "exec cat </tmp/pipe >/tmp/piped")
    program = guest.start(*asked, "/tmp/pipe", user="tap")
    eventually(lambda: bool(Captured.of(guest.read("/tmp/piped")).events), program.look)
    bench.line.play(TELEGRAM * 2)
    eventually(lambda: len(Captured.of(guest.read("/tmp/piped")).data()) >= 2 * len(TELEGRAM), program.look)
    program.signal(signal.SIGTERM)
    done = program.wait()
    wireshark.wait()
    assert done.code == 0, done
    _same(Captured.of(guest.read("/tmp/piped")).data(), TELEGRAM * 2)
    wireshark = guest.start("sh", "-c", "exec cat </tmp/pipe >/tmp/piped")
    done = guest.run(*asked, "/tmp/pipe", user="outsider")
    wireshark.wait()
    assert done.code == 3 and "no permission" in done.said, done


def restored(bench: Bench) -> None:
    """The latency timer, low latency and the FIFO trigger are set for a capture, and restored afterwards."""
    before, during, after = bench.seen.states
    assert before == after, f"before {before}, after {after}"
    for what, (was, tuned) in bench.driver.tuned.items():
        assert (before[what], during[what]) == (was, tuned), f"{what}: {before[what]}, then {during[what]}"


def passive(bench: Bench) -> None:
    """In all of this, except the self-test, not one byte was sent."""
    assert bench.seen
    for line, looped in zip(bench.driver.lines, bench.looped, strict=False):
        assert len(line.sent) == looped, f"{len(line.sent) - looped} characters were sent: {line.sent[:20].hex(' ')}"


def modem_lines(bench: Bench) -> str:
    """Opening raises DTR and RTS; one step lowers both, before anything is set, and they stay low."""
    lines = bench.seen.lines
    low, high = (False, False), (True, True)
    assert [(state.dtr, state.rts) for state in lines] == [low, high, low], f"DTR and RTS went {lines}"
    assert not lines[1].sets, "rate or format were set while DTR and RTS were high"
    return f"high for {(lines[2].ns - lines[1].ns) / 1e6:.1f} ms"


CHECKS: dict[str, Callable[[Bench], object]] = {
    "`ports`": ports,
    "`doctor`, by a user who may open the port, and by one who may not": doctor,
    "every character captured": capture,
    "DTR and RTS: down in one step, before the rate is set": modem_lines,
    "tuned, and set back": restored,
    "rates and formats: refused, or really set": formats,
    "breaks": breaks,
    "errors, breaks and losses among data": errors,
    "overruns": overrun,
    "unplugged, plugged in again": unplug,
    "two lines, one unplugged": two_lines,
    "`selftest`": selftest,
    "`extcap` as an ordinary user": extcap,
    "0 bytes sent": passive,
}


def _captured(bench: Bench) -> Seen:
    before = _state(bench)
    bench.watch.mark()
    running = Capture(bench.guest, bench.line.port, user="root", framing="sis")  # root may set a FIFO's trigger
    during = _state(bench)
    played = (TELEGRAM * 3 + EVERY_VALUE) * 4
    for start in range(0, len(played), 50):
        bench.line.play(played[start : start + 50])
    running.until(len(played))
    captured = running.stop()
    return Seen(captured, played, bench.watch.lines(), [before, during, _state(bench)])


def _state(bench: Bench) -> dict[str, object]:
    done = bench.guest.run("port", bench.line.port)
    assert done.code == 0, done.said
    state: dict[str, object] = json.loads(done.said)
    return state


def _settings(text: str) -> Settings:
    baud, form = text.split()
    return Settings(float(baud), form)


def _is_set(watch: Watch, wished: Settings) -> bool:
    """Tell whether the device has these settings, or no new ones; requests may be on their way."""
    end = time.monotonic() + 2
    while True:
        now = watch.settings()
        if now and now.format == wished.format and abs(now.baud - wished.baud) <= BEARABLE * wished.baud:
            return True
        if time.monotonic() > end:
            return False
        time.sleep(0.05)


def _same(found: bytes, played: bytes) -> None:
    if found != played:
        pairs = enumerate(zip(found, played, strict=False))
        at = next((index for index, (one, other) in pairs if one != other), min(len(found), len(played)))
        raise AssertionError(
            f"{len(found)} characters instead of {len(played)}; from {at} on {found[at : at + 9].hex(' ')} instead of "
            f"{played[at : at + 9].hex(' ')}"
        )


def _where(flags: Sequence[Flag]) -> list[int]:
    return [index for index, flag in enumerate(flags) if flag]
