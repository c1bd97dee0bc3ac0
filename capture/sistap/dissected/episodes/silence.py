# SPDX-License-Identifier: GPL-2.0-or-later
"""Silences: of the bus, and of stations that do not answer."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from sistap.dissected.episodes.episode import Hit
from sistap.dissected.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.dissected.packets.dissection import Packet, Telegram
from sistap.dissected.wireshark.rows import EVENT

_USUAL = 200  # silences that say what is usual
_ENOUGH, _FEW = 20, 3  # with fewer, it is not certain, or not known at all
_TIMES_HEARD = 2  # a bus that was heard for less than so many silences may pause as long as usual
_LONG_HEARD_S = 900.0  # a bus that was heard for longer is known
_LONG_KEPT = 40  # long silences among which a rhythm is looked for
AT_FIRST = "at first"  # topic of the silence of a station that had not answered yet


def seconds(time_s: float) -> str:
    """Write a duration."""
    return f"{time_s:.0f} s" if time_s >= 10 else f"{time_s:.1f} s"


class _Long(NamedTuple):
    """A long silence."""

    length_s: float
    since_s: float  # from the beginning of the one before

    def is_like(self, other: _Long, part: float) -> bool:
        """Tell whether they differ by no more than a part."""
        return all(abs(one - two) <= part * two for one, two in zip(self, other, strict=True))


class BusSilence:
    """The bus of a port without any character.

    A long silence is usual where the bus was heard too shortly to tell. Where it comes in a rhythm, it may be: a master
    may ask once a minute. No other is: a loose cable is off again and again, and each time counts.
    """

    def __init__(self, thresholds: Thresholds = THRESHOLDS) -> None:
        """Begin with nothing known."""
        self._thresholds = thresholds
        self._usual: deque[float] = deque(maxlen=_USUAL)
        self._long: deque[_Long] = deque(maxlen=_LONG_KEPT)
        self._long_s = 0.0  # when the last long one began
        self._last: Packet | None = None
        self._began_s = 0.0
        self._is_told = False  # that it is silent now

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return the silence before a packet."""
        if packet.type == EVENT:
            if packet.is_unheard:
                self._last = None
            return ()
        last, self._last = self._last, packet
        self._is_told = False
        if last is None:
            self._began_s = packet.epoch_s
            return ()
        apart_s = packet.epoch_s - last.ended_s
        # The interval is that of its line, of which a bus may have two. Time stamps may jump.
        silence_s = apart_s if packet.since_s is None else min(packet.since_s, apart_s)
        begin_s = packet.epoch_s - silence_s
        if silence_s < self._thresholds.bus_silent_s or not self._is_long(silence_s):
            self._usual.append(silence_s)
            return ()
        is_known = self._is_known(begin_s, silence_s)
        if not is_known:
            self._usual.append(silence_s)
        hit = _bus_silent(packet, begin_s, packet.epoch_s)
        if self._is_in_rhythm(begin_s, silence_s):
            detail = f"{seconds(silence_s)} each: a master that pauses, or a loose cable?"
            return (hit._replace(kind="rhythm", detail=detail),)
        return (hit if is_known else hit._replace(severity=Severity.NOTE),)

    def under_way(self, now_s: float) -> Iterable[Hit]:
        """Return the silence that still lasts, once."""
        if self._last is None or self._is_told:
            return ()
        begin_s = self._last.ended_s
        silence_s = now_s - begin_s
        is_long = silence_s >= self._thresholds.bus_silent_s and self._is_long(silence_s)
        self._is_told = is_long and self._is_known(begin_s, silence_s)
        return (_bus_silent(self._last, begin_s, now_s),) if self._is_told else ()

    def _is_known(self, begin_s: float, silence_s: float) -> bool:
        """Tell whether the bus was heard for long enough to know what is usual."""
        heard_s = begin_s - self._began_s
        return len(self._usual) >= _ENOUGH and heard_s >= min(_TIMES_HEARD * silence_s, _LONG_HEARD_S)

    def _is_in_rhythm(self, begin_s: float, silence_s: float) -> bool:
        long = _Long(silence_s, begin_s - self._long_s)
        alike = sum(long.is_like(other, self._thresholds.rhythm_part) for other in self._long)
        self._long.append(long)
        self._long_s = begin_s
        return alike >= self._thresholds.rhythm_times

    def _is_long(self, silence_s: float) -> bool:
        return len(self._usual) >= _FEW and silence_s > self._thresholds.bus_silent_times * max(self._usual)


def _bus_silent(packet: Packet, begin_s: float, end_s: float) -> Hit:
    detail = f"{seconds(end_s - begin_s)}: cable or master off?"
    return Hit("bus_silent", packet.number, begin_s, end_s, None, "", detail, end_s - begin_s, port=packet.interface)


@dataclass
class _Asked:
    """A station, and its commands without a reaction since it last answered."""

    count: int = 0
    is_repeated: bool = False
    from_s: float = 0.0
    to_s: float = 0.0
    first: int = 0  # packet
    has_answered: bool = False


class StationSilence:
    """Stations that do not answer, or only when asked again."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS, before: StationSilence | None = None) -> None:
        """Begin with nobody asked. Who answered in a good capture is there."""
        self._thresholds = thresholds
        self._there = set(before.answered()) if before else set()
        self._stations: dict[int, _Asked] = {}
        self._pending: tuple[Packet, Telegram] | None = None  # a command without a reaction: perhaps that is damaged
        self._grown: int | None = None  # the station whose silence began, or went on, with the last telegram

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return silences that end with a packet."""
        hits: list[Hit] = list(self._part(packet.interface)) if packet.is_seam else []
        telegrams = packet.telegrams
        is_good = telegrams and telegrams[0].good  # nearly always
        if not is_good and packet.type != EVENT and not any(telegram.good for telegram in telegrams):
            self._pending = None  # what came may have been the reaction
        for telegram in telegrams:
            if telegram.good:
                self._resolve()
                if telegram.is_reaction:
                    hits += self._answered(packet, telegram)
                elif telegram.unanswered:
                    self._pending = packet, telegram
                elif telegram.is_repeat and telegram.listener in self._stations:
                    self._stations[telegram.listener].is_repeated = True
        return hits

    def command(self, packet: Packet) -> Iterable[Hit]:
        """Take a command that was answered."""
        self._resolve()
        return ()

    def reaction(self, packet: Packet) -> Iterable[Hit]:
        """Take a good reaction."""
        return self._answered(packet, packet.telegrams[0])

    def finish(self, port: str) -> Iterator[Hit]:
        """Yield silences that last to the end."""
        for hit in self._last(port):
            was_there = hit.kind == "silent" and hit.severity is None  # else it never answered
            again = "" if hit.topic == AT_FIRST else " again"
            yield hit._replace(outcome=f"not heard{again}") if was_there else hit

    def _last(self, port: str) -> Iterator[Hit]:
        self._resolve()
        for station, asked in self._stations.items():
            yield from self._told(port, station, asked)

    def _part(self, port: str) -> Iterator[Hit]:
        """Yield silences that last to the end of a capture, and forget them; its last reaction may be missing."""
        self._pending = None
        yield from self._last(port)
        self._stations = self.answered()

    def expect_nobody(self) -> None:
        """Forget who answered in the good capture: that was another bus."""
        self._there.clear()

    def answered(self) -> dict[int, _Asked]:
        """Return the stations that have answered, as if nobody had asked them since."""
        return {station: _Asked(has_answered=True) for station, one in self._stations.items() if one.has_answered}

    def _resolve(self) -> None:
        if not self._pending:
            return
        packet, telegram = self._pending
        self._pending = None
        if telegram.listener is None:
            return
        asked = self._stations.setdefault(telegram.listener, _Asked())
        if not asked.count:
            asked.from_s, asked.first = packet.epoch_s, packet.number
        asked.count += 1
        asked.is_repeated |= telegram.is_repeat
        asked.to_s = packet.ended_s
        self._grown = telegram.listener

    def under_way(self, port: str) -> Iterable[Hit]:
        """Return the silence that began, or went on. A station that never answered is perhaps not there."""
        station, self._grown = self._grown, None
        asked = None if station is None else self._stations.get(station)
        return self._told(port, station, asked) if asked and station is not None and asked.has_answered else ()

    def _answered(self, packet: Packet, telegram: Telegram) -> Iterable[Hit]:
        if telegram.talker is None:
            return ()
        asked = self._stations.get(telegram.talker)
        if asked and not asked.count and asked.has_answered:
            asked.is_repeated = False
            return ()
        self._stations[telegram.talker] = _Asked(has_answered=True)
        if not asked:
            return ()
        asked.to_s = packet.epoch_s
        return self._told(packet.interface, telegram.talker, asked, is_over=True)

    def _told(self, port: str, station: int, asked: _Asked, *, is_over: bool = False) -> Iterator[Hit]:
        if not asked.count:
            return
        kind, detail, severity, topic = "unanswered", "", None, ""
        lasted_s = asked.to_s - asked.from_s
        if asked.count >= self._thresholds.silent_commands and lasted_s >= self._thresholds.silent_s:
            kind, detail = "silent", f"{seconds(lasted_s)}, {asked.count} commands without a reaction"
            if not asked.has_answered and (is_over or station in self._there):
                topic = AT_FIRST
            elif not asked.has_answered:
                detail, severity = f"never answered {asked.count} commands", Severity.WARNING
        elif asked.is_repeated:
            kind, detail = "repeated", "a command without a reaction"
        place = asked.first, asked.from_s, asked.to_s, station
        yield Hit(kind, *place, "", detail, float(asked.count), severity, port, topic=topic)
