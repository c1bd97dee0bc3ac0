# SPDX-License-Identifier: GPL-2.0-or-later
"""Who asks on the bus: usual masters, visitors, masters that vanish."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from sistap.dissected.accesses.access import Parameter
from sistap.dissected.episodes.episode import Hit, numbers
from sistap.dissected.episodes.rules import THRESHOLDS, Thresholds
from sistap.dissected.packets.dissection import Packet, Telegram

_TOKEN = 0x0F
_SINCE = 50  # commands of others after which a master that is not heard is missing


def station_of(parameter: Parameter) -> int:
    """Return the station that the master addresses; others may be behind it: `3/2/8`."""
    return int(parameter.station.partition("/")[0])


def drive_of(parameter: Parameter) -> tuple[str, int]:
    """Return what tells apart the drives at a station. One answers to its own address and to 0 (fig. 8-2)."""
    return parameter.station, parameter.device or int(parameter.station.rpartition("/")[2])


@dataclass
class _Master:
    """What is known of a master. Its clock stands still while the bus is silent."""

    packet: int
    from_s: float
    to_s: float
    at_s: float  # of its last command, by that clock
    longest_s: float = 0.0  # pause
    commands: int = 0
    stations: set[int] = field(default_factory=set)
    before: int = 0  # commands of all until its last one
    read: int = 0  # parameters
    written: int = 0


class Masters:
    """The masters of a bus."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS, before: Masters | None = None) -> None:
        """Begin with those that asked in a good capture, or with none."""
        self._thresholds = thresholds
        self._usual: set[int] = set(before.asked) if before else set()
        self._absent: dict[int, _Master] = dict(before.present()) if before else {}  # asked until its end, not yet here
        self._is_learning = not self._usual
        self._invited: set[int] = set()  # who got a token
        self._masters: dict[int, _Master] = {}
        self._commands = 0
        self._began_s: float | None = None
        self._last_s = 0.0
        self._silent_s = 0.0  # for so long was the bus silent
        self._begun: list[Hit] = []

    @property
    def asked(self) -> set[int]:
        """Return the masters that asked."""
        return set(self._masters)

    def is_new(self, master: int | None) -> bool:
        """Tell whether it asked neither at the beginning nor in the good capture. Who asks in ASCII is not known."""
        return master is not None and master not in self._usual

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Learn who asks."""
        self._begun.clear()  # nobody asks for them but while it happens
        if self._began_s is None:
            self._began_s = self._last_s = packet.epoch_s
        if packet.epoch_s - self._last_s > self._thresholds.bus_silent_s:  # then no master is missing
            self._silent_s += packet.epoch_s - self._last_s
        self._last_s = packet.epoch_s
        for telegram in packet.telegrams:
            if telegram.good and not telegram.is_reaction and telegram.talker is not None:
                self._take(packet, telegram, telegram.talker)
        return ()

    def _take(self, packet: Packet, telegram: Telegram, number: int) -> None:
        self._commands += 1
        if self._is_learning:
            self._usual.add(number)
            is_long = self._last_s - (self._began_s or 0.0) >= self._thresholds.learning_masters_s
            self._is_learning = self._commands < self._thresholds.learning_commands or not is_long
        now_s = self._last_s - self._silent_s
        master = self._masters.get(number)
        if master is None:
            master = self._masters[number] = _Master(packet.number, packet.epoch_s, 0.0, now_s)
            self._absent.pop(number, None)
        master.longest_s = max(now_s - master.at_s, master.longest_s)
        master.at_s, master.to_s, master.before = now_s, packet.ended_s, self._commands
        master.commands += 1
        if telegram.listener is not None:
            master.stations.add(telegram.listener)
            if telegram.service == _TOKEN:
                self._invited.add(telegram.listener)
        if master.commands == self._thresholds.learning_commands and number in self._invited:
            self._usual.add(number)  # a control that takes turns with another one
        if number not in self._usual and telegram.listener not in self._usual:  # to a master: a token
            place = packet.number, packet.epoch_s, packet.ended_s, telegram.listener
            detail = f"asked by new master {number}"
            self._begun.append(Hit("master", *place, detail=detail, port=packet.interface, topic=str(number)))

    def count(self, master: int | None, *, is_write: bool) -> None:
        """Count an access of a master."""
        known = None if master is None else self._masters.get(master)
        if known:
            known.written += is_write
            known.read += not is_write

    def begun(self) -> list[Hit]:
        """Return the commands of new masters in the last packet, once."""
        begun, self._begun = self._begun, []
        return begun

    def finish(self, port: str) -> Iterator[Hit]:
        """Yield the visits of new masters, and masters that are not heard any more."""
        for number, master in self._masters.items():
            if number not in self._usual:
                if master.stations - self._usual:
                    yield _visit(port, number, master)
            elif self._has_left(master):
                detail = f"asks nothing any more, others do ({master.commands} commands until then)"
                yield self._vanished(port, self._last_s - self._missed_s(master), f"master {number} {detail}")
        began_s = self._began_s or 0.0
        for number, master in self._absent.items():
            if self._is_missed(master, self._last_s - self._silent_s - began_s, self._commands):
                yield self._vanished(port, began_s, f"master {number} asks nothing, but did in the good capture")

    def expect_nobody(self) -> None:
        """Forget who asked in the good capture until its end: that was another bus."""
        self._absent.clear()

    def present(self) -> Iterator[tuple[int, _Master]]:
        """Yield the usual masters that have not left. Whoever asked little is never missed."""
        for number, master in self._masters.items():
            if number in self._usual and not self._has_left(master):
                yield number, master

    def _has_left(self, master: _Master) -> bool:
        return self._is_missed(master, self._missed_s(master), self._commands - master.before)

    def _missed_s(self, master: _Master) -> float:
        return self._last_s - self._silent_s - master.at_s

    def _is_missed(self, master: _Master, missed_s: float, commands: int) -> bool:
        """Tell whether a master is missed that asked nothing for so long, and during so many commands of others."""
        usual_s = self._thresholds.vanished_times * master.longest_s
        is_known = master.commands >= self._thresholds.learning_commands
        return is_known and missed_s > max(self._thresholds.vanished_s, usual_s) and commands >= _SINCE

    def _vanished(self, port: str, from_s: float, detail: str) -> Hit:
        return Hit("vanished", 0, from_s, self._last_s, None, "", detail, self._last_s - from_s, port=port)


def _visit(port: str, number: int, master: _Master) -> Hit:
    said = f"master {number} asked {numbers(master.stations)}"
    did = f"{said}: {_count(master.commands, 'command')}, {_count(master.read, 'value')} read, {master.written} written"
    return Hit("master", master.packet, master.from_s, master.to_s, None, "", did, port=port, topic=str(number))


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"
