# SPDX-License-Identifier: GPL-2.0-or-later
"""A master at a real port: sends commands, and waits for reactions and for the times of the bus (IF02 chapter 10)."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing

from sisbus.playing.characters import Played
from sisbus.playing.conducting import Exchange, Rate, conduct, is_answered
from sisbus.playing.player import Times
from sisbus.scenarios.scenario import Playing, Scenario
from sisbus.wires.port import TransmittingPort
from sisbus.wires.wire import Log, Pace
from sistap.tap.line.clock import CLOCK
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.framer import SisFramer
from sistap.tap.records.record import Record, Type
from sistap.tap.sis.initialization import Follow, RateChange
from sistap.tap.sis.telegram import parse

_MS = 1_000_000
_HELD_BACK_NS = 20 * _MS  # longest delay of a USB adapter: its latency timer, and the transfer
_LOOK_S = 0.005
_LINE = 0

UNASKED = "unasked"  # the mark of unrequested or damaged characters


class RealLine:
    """A line behind a port, with stations that are not simulated."""

    collided = False

    def __init__(self, port: TransmittingPort, times: Times) -> None:
        self.commands = self.reactions = self.unanswered = 0
        self._port = port
        self._times = times
        self._pace = Pace()
        self._follow = Follow(port.settings.baud)

    @property
    def settings(self) -> LineSettings:
        """Return the present settings."""
        return self._port.settings

    @property
    def now_ns(self) -> int:
        """Return the time in ns since the line was opened."""
        return self._pace.now_ns()

    @property
    def counts(self) -> str:
        """Return the counts of what was sent and heard, in words."""
        return f"{self.commands} commands, {self.reactions} reactions, {self.unanswered} commands not answered"

    def exchange(self, command: bytes, rival: bytes | None = None) -> Exchange:
        """Send a command; return its reaction, or None if none begins within TrS. May raise PortLost, PortError."""
        self._go_to(self._follow.due(self.now_ns))
        yield from self._unasked()
        yield self._sent(command)
        self.commands += 1
        self._go_to(self._follow.take(command, self.now_ns))  # a station that accepts alone answers at the new rate
        reaction = None
        if is_answered(command):
            reaction = yield from self._reaction(command)
            self.unanswered += reaction is None
        else:
            self.wait(self._times.trs * _MS)
        if reaction is not None:
            self.reactions += 1
            self._go_to(self._follow.take(reaction, self.now_ns))
        # A start is recognised only after a silence longer than TzA (chapter 10.3).
        self.wait(2 * self._times.tza * _MS)
        return reaction

    def send(self, characters: bytes) -> Iterator[Played]:
        """Send characters that need no answer; log what comes anyway. May raise PortLost."""
        yield from self._unasked()
        yield self._sent(characters)
        self.wait(self._times.trs * _MS)

    def type(self, characters: bytes) -> Iterator[Played]:
        """Send a line of the ASCII protocol; what comes back is logged before the next one. May raise PortLost."""
        return self.send(characters)

    def wait(self, ns: int) -> None:
        """Be silent for that long."""
        time.sleep(ns / 1e9)

    def change(self, rate: Rate) -> None:
        """Continue at another rate. May raise PortError."""
        self.wait(rate.after_ms * _MS)
        self._port.change(self.settings._replace(baud=rate.baud))

    def _go_to(self, change: RateChange | None) -> None:
        if change:
            self._port.change(self.settings._replace(baud=change.baud))

    def _sent(self, characters: bytes) -> Played:
        """Send; return when the last character must have left."""
        begun_ns = self.now_ns
        character_ns = self.settings.character_ns
        self._port.write(characters)
        self._port.drain()
        self.wait(max(0, begun_ns + len(characters) * character_ns - self.now_ns))
        return Played(begun_ns + character_ns, characters, [], [], self.settings)

    def _reaction(self, command: bytes) -> Exchange:
        """Wait for the reaction. It must begin within TrS, without a pause longer than TzA."""
        framer = SisFramer(_LINE, self.settings)
        reaction = None
        until_ns = self.now_ns + self._times.trs * _MS + _HELD_BACK_NS
        while reaction is None and self.now_ns < until_ns:
            data = self._port.read(_LOOK_S)
            if not data:
                continue
            until_ns = max(until_ns, self.now_ns + self._times.tza * _MS + _HELD_BACK_NS)
            for record in framer.feed(Read(_LINE, self.now_ns, data, bytes(len(data)))):
                if _answers(record, command):
                    reaction = record.data
                yield from self._heard(record, command)
        for record in framer.flush():
            yield from self._heard(record, command)
        return reaction

    def _heard(self, record: Record, command: bytes) -> Iterator[Played]:
        """Log what came, but not the adapter's echo of our own characters."""
        if record.data != command:
            marks = [] if _answers(record, command) else [UNASKED]
            yield Played(record.time_ns, record.data, [], marks, self.settings)

    def _unasked(self) -> Iterator[Played]:
        """Log what has come meanwhile, such as a late reaction."""
        if data := self._port.read(0):
            yield Played(self.now_ns, data, [], [UNASKED], self.settings)


def _answers(record: Record, command: bytes) -> bool:
    """Tell whether this is the reaction; it keeps the command's addresses, but a device may swap them."""
    if record.type != Type.FRAME or record.checksum_bad:
        return False
    asked, said = parse(command), parse(record.data)
    return (
        said.reaction
        and said.service == asked.service
        and {said.sender, said.receiver} == {asked.sender, asked.receiver}
        and (said.subaddresses, said.number) == (asked.subaddresses, asked.number)
    )


def talk(name: str, settings: LineSettings, scenario: Scenario, how: Playing, log: Log | None) -> None:
    """Play the masters of a scenario at a port, and print the result. May raise PortError, PortLost, OSError."""
    with closing(TransmittingPort(name, settings)) as port:
        line = RealLine(port, scenario.times_for(settings))
        if log:
            log.begin(f"{settings.baud} {settings.format}, {name}, time 0 is {CLOCK.now_ns()} ns since 1970")
        try:
            for one in conduct(line, scenario.scripts(line, how), how.end_ns):
                if log:
                    log.add(one, [])
        finally:
            print(line.counts, flush=True)
