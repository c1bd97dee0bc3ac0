# SPDX-License-Identifier: GPL-2.0-or-later
"""Hits in single telegrams: times against their limits, damage, refusals, what the dissector notes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import MOST
from sistap.dissected.episodes.episode import Hit
from sistap.dissected.episodes.masters import station_of
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.packets.dissection import DOUBTFUL, EXCEEDED, LOST, Judged, Packet, Telegram
from sistap.dissected.wireshark.rows import OTHER
from sistap.tap.records.record import Event, interval_text
from sistap.tap.sis.limits import limit_text
from sistap.tap.sis.telegram import FIRST_GROUP, service_name

_KINDS = {"damaged": "damaged", "error_reaction": "error"}  # of faults in the table
_LIMITS = (("late", "TrS", "reaction"), ("interval", "TzA", "pause"), ("cycle", "Tmas", "cycle"))
_PARAMETERS = {0x0, 0x1}  # the last digit of a service that reads parameters
_BUSY = ("0x8001", "0x800b", "0x800c")  # the channel is busy: the master asks again (fig. 2-19)
_BAD_RUN, _GOOD_RUN = 20, 5  # records in a row: so many make a bus unreadable, or readable again
_UNREADABLE_S = 3.0
PERHAPS = "perhaps: "  # before a time whose verdict is not certain
_FEW = 5  # damaged telegrams without a good one: it is not SIS


def ms(time_s: float) -> str:
    """Write a time as the dissector writes it."""
    return interval_text(round(time_s * 1e9))


def slave(telegram: Telegram) -> int | None:
    """Return the station that a telegram is about: not the master; None for a group, or all."""
    station = telegram.talker if telegram.is_reaction else telegram.listener
    return None if station is None or station >= FIRST_GROUP else station


def hit_of(kind: str, packet: Packet, station: int | None, detail: str = "", **more: Any) -> Hit:
    """Return a hit that is a packet."""
    found = Hit(kind, packet.number, packet.epoch_s, packet.ended_s, station, detail=detail, port=packet.interface)
    return found._replace(**more) if more else found


class Faults:
    """Those of a bus."""

    def __init__(self) -> None:
        """Begin without a command."""
        self._asked: int | None = None  # the station whose reaction is due
        self._is_disturbed = False  # something was damaged since the last command: perhaps another one
        self.known: set[int | None] = set()  # stations that have answered
        self.telegrams = 0  # good ones
        self.damaged = 0  # records that are none

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return the hits of a packet."""
        bad = 0
        for telegram in packet.telegrams:
            bad += not telegram.good
        is_other = packet.type == OTHER and self._asked is not None
        if bad or packet.type == OTHER:
            self.damaged += 1
            self._is_disturbed = True
        hits: list[Hit] = []
        if bad or is_other or packet.errors or packet.event == Event.CHARACTERS_LOST:
            hits += self._damage(packet, bad, is_other=is_other)
        for telegram in packet.telegrams:
            if telegram.good:
                self.telegrams += 1
                if telegram.is_doubtful:
                    hits += _limits(packet, telegram)
                if telegram.has_system_error:
                    hits.append(hit_of("system_error", packet, telegram.talker))
                if telegram.signs:
                    signs = [sign for sign in telegram.signs if sign != "again" or not self._is_disturbed]
                    hits += _signs(packet, telegram, signs)
                if telegram.is_reaction:
                    self._asked = None
                    self.known.add(telegram.talker)
                else:
                    self._asked, self._is_disturbed = telegram.listener, False
        if packet.faults and not hits:
            hits += _others(packet)
        return hits

    def _damage(self, packet: Packet, bad: int, *, is_other: bool) -> Iterator[Hit]:
        """Yield damage: of one cause, the first that is known. Its station is the one whose telegram was due; the
        address in a damaged telegram may be damaged, too.
        """
        station = self._asked
        if station is None and packet.telegrams:
            station = slave(packet.telegrams[0])
        station = station if station in self.known else None
        is_damaged = bad or packet.type == OTHER
        what = "in a telegram that is damaged" if is_damaged else "in a telegram that is not damaged"
        if packet.errors & ~LOST:
            yield hit_of("line_error", packet, station, what)
        elif packet.errors & LOST:
            yield hit_of("lost", packet, station, what)
        elif packet.event == Event.CHARACTERS_LOST:
            yield hit_of("lost", packet, None, packet.text)
        elif bad or is_other:
            for _ in range(bad or 1):
                what = "its checksum is wrong" if bad else "its rest is not a telegram"
                yield hit_of("damaged", packet, station, what)

    def command(self, packet: Packet) -> Iterable[Hit]:
        """Take a good command."""
        self.telegrams += 1
        self._asked, self._is_disturbed = packet.telegrams[0].listener, False
        return ()

    def reaction(self, packet: Packet) -> Iterable[Hit]:
        """Take a good reaction."""
        self.telegrams += 1
        self._asked = None
        self.known.add(packet.telegrams[0].talker)
        return ()

    def finish(self, port: str, begin_s: float, end_s: float) -> Iterator[Hit]:
        """Yield that nothing of it is SIS."""
        if not self.telegrams and self.damaged >= _FEW:
            detail = f"none of {self.damaged} records is a telegram: another protocol, rate or format?"
            yield Hit("foreign", 0, begin_s, end_s, None, "", detail, port=port)


def _limits(packet: Packet, telegram: Telegram) -> Iterator[Hit]:
    for kind, name, field in _LIMITS:
        judged: Judged | None = getattr(telegram, field)
        if not judged or judged.verdict not in DOUBTFUL or (kind == "interval" and packet.errors & LOST):
            continue
        limit = f", {name} {limit_text(judged.limit_s)}" if judged.limit_s is not None else ""
        position = f" before character {telegram.pause_position}" if kind == "interval" else ""
        perhaps = "" if judged.verdict == EXCEEDED else PERHAPS
        master = f" by master {telegram.talker}" if kind == "cycle" else ""
        yield hit_of(
            kind,
            packet,
            slave(telegram) if kind == "cycle" else telegram.talker,
            f"{perhaps}{ms(judged.time_s) if judged.time_s else 'not measured'}{position}{limit}{master}",
            worst=judged.time_s or None,
            severity=None if judged.verdict == EXCEEDED else Severity.NOTE,
            topic=perhaps,
        )


def _signs(packet: Packet, telegram: Telegram, signs: Iterable[str]) -> Iterator[Hit]:
    """Yield what an expert item of the dissector alone tells."""
    for kind in signs:
        station = telegram.talker if kind == "warning_bit" else slave(telegram)
        detail = f"master {telegram.talker} did not wait for TrS" if kind == "early" else ""
        yield hit_of(kind, packet, station, detail)


def _others(packet: Packet) -> Iterator[Hit]:
    """Yield faults that other fields tell: a good checksum with a wrong length, an error of the ASCII protocol."""
    found = [(slave(telegram), telegram.faults) for telegram in packet.telegrams] or [(None, packet.faults)]
    for station, faults in found:
        for kind in (_KINDS[fault.name] for fault in faults if fault.name in _KINDS):
            if kind != "error" or not packet.telegrams:  # those of SIS are refusals
                yield hit_of(kind, packet, station)


_Refused = tuple[Parameter, str, bool]  # without its port; its error; whether it was written


class Refusals:
    """Reactions with an error. What a station has never known is no fault, however often somebody asks for it."""

    def __init__(self, before: Refusals | None = None) -> None:
        """Begin with nothing known. What was refused in a good capture may be refused."""
        self._good: set[Parameter] = set()
        self._usual: set[_Refused] = before._refused if before else set()
        self._refused: set[_Refused] = set()

    def know(self, parameter: Parameter) -> None:
        """Learn that a station knows a parameter."""
        self._good.add(parameter)

    def add(self, packet: Packet) -> list[Hit]:
        """Return the refusals of a packet."""
        if len(packet.telegrams) == 1:
            return self._of(packet, packet.telegrams[0], packet.accesses)
        return [hit for telegram in packet.telegrams for hit in self._of(packet, telegram, telegram.accesses)]

    def _of(self, packet: Packet, telegram: Telegram, said: Iterable[Access]) -> list[Hit]:
        hits: list[Hit] = []
        for access in said:
            if access.error:
                hits.append(self._of_parameter(packet, access))
        is_refused = telegram.is_refusal and telegram.good
        return hits or [_of_service(packet, telegram)] if is_refused else []

    def _of_parameter(self, packet: Packet, access: Access) -> Hit:
        more = {"parameter": access.parameter.ident, "topic": f"{access.error} {access.is_write}"}
        what = f"{'write: ' if access.is_write else ''}{access.error}"
        key = access.parameter._replace(port=""), access.error, access.is_write
        if len(self._refused) < MOST:
            self._refused.add(key)
        if access.error.startswith(_BUSY):
            return hit_of("busy", packet, station_of(access.parameter), what, **more)
        is_new = access.is_write or access.parameter in self._good
        kind = "error" if is_new and key not in self._usual else "never"
        return hit_of(kind, packet, station_of(access.parameter), what, **more)


def _of_service(packet: Packet, telegram: Telegram) -> Hit:
    """Return the refusal of a service; of an element that a parameter lacks, it is no fault."""
    service = telegram.service or 0
    what = f"{service_name(service)}, status 0x{telegram.status or 0:02x}"
    is_life = service == 0 or (service >= 0x10 and service & 0x0F in _PARAMETERS)  # noqa: PLR2004 - services
    kind = "never" if is_life else "error"
    return hit_of(kind, packet, telegram.talker, what, topic=what)


class UnreadableLine:
    """A bus on which nearly nothing is a telegram."""

    def __init__(self) -> None:
        """Begin with a good bus."""
        self._bad = self._good = self._row = 0
        self._begin_s = self._last_s = 0.0
        self._first = 0

    @property
    def is_begun(self) -> bool:
        """Tell whether it is not yet known to be good again."""
        return self._bad > 0

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return the time that ends with a packet."""
        if packet.type != OTHER and not packet.telegrams:
            return ()  # nothing on the line, or another protocol
        if packet.telegrams and packet.telegrams[0].good:
            if not self._bad:
                return ()
            self._row += 1
            self._good += 1
            return self.finish(packet.interface) if self._row == _GOOD_RUN else ()
        if not self._bad:
            self._begin_s, self._first = packet.epoch_s, packet.number
        self._bad += 1
        self._row, self._last_s = 0, packet.ended_s
        return ()

    def finish(self, port: str) -> Iterable[Hit]:
        """Return the time that is over."""
        bad, good, lasted_s = self._bad, self._good, self._last_s - self._begin_s
        self._bad = self._good = self._row = 0
        if bad < _BAD_RUN or good > bad or lasted_s < _UNREADABLE_S:
            return ()
        place = "unreadable", self._first, self._begin_s, self._last_s
        return (Hit(*place, None, "", f"{bad} records are no telegrams", lasted_s, port=port),)
