# SPDX-License-Identifier: GPL-2.0-or-later
"""The telegrams of a bus that explain later ones.

The dissector learns from them while it reads: names, units, attributes and limits of parameters (chapter 8), types of
devices (service 0x00, chapter 3), and the settings of the bus (service 0x03, chapter 6). A file that begins in the
middle needs them. The rules are those of plugin/sis/exchange.c, sequence.c and bus.c; a test cuts captures into pieces
and compares. Nothing is guessed: if telegrams are damaged or missing, a fact may be missing, too.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from sistap.tap.sis.initialization import ACCEPT, INITIALIZATION, SIZES, TEST_RATE, certain
from sistap.tap.sis.telegram import (
    BROADCAST,
    CONTROL_NUMBER,
    CONTROL_REACTION,
    CONTROL_SUBADDRESSES,
    FIRST_GROUP,
    LEVEL_BROADCAST,
    STATIC_LENGTH,
    general,
    has_control,
    shown,
)

MOST_PARAMETERS, MOST_DEVICES, MOST_SETTINGS, MOST_OPEN, MOST_PIECES = 4000, 256, 1000, 1000, 256
NAME, ATTRIBUTE, UNIT, MINIMUM, MAXIMUM = range(2, 7)  # elements of a parameter, fig. 8-1

_IDENTIFICATION, _LIST, _TOKEN = 0x00, 0x04, 0x0F
_READ = 0x10
_EXPLAINING = (_READ, INITIALIZATION, _LIST, _IDENTIFICATION)
_IDENTITIES = (0x02, 0x03)  # subservices of 0x00: firmware, type key
_VALUE = b"\x3c"  # control byte: operating data, the last piece
_LAST = 0x04  # bit of the parameter control: no more pieces follow
_A_RECORD = 12  # characters that would take the room of the rest of a record in a file
_RECENT = 100  # telegrams: what has not gone on for so long is given up
_GOOD = 0x00
_MS = 1_000_000
_LONGEST = 1000  # bytes of a value: a longer one is left out
_BROKEN = bytes(_LONGEST + 1)  # in place of pieces, if one may be missing
_LETTERS = {0: "S", 1: "A", 2: "C"}  # of a type byte, fig. 8-3
_BIT_15 = 0x8000  # tells P from S

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")


class _Newest(OrderedDict[_Key, _Value], Generic[_Key, _Value]):
    """The entries that were put last, up to a number."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def put(self, key: _Key, value: _Value) -> None:
        """Put an entry at the end. Drop the oldest if there are too many."""
        self.pop(key, None)
        self[key] = value
        if len(self) > self._most:
            self.popitem(last=False)


class Said(NamedTuple):
    """A telegram, and the line on which it came."""

    line: int
    telegram: bytes


class Fact(NamedTuple):
    """What explains later telegrams, and those that told it."""

    order: int  # of all facts; of several from one telegram it is the same
    said: tuple[Said, ...]
    data: bytes


@dataclass(slots=True, eq=False)
class _Exchange:
    """A command, and what became of it."""

    said: Said
    command: bytes
    body_at: int
    sent_at: int
    is_answered: bool = False
    over_at: int = 0  # when it was answered or its master went on; 0: neither yet

    @property
    def needs_reaction(self) -> bool:
        """Tell whether it must be answered."""
        return self.path[-1] < FIRST_GROUP and self.command[5] != _TOKEN

    @property
    def path(self) -> bytes:
        """Return the stations from the receiver to the one addressed."""
        return self.command[7 : STATIC_LENGTH + (self.command[4] & CONTROL_SUBADDRESSES)]

    def fits(self, reaction: bytes) -> bool:
        """Tell whether a reaction with the same stations may belong to it."""
        command, at = self.command, self.body_at
        layout = CONTROL_SUBADDRESSES | CONTROL_NUMBER
        if command[5] != reaction[5] or (command[4] ^ reaction[4]) & layout or command[8:at] != reaction[8:at]:
            return False
        asked, said = command[at : at + 2], reaction[at + 1 : at + 3]
        if len(asked) < 2 or len(said) < 2:
            return True
        if has_control(command[5]):
            return not (asked[0] ^ said[0]) & ~_LAST and asked[1] == said[1]
        return command[5] != INITIALIZATION or asked[1] == said[1] or said[1] not in SIZES


class _Open:
    """What is not complete yet. That of telegrams from before a file is apart: none of them goes on in it."""

    def __init__(self) -> None:
        self.exchanges: _Newest[bytes, _Exchange] = _Newest(MOST_OPEN)  # the last of each pair of stations
        self.of_master: dict[int, _Exchange] = {}  # the last of each
        self.pieces: _Newest[tuple[Place, int], Fact] = _Newest(MOST_PIECES)  # of elements
        self.transfers: _Newest[tuple[bytes, bytes], int] = _Newest(MOST_PIECES)  # last pieces, by stations and device


class Place(NamedTuple):
    """A parameter of a device behind a station."""

    path: bytes  # of stations
    device: int
    ident: bytes  # type byte and number word

    @property
    def is_defined(self) -> bool:
        """Tell whether the documents know such an ident (fig. 8-3)."""
        return self.ident[0] == 0 or (self.ident[0] in _LETTERS and not self.ident[2] & 0x80)

    @property
    def parameter(self) -> str:
        """Return its name, as S-0-0036. It must be defined."""
        number = int.from_bytes(self.ident[1:], "little")
        letter = "P" if number & _BIT_15 else _LETTERS[self.ident[0]]
        return f"{letter}-{number >> 12 & 7}-{number & 0xFFF:04}"


class Told:
    """The facts of one bus."""

    def __init__(self) -> None:
        self._parameters: _Newest[Place, dict[int, Fact]] = _Newest(MOST_PARAMETERS)  # by element
        self._devices: _Newest[Place, dict[int, Fact]] = _Newest(MOST_DEVICES)  # by subservice
        self._set: _Newest[bytes, Fact] = _Newest(MOST_SETTINGS)  # by address and body, not accepted yet
        self._agreed: _Newest[bytes, Fact] = _Newest(MOST_SETTINGS)
        self._now_ns = 0  # the end of the last telegram
        self._tested_until_ns = 0  # the end of the last timed test of a rate
        self._here, self._before = _Open(), _Open()
        self._open = self._here  # of the telegram that is taken
        self._number = 0  # of what came
        self._damaged_at = 0

    def disturb(self) -> None:
        """Note that a telegram may have been lost."""
        self._number += 1
        self._damaged_at = self._number
        for key in self._here.pieces:
            self._here.pieces[key] = Fact(self._number, (), _BROKEN)

    def take(self, telegram: bytes, end_ns: int, line: int = 0, *, is_before: bool = False) -> bytes:
        """Take a good telegram, whose last character came at `end_ns`. Return the command that it answers, if any."""
        self._now_ns = end_ns
        self._open = self._before if is_before else self._here
        self._number += 1
        control = telegram[4]
        body_at = STATIC_LENGTH + (control & CONTROL_SUBADDRESSES) + bool(control & CONTROL_NUMBER)
        stations = telegram[6 : STATIC_LENGTH + (control & CONTROL_SUBADDRESSES)]
        if control & CONTROL_REACTION:
            return self._take_reaction(Said(line, telegram), body_at, stations)
        self._take_command(Said(line, telegram), body_at, stations)
        return b""

    def known(self, place: Place) -> Mapping[int, bytes]:
        """Return what was told of a parameter, by element."""
        return {element: fact.data for element, fact in self._parameters.get(place, {}).items()}

    @property
    def is_under_way(self) -> bool:
        """Tell whether a command waits for its reaction, more pieces of long data follow, or a rate is tested."""
        since = self._number - _RECENT
        waiting = (one for one in self._here.of_master.values() if not one.over_at and one.sent_at > since)
        is_open = any(one.needs_reaction for one in waiting) or any(at > since for at in self._here.transfers.values())
        return is_open or self._now_ns < self._tested_until_ns

    def telegrams(self, most: int) -> list[Said]:
        """Return those that told the facts: of settings, types, the newest parameters; up to so many characters."""
        kept: dict[int, tuple[Said, ...]] = {}
        for facts in self._by_worth():
            more = {fact.order: fact.said for fact in facts if fact.order not in kept}
            most -= _size(more.values())
            if most < 0:
                break
            kept.update(more)
        return [said for order in sorted(kept) for said in kept[order]]

    def _by_worth(self) -> Iterator[Iterable[Fact]]:
        """Yield facts that are told together, the newest of each kind first."""
        for settings in (self._agreed, self._set):
            yield from ([fact] for fact in reversed(settings.values()))
        for known in (self._devices, self._parameters):
            yield from (facts.values() for facts in reversed(known.values()))

    def _take_command(self, said: Said, body_at: int, stations: bytes) -> None:
        telegram = said.telegram
        exchange = _Exchange(said, telegram, body_at, self._number)
        before = self._open.of_master.get(telegram[6])
        if before and not before.over_at:
            before.over_at = self._number
        self._open.of_master[telegram[6]] = exchange
        self._open.exchanges.put(stations, exchange)
        if has_control(telegram[5]) and _is_write(telegram[5]):
            self._follow_transfer(telegram[body_at : body_at + 2], stations)
        if stations[1] in (LEVEL_BROADCAST, BROADCAST) and len(stations) == 2:
            for service, body in _services(telegram[5], telegram[body_at:]):
                if service == INITIALIZATION:
                    self._set_up(BROADCAST, body, (said,))

    def _take_reaction(self, said: Said, body_at: int, stations: bytes) -> bytes:
        telegram = said.telegram
        if has_control(telegram[5]) and not _is_write(telegram[5]) and telegram[body_at : body_at + 1] == b"\0":
            self._follow_transfer(telegram[body_at + 1 : body_at + 3], stations)
        exchange = self._asked(telegram, stations)
        if not exchange:
            return b""
        is_again = exchange.is_answered
        if not is_again:
            exchange.is_answered, exchange.over_at = True, self._number
        if general(telegram[5]) in _EXPLAINING and (self._open.pieces or not _is_value(telegram, body_at)):
            self._learn_all(exchange, said, body_at, is_again=is_again)
        return exchange.command

    def _learn_all(self, exchange: _Exchange, reaction: Said, body_at: int, *, is_again: bool) -> None:
        telegram, both = reaction.telegram, (exchange.said, reaction)
        asked = _services(telegram[5], exchange.command[body_at:])
        answers = _services(telegram[5], telegram[body_at:] if telegram[5] != _LIST else telegram[body_at + 1 :])
        for (service, command), (answering, answer) in _pairs(asked, answers):
            if service != answering or answer[:1] != bytes([_GOOD]):
                continue
            if general(service) == _READ:
                fact = Fact(self._number, both, answer[1:])
                self._learn(exchange.path, command, fact, is_again=is_again, is_nested=telegram[5] == _LIST)
            elif service == INITIALIZATION and len(exchange.path) == 1 and not is_again:
                self._set_up(exchange.path[0], command, both)
            elif service == _IDENTIFICATION:
                self._identify(exchange.path, command, Fact(self._number, both, answer[1:]))

    def _identify(self, path: bytes, command: bytes, fact: Fact) -> None:
        """Learn the type of a device; command and reaction begin with device and subservice."""
        is_told = 2 < len(fact.data) <= _LONGEST and command[1:2] == fact.data[1:2]
        if is_told and command[1] in _IDENTITIES:
            self._keep(self._devices, Place(path, command[0], b""), command[1], fact)

    def _set_up(self, address: int, body: bytes, said: tuple[Said, ...]) -> None:
        """Take what a station has confirmed, or what all were told. A timed test of a rate ends by itself."""
        settings = certain(body)
        subservices = [setting.subservice for setting in settings]
        if TEST_RATE in subservices:
            test_ms = int.from_bytes(settings[subservices.index(TEST_RATE)].data[:2], "little")
            self._tested_until_ns = self._now_ns + test_ms * _MS
            return
        self._set.put(bytes([address]) + body, Fact(self._number, said, body))
        if ACCEPT in subservices:
            for key in list(self._set):
                if address == BROADCAST or key[0] in (address, BROADCAST):
                    self._agreed.put(key, self._set.pop(key))

    def _keep(self, facts: _Newest[Place, dict[int, Fact]], place: Place, element: int, fact: Fact) -> None:
        """Keep a fact. If it was known, it keeps its place: a limit belongs to the attribute before it."""
        known = facts.get(place, {})
        if element not in known or known[element].data != fact.data:
            known[element] = fact
        facts.put(place, known)

    def _follow_transfer(self, access: bytes, stations: bytes) -> None:
        """Note whether more pieces follow. `access`: control byte and device, of a written piece or of a read one."""
        key = stations, access[1:]
        if access and not access[0] & _LAST:
            self._open.transfers.put(key, self._number)
        elif self._open.transfers:
            self._open.transfers.pop(key, None)

    def _asked(self, reaction: bytes, stations: bytes) -> _Exchange | None:
        """Return the exchange of a reaction, whose addresses are those of the command, or swapped."""
        for addresses in (stations, stations[1::-1] + stations[2:]):
            exchange = self._open.exchanges.get(addresses)
            if not exchange or not exchange.fits(reaction):
                continue
            # If a damaged telegram came since it was over, that one may have been another command. What needs no
            # reaction, such as a token, has one only before the next command.
            is_newest = exchange is next(reversed(self._open.exchanges.values()))
            if (exchange.needs_reaction or is_newest) and not 0 < exchange.over_at < self._damaged_at:
                return exchange
        return None

    def _learn(self, path: bytes, command: bytes, fact: Fact, *, is_again: bool, is_nested: bool) -> None:
        """Learn from an element that was read: control byte, device and data, after the status."""
        place = Place(path, command[1], command[2:5]) if len(command) >= 5 else None
        if not place or len(fact.data) < 2 or not place.is_defined:
            return
        control, piece = fact.data[0], fact._replace(data=fact.data[2:])
        element, is_last = control >> 3 & 7, bool(control & _LAST)
        if is_nested:
            whole = piece if is_last else None
        elif self._open.pieces or not is_last:
            whole = None if is_again else self._join(place, element, piece, is_last=is_last)
        else:
            whole = piece
        if whole and _explains(element, whole.data):
            self._keep(self._parameters, place, element, whole)

    def _join(self, place: Place, element: int, piece: Fact, *, is_last: bool) -> Fact | None:
        """Join the pieces of an element (chapter 8.2). None if it is not complete."""
        for other in [other for other in self._open.pieces if other[0][:2] == place[:2] and other != (place, element)]:
            del self._open.pieces[other]  # a device has one transfer at a time
        if (before := self._open.pieces.pop((place, element), None)) and len(before.data) <= _LONGEST:
            piece = piece._replace(said=before.said + piece.said, data=before.data + piece.data)
        elif before:
            piece = before
        if is_last:
            return piece
        self._open.pieces.put((place, element), piece)
        return None


def _is_value(reaction: bytes, body_at: int) -> bool:
    """Tell whether nothing but operating data was read, in one piece. This is most of the traffic."""
    return general(reaction[5]) == _READ and reaction[body_at + 1 : body_at + 2] == _VALUE


def _is_write(service: int) -> bool:
    return service & 0x0F >= 0x0E


def _services(service: int, body: bytes) -> list[tuple[int, bytes]]:
    """Return a service with its body, or those of a list of services: length, service, body (chapter 7)."""
    if service != _LIST:
        return [(service, body)]
    found = []
    at = 0
    while at < len(body):
        end = at + 1 + body[at]
        if end > at + 1 and end <= len(body):
            found.append((body[at + 1], body[at + 2 : end]))
        at = end
    return found


def _pairs(
    asked: list[tuple[int, bytes]], said: list[tuple[int, bytes]]
) -> Iterator[tuple[tuple[int, bytes], tuple[int, bytes]]]:
    """Yield each command with its reaction. If a list is not answered completely, nobody knows which belong."""
    return iter(zip(asked, said, strict=True)) if len(asked) == len(said) else iter(())


def text(data: bytes) -> str:
    """Return a name or a unit; as a list, two length words precede it."""
    has_lengths = len(data) >= 4 and int.from_bytes(data[:2], "little") == len(data) - 4
    is_list = has_lengths and data[0:2][::-1] <= data[2:4][::-1]
    return shown(data[4 * is_list :].decode("latin-1"))


def _explains(element: int, data: bytes) -> bool:
    """Tell whether an element of a parameter says something."""
    if element == ATTRIBUTE:
        return len(data) == 4
    is_short = 0 < len(data) <= _LONGEST
    return is_short and (element in (UNIT, MINIMUM, MAXIMUM) or (element == NAME and text(data) != ""))


def _size(told: Iterable[tuple[Said, ...]]) -> int:
    return sum(len(one.telegram) + _A_RECORD for said in told for one in said)
