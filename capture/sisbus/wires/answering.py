# SPDX-License-Identifier: GPL-2.0-or-later
"""One half of the bus at a real master, at a pseudo terminal or a port: its stations, or a partner of 3964R."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, NoReturn, Protocol

from sisbus.playing.characters import Played
from sisbus.procedure3964.controls import S5, Ppc
from sisbus.procedure3964.partner import Saying
from sisbus.procedure3964.procedure import Procedure
from sisbus.scenarios.scenario import Playing
from sisbus.stations.initialization import Timing
from sisbus.stations.station import Station
from sisbus.wires.receiver import Receiver
from sisbus.wires.wire import Log, Pace
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.record import Record, Type

DAMAGED = "damaged"  # mark of a telegram with a wrong checksum, and of characters outside telegrams
_HEARD, _SAID = 1, 2  # lines


class Noting:
    """Logs characters and reactions in the order of their times."""

    def __init__(self, log: Log, settings: LineSettings, cut: Cut = SIS) -> None:
        """Begin at time 0 of the bus. May raise OSError, as do the methods below."""
        self._log = log
        self._settings = settings
        self._cut = cut
        self._framer = cut.framer(_HEARD, settings)
        self._last_ns = 0  # time of the last characters

    def heard(self, values: bytes, time_ns: int) -> None:
        """Take characters that came together, or none: after a silence a telegram is over."""
        if values:
            self._last_ns = time_ns
            self._write(self._framer.feed(_read(_HEARD, time_ns, values)))
        else:
            self._write(self._framer.idle(time_ns - self._last_ns))

    def said(self, reaction: bytes, time_ns: int) -> None:
        """Log a reaction that begins now: everything before it is over."""
        self.end()
        self._write(self._framer.beside(_read(_SAID, time_ns, reaction)))
        self._add(reaction, time_ns + self._settings.character_ns, [])

    def change(self, settings: LineSettings) -> None:
        """Continue with other settings."""
        self.end()
        self._settings = settings
        self._framer = self._cut.framer(_HEARD, settings)

    def end(self) -> None:
        """Log what is left."""
        self._write(self._framer.flush())

    def _write(self, records: Iterable[Record]) -> None:
        for record in records:
            good = record.type == Type.FRAME and not record.checksum_bad
            self._add(record.data, record.time_ns, [] if good else [DAMAGED])

    def _add(self, characters: bytes, time_ns: int, marks: list[str]) -> None:
        self._log.add(Played(time_ns, characters, [], marks, self._settings), [])


def _read(line: int, time_ns: int, values: bytes) -> Read:
    return Read(line, time_ns, values, bytes(len(values)))


# -- Stations that answer (IF02 chapters 2.4, 6 and 10) --------------------------------------------------------------

# `Answering` decides what they do and when; it knows no clock and no port. `serve` binds it to both.

_MS = 1_000_000
_SECOND = 1_000_000_000
_LOOK_NS = _SECOND // 2  # longest wait, e.g. to notice a signal on Windows
# Stands in for TzA, in character times, until the bus sets one: there is no default.
_CHARACTERS_WITHOUT_TZA = 4


class Port(Protocol):
    """The connection to the master."""

    @property
    def settings(self) -> LineSettings:
        """Return the settings with which it is open."""

    def read(self, timeout_s: float) -> bytes:
        """Return what arrived; empty if nothing did in that time."""

    def write(self, data: bytes) -> None:
        """Send."""

    def drain(self) -> None:
        """Return when everything was sent."""

    def change(self, settings: LineSettings) -> None:
        """Continue with other settings."""


class Answer(NamedTuple):
    """A reaction and its time."""

    time_ns: int
    reaction: bytes


class Answering:
    """The stations of a line: characters in, answers out; times are in ns since the bus was started."""

    def __init__(self, stations: Sequence[Station], settings: LineSettings) -> None:
        self._settings = settings
        self._ears = [_Ear(station, settings.baud) for station in stations]

    @property
    def settings(self) -> LineSettings:
        """Return the settings of the line. The rate is the last one that any station was told to use."""
        return self._settings

    def hear(self, values: bytes, time_ns: int) -> list[Answer]:
        """Take characters that came together; return the answers."""
        answers: list[Answer] = []
        for value in values:
            for ear in self._listening():
                command = ear.receiver.hear(value, time_ns, ear.tza_ns(time_ns, self._settings))
                answers += self._answer(ear, command, time_ns)
                answers += self._say(ear, value, time_ns)
            self._follow(time_ns)
        return answers

    def wait(self, now_ns: int) -> list[Answer]:
        """Let time pass: a damaged telegram ends, or a test of a rate begins or ends."""
        answers: list[Answer] = []
        for ear in self._listening():
            damaged = ear.receiver.silence(now_ns, ear.tza_ns(now_ns, self._settings))
            answers += self._answer(ear, damaged, now_ns)
        self._follow(now_ns)
        return answers

    def wake_ns(self, now_ns: int) -> int | None:
        """Return when `wait` has something to do if nothing is heard until then; None: never."""
        tests = [ear.station.initialization.test_ends_ns(now_ns) for ear in self._ears]
        silences = [ear.receiver.silence_ends_ns(ear.tza_ns(now_ns, self._settings)) for ear in self._listening()]
        return min((time_ns for time_ns in (*tests, *silences) if time_ns is not None), default=None)

    def _listening(self) -> list[_Ear]:
        """Return the stations that hear the line: those with its rate."""
        return [ear for ear in self._ears if ear.baud == self._settings.baud]

    def _answer(self, ear: _Ear, command: bytes | None, now_ns: int) -> Iterator[Answer]:
        reaction = ear.station.react(command, now_ns) if command else None
        if reaction is not None:
            yield Answer(now_ns + ear.pause_ns(now_ns, self._settings), reaction)

    def _say(self, ear: _Ear, value: int, now_ns: int) -> Iterator[Answer]:
        """Let it hear a character of the ASCII protocol."""
        said = ear.station.terminal.hear(value, now_ns) if ear.station.terminal else None
        if said is not None:
            yield Answer(now_ns + self._settings.character_ns, said)

    def _follow(self, now_ns: int) -> None:
        """Set the line to the rate of a station whose rate has changed since the last look."""
        for ear in self._ears:
            baud = ear.station.initialization.timing(now_ns).baud
            if baud != ear.baud:
                ear.baud = baud
                self._settings = self._settings._replace(baud=baud)


class _Ear:
    """A station and its receiver."""

    def __init__(self, station: Station, baud: int) -> None:
        self.station = station
        self.baud = baud
        self.receiver = Receiver()
        station.initialization.power_on(baud)

    def tza_ns(self, now_ns: int, settings: LineSettings) -> int:
        """Return the longest interval between the characters of a telegram."""
        tza = self._timing(now_ns).tza
        return settings.character_ns * _CHARACTERS_WITHOUT_TZA if tza is None else tza * _MS

    def pause_ns(self, now_ns: int, settings: LineSettings) -> int:
        """Return the delay of a reaction: more than TzA, else its start is not recognised, and less than TrS."""
        tza_ns, trs = self.tza_ns(now_ns, settings), self._timing(now_ns).trs
        pause_ns = tza_ns + settings.character_ns
        return pause_ns if trs is None else max(tza_ns, min(pause_ns, trs * _MS))

    def _timing(self, now_ns: int) -> Timing:
        return self.station.initialization.timing(now_ns)


def serve(port: Port, stations: Sequence[Station], pace: Pace | None = None, noting: Noting | None = None) -> NoReturn:
    """Answer the master at a port until a signal handler raises something, or the port is lost.

    The stations begin with the rate of the port; when they are told another one, the port changes to it. `noting` logs
    what comes and what is answered.
    """
    clock = pace or Pace()
    answering = Answering(stations, port.settings)
    try:
        _serve(port, answering, clock, noting)
    finally:
        if noting:
            noting.end()


def _serve(port: Port, answering: Answering, clock: Pace, noting: Noting | None) -> NoReturn:
    while True:
        now_ns = clock.now_ns()
        wake_ns = answering.wake_ns(now_ns)
        until_ns = now_ns + _LOOK_NS if wake_ns is None else min(wake_ns, now_ns + _LOOK_NS)
        values = port.read(max(0.0, clock.left_s(until_ns)))
        now_ns = clock.now_ns()
        if noting:
            noting.heard(values, now_ns)
        answers = answering.hear(values, now_ns) + answering.wait(now_ns)
        _tune(port, answering, noting)
        for answer in answers:
            clock.wait_until(answer.time_ns)
            if noting:
                noting.said(answer.reaction, clock.now_ns())
            port.write(answer.reaction)
            port.drain()
        if answers:
            answering.wait(clock.now_ns())  # a test begins after its reaction is sent
            _tune(port, answering, noting)


def _tune(port: Port, answering: Answering, noting: Noting | None) -> None:
    if port.settings != answering.settings:
        port.change(answering.settings)
        if noting:
            noting.change(answering.settings)


# -- An S5 or a PPC with a real partner of procedure 3964R -----------------------------------------------------------


class PartnerPort(Port, Protocol):
    """The connection to the partner."""

    def wait_for_partner(self) -> None:
        """Return when somebody may be there."""


def meet_partner(port: PartnerPort, procedure: Procedure, how: Playing, pace: Pace, noting: Noting | None) -> None:
    """Play the PPC until a signal comes, or the S5 until its end; then print its counts."""
    if procedure.has_ppc:
        meet(port, procedure.ppc(), how.end_ns, pace, noting)
        return
    s5 = procedure.s5(how.seed, how.cycles)
    port.wait_for_partner()
    try:
        meet(port, s5, how.end_ns, pace, noting)
    finally:
        print(s5.counts, flush=True)


def meet(port: Port, station: S5 | Ppc, end_ns: float, pace: Pace | None = None, noting: Noting | None = None) -> None:
    """Play one side at a port until it is over, or until that time of the bus. `noting` logs what comes and goes."""
    clock = pace or Pace()
    try:
        while not station.over and clock.now_ns() < end_ns:
            _step(port, station, clock, noting)
    finally:
        if noting:
            noting.end()


def _step(port: Port, station: S5 | Ppc, clock: Pace, noting: Noting | None) -> None:
    """Wait for characters or until something is due, and act on it."""

    def say(saying: Saying | None) -> None:
        if saying is None:
            return
        if noting:
            noting.said(saying.said, clock.now_ns())
        port.write(saying.said)
        port.drain()
        station.partner.said(clock.now_ns())

    latest_ns = clock.now_ns() + _LOOK_NS
    due_ns = station.due_ns
    values = port.read(max(0.0, clock.left_s(latest_ns if due_ns is None else min(due_ns, latest_ns))))
    now_ns = clock.now_ns()
    if noting:
        noting.heard(values, now_ns)
    for value in values:
        say(station.partner.hear(value, now_ns))
    station.look(now_ns)
    say(station.partner.look(now_ns))
