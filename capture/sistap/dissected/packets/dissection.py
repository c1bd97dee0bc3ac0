# SPDX-License-Identifier: GPL-2.0-or-later
"""What the dissector says about each packet, streamed from tshark: the only source of figures for the products."""

from __future__ import annotations

import itertools
import math
import struct
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from math import isnan
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

from sistap.dissected.accesses.access import FIELD as ACCESSES
from sistap.dissected.accesses.access import Access, accesses
from sistap.dissected.captures.portions import Portion
from sistap.dissected.packets.apart import PACKED, apart, beside
from sistap.dissected.packets.kept import Kept, Span
from sistap.dissected.wireshark import rows
from sistap.dissected.wireshark.rows import BEFORE, EVENT, JOINT, NECESSARY, NO_DISSECTOR, first, printed, safe, told
from sistap.dissected.wireshark.trouble import damage
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import INTERVAL_MAX, KEPT, Event
from sistap.tap.sis.faults import FAULTS, SIGNS, Fault

# Those that the installed dissector lacks are left out and named in the report.
_SHOWN = (
    "frame.number",
    "frame.time_epoch",
    "frame.time_relative",
    "frame.interface_name",
    "sertap.type",
    "sertap.line",
    "sertap.baud",
    "sertap.format",
    "sertap.framing",
    "sertap.uncertainty",
    "sertap.event",
    "sertap.text",
    "sertap.interval",
    "sertap.interval.unknown",
    "sertap.interval.max",
    "sertap.same_read",
    "sertap.error.character",
    "sertap.error.break",
    "sertap.error.lost",
    "sertap.error.unlocated",
    "sis.start",
    "sis.checksum.status",
    "sis.control.reaction",
    "sis.control.error",
    "sis.control.status",
    "sis.service",
    "sis.talker",
    "sis.listener",
    "sis.status",
    "sis.command_in",
    "sis.repeat_of",
    "sis.command.unanswered",
    "sis.silence_before",
    "sis.reaction_time",
    "sis.trs.limit",
    "sis.trs.verdict",
    "sis.tza.interval_max",
    "sis.tza.position",
    "sis.tza.limit",
    "sis.tza.verdict",
    "sis.tmas.cycle",
    "sis.tmas.limit",
    "sis.tmas.verdict",
    "sis.bus.load",
    "sis.phase",
    "sis.parameter",
    "sis.firmware",
    "sis.type_key",
    *SIGNS,
    PACKED,
    ACCESSES,
)
_TESTED = rows.tested(test for fault in FAULTS for test in fault.tests)
FIELDS = tuple(dict.fromkeys((*_SHOWN, *_TESTED)))
# Those that differ from packet to packet, in the order of FIELDS. All others together have few different texts in a
# capture.
_OWN = (
    "frame.number",
    "frame.time_epoch",
    "frame.time_relative",
    "sertap.uncertainty",
    "sertap.interval",
    "sertap.interval.max",
    "sis.command_in",
    "sis.silence_before",
    "sis.reaction_time",
    "sis.tza.interval_max",
    "sis.tza.position",
    "sis.tmas.cycle",
    "sis.bus.load",
    ACCESSES,
)
_ACCESSES = _OWN.index(ACCESSES)
# What the plugin's tap writes for a packet, and for each of its telegrams; a time that is not known is no number.
_ROW = struct.Struct("=8xqddIIHHH2x")
_TIMES = struct.Struct("=dddddII")
_OwnTimes = tuple[float, float, float, float, float, int | None, int | None]
_S = 1_000_000_000  # in ns
_REMEMBERED = 2048  # of the texts of all others; each takes some 5 kB
CHARACTERS = "sertap.character"
_BEGINNING = {Event.CAPTURE_STARTED, Event.LIMITS_TOLD}
_GOOD = {"1", "Good"}
_TRUE = {"1", "True"}
LOST = int(Flag.LOST_BEFORE)  # in the errors of a packet
_LONGEST_S = INTERVAL_MAX / 1e9  # a record has no longer interval
_LOAD_S = 1.0  # over which the dissector measures the load of the bus; at first over less, 100 % to begin with
_SAID = {"error_reaction", "system_error"}  # faults that a telegram tells
_CONTROL_ERROR = 6  # status bits of the edition ECODRIVE03: error
_LINE_ERRORS = (
    ("sertap.error.character", int(Flag.CHARACTER_ERROR)),
    ("sertap.error.break", int(Flag.BREAK)),
    ("sertap.error.unlocated", int(Flag.UNLOCATED_ERROR)),
    ("sertap.error.lost", LOST),
)


class Judged(NamedTuple):
    """A time with its limit and verdict, in s; None without a value."""

    time_s: float  # 0: not measured, because all came in one read or the clock was set back
    limit_s: float | None
    verdict: int | None  # one of the three below

    @property
    def measured_s(self) -> list[float]:
        """Return the time if it was measured."""
        return [self.time_s] if self.time_s else []


OK, EXCEEDED, UNRESOLVED = 0, 1, 2
DOUBTFUL = EXCEEDED, UNRESOLVED


@dataclass(slots=True)
class Telegram:
    """A SIS telegram; None and False without a value."""

    good: bool
    service: int | None
    talker: int | None
    listener: int | None
    is_reaction: bool
    status: int | None
    is_refusal: bool  # a reaction with an error: in the status byte, or in the telegram control (ECODRIVE03)
    has_system_error: bool  # the sender says that it has an error (fig. 2-9)
    is_repeat: bool
    unanswered: bool
    phase: str  # as it is printed
    is_doubtful: bool  # one of its times is beyond its limit, or may be
    command_in: int | None  # packet number
    load_percent: float | None
    silence: Judged | None  # of the line, before it; there is no limit
    reaction: Judged | None  # TrS
    pause: Judged | None  # TzA; the longest inside the telegram
    cycle: Judged | None  # Tmas
    pause_position: int | None  # of the character after it, from 1
    columns: Mapping[str, str] = field(default_factory=dict, repr=False)  # as tshark printed them
    faults: Sequence[Fault] = ()  # its own; where it is alone in its packet, those of the packet
    accesses: Sequence[Access] = ()  # its own
    signs: Sequence[str] = ()  # kinds of episodes that an expert item alone tells


@dataclass(slots=True)
class Packet:
    """A packet: a record of the serial tap, or any other carrier of telegrams. Times in s."""

    interface: str
    type: int | None  # FRAME, OTHER, EVENT; None: not a record of the tap
    line: int | None
    baud: int | None
    format: str
    framing: int | None  # of a frame; 0: SIS
    event: int | None
    text: str
    same_read: int  # characters from the same read as the one before
    errors: int  # Flags, ORed
    faults: Sequence[Fault]  # of each telegram, and of the record
    number: int
    epoch_s: float
    time_s: float  # since the first packet
    uncertainty_s: float | None
    intervals_s: list[float]  # from the second character on
    since_s: float | None = None  # from the character before it on its line to its first; None: unknown
    telegrams: list[Telegram] = field(default_factory=list)
    accesses: list[Access] = field(default_factory=list)  # to parameters
    columns: Mapping[str, str] = field(default_factory=dict, repr=False)  # as tshark printed them
    alike: object = field(default_factory=object, repr=False, compare=False)  # the same: what is not its own is equal
    epoch_ns: int = 0  # as exact as the capture has it
    characters: bytes = b""  # of a record; where `-T fields` prints them, only if they were asked for
    length_s: float = field(init=False)
    is_before: bool = False  # the time from which on the capture is told
    is_again: bool = False  # an event at the beginning of a file that continues another, which began with it, too

    def __post_init__(self) -> None:
        """Add up its intervals once."""
        self.length_s = sum(self.intervals_s)

    @property
    def is_kept_apart(self) -> bool:
        """Tell whether a file of the recorder begins here: what came just before it is not in the capture."""
        return self._is_start and KEPT in self.text

    @property
    def is_seam(self) -> bool:
        """Tell whether a capture begins here, or a file kept apart: what came just before it is in none."""
        return self._is_start and (not self.is_again or self.is_kept_apart)

    @property
    def goes_on(self) -> bool:
        """Tell whether a further file of a ring begins here: the capture began in another one."""
        return self._is_start and self.is_again

    @property
    def _is_start(self) -> bool:
        return self.type == EVENT and self.event == Event.CAPTURE_STARTED

    @property
    def is_unheard(self) -> bool:
        """Tell whether nobody heard what came just before it: it is a seam, or the adapter was lost."""
        return self.is_seam or (self.type == EVENT and self.event == Event.ADAPTER_LOST)

    @property
    def is_of_one_read(self) -> bool:
        """Tell whether it came as a whole, as all of a log does: the length of none of its intervals is known."""
        return 0 < len(self.intervals_s) <= self.same_read

    @property
    def end_s(self) -> float:
        """Return the time of its last character."""
        return self.time_s + self.length_s

    @property
    def ended_s(self) -> float:
        """Return the time of its last character, since 1970."""
        return self.epoch_s + self.length_s


@dataclass
class _CaptureInTurn:
    """A capture among those that are read as one."""

    portion: Portion
    before: int  # packets of those before it
    later_s: float = 0.0  # its seconds begin so much later than those of all; below 0: earlier
    kept: Kept = field(default_factory=Kept)

    def place(self, packet: Packet) -> None:
        """Count number and seconds of a packet as those of all captures. Drop a load that is not of a whole second."""
        if packet.time_s < _LOAD_S:
            for telegram in packet.telegrams:
                telegram.load_percent = None
        packet.time_s += self.later_s
        if self.before:
            packet.number += self.before
            for telegram in packet.telegrams:
                telegram.command_in = telegram.command_in and telegram.command_in + self.before


class Dissection:
    """Captures as the installed dissector sees them, in two passes, so that later packets can explain earlier ones.

    Several are read as one, each by a tshark of its own. Use it in a `with`.
    """

    def __init__(  # noqa: PLR0913 - each comes from another part
        self,
        tshark: Tshark,
        captures: Iterable[Portion],
        more: Sequence[str] = (),
        *,
        preferences: Mapping[str, object] = MappingProxyType({}),
        keeps: bool = True,
        since_s: float = -math.inf,
    ) -> None:
        """Read these fields, too, with preferences of Wireshark.

        Nothing is read yet; what is not kept cannot be read again(), nor what came before `since_s`. From there on the
        seconds are counted.
        """
        self._preferences = [word for name, value in preferences.items() for word in ("-o", f"{name}:{value}")]
        self._tshark = tshark
        self._captures = captures
        self._more = more
        self._fields = tuple(dict.fromkeys((*FIELDS, *more)))
        self._keeps = keeps
        self._since_s = since_s
        self._zero_s: float | None = None  # where the seconds begin, since 1970; None: not yet reached
        self._known: Collection[str] = self._fields
        self._rows: _Rows = _Told(())
        self._parts: list[_CaptureInTurn] = []
        self.warning = ""  # what tshark said at the end of captures that are cut off

    def __enter__(self) -> Dissection:
        return self

    def __exit__(self, *error: object) -> None:
        for part in self._parts:
            part.kept.__exit__(*error)

    @property
    def missing(self) -> list[str]:
        """Return the fields that the installed dissector lacks; valid after the first packets."""
        return [name for name in self._fields if name not in self._known]

    def packets(self) -> Iterator[Packet]:
        """Yield all packets, once. May raise Refusal."""
        return _of_traffic(self._packets())

    def place(self, packet: Packet) -> tuple[Path, int]:
        """Return the capture of a packet, and its number there."""
        after = bisect_left(self._parts, packet.number, key=lambda part: part.before + part.portion.told)
        part = self._parts[after - 1]
        return part.portion.place(packet.number - part.before)

    def again(self, spans: Collection[Span]) -> Iterator[Packet]:
        """Yield again the packets that begin in these spans."""
        for part in self._parts:
            for row in part.kept.rows(spans):
                packet = self._rows.packet(row)
                part.place(packet)
                if any(span.start_s <= packet.time_s <= span.end_s for span in spans):
                    yield packet

    def _packets(self) -> Iterator[Packet]:
        number = 0
        for portion in self._captures:
            self._parts.append(_CaptureInTurn(portion, number - portion.told))
            for packet in self._of_part(portion, self._parts[-1]):
                number = packet.number
                yield packet

    def _of_part(self, portion: Portion, part: _CaptureInTurn) -> Iterator[Packet]:
        came = False
        try:
            for row in self._read(portion.path):
                packet = self._rows.packet(row)
                if not portion.owns(packet.number):
                    continue
                if self._zero_s is None and packet.epoch_s >= self._since_s:
                    self._zero_s, part.later_s = packet.epoch_s, -packet.time_s
                elif self._zero_s is not None and not came:
                    part.later_s = packet.epoch_s - packet.time_s - self._zero_s
                came = True
                part.place(packet)
                packet.is_before = self._zero_s is None
                if self._keeps and not packet.is_before:
                    part.kept.put(packet.time_s, row)
                yield packet
        except TsharkError as error:
            self.warning = "; ".join(filter(None, [self.warning, damage(portion.path, error, came)]))

    def _read(self, capture: Path) -> Iterator[Any]:
        """Return the rows of all packets of a capture, and prepare for them."""
        arguments = ["-r", str(capture), "-2", *self._preferences]
        more = [name for name in self._more if name != CHARACTERS]  # which a row of the tap has anyway
        if found := told(self._tshark, arguments, [*more, NECESSARY, PACKED] if more else []):
            self._prepare(_Told, found[0], [*FIELDS, CHARACTERS, *found[0]])
            return found[1]
        own = {*_OWN, *self._more}
        known, lines = printed(self._tshark, arguments, sorted(self._fields, key=lambda name: name not in own))
        if NECESSARY not in known:
            raise TsharkError(NO_DISSECTOR)
        self._prepare(partial(_Printed, own=own), known, known)
        return lines

    def _prepare(self, reader: Callable[[Sequence[str]], _Rows], columns: Sequence[str], known: Sequence[str]) -> None:
        if known != self._known:  # else it knows rows already
            self._known, self._rows = known, reader(columns)


def _of_traffic(packets: Iterable[Packet]) -> Iterator[Packet]:
    """Leave out what a file begins with because it continues another: what was told before, and known descriptions."""
    begun: set[tuple[str, int | None, str]] = set()
    beginning: list[Packet] = []
    for packet in packets:
        if packet.event in _BEGINNING:
            beginning.append(packet)
            continue
        is_again = packet.type == BEFORE or packet.event == Event.TOLD_BEFORE
        if beginning:
            yield from _described(beginning, begun, is_again=is_again)
            beginning = []
        if not is_again:
            yield packet
    yield from _described(beginning, begun, is_again=False)


def _described(beginning: list[Packet], begun: set[tuple[str, int | None, str]], *, is_again: bool) -> Iterator[Packet]:
    for packet in beginning:
        description = packet.interface, packet.event, packet.text
        packet.is_again = is_again
        if not is_again or description not in begun:
            yield packet
        begun.add(description)


class _Columns(Mapping[str, str]):
    """The columns of a row. Most are never looked at."""

    __slots__ = ("_others", "_places", "_texts")

    def __init__(self, places: Mapping[str, int], texts: Sequence[str], others: Mapping[str, str]) -> None:
        """Take the texts of its own columns, with their places, and all others."""
        self._places, self._texts, self._others = places, texts, others

    def __getitem__(self, name: str) -> str:
        place = self._places.get(name)
        return self._others[name] if place is None else self._texts[place]

    def get(self, name: str, default: Any = None) -> Any:  # several times as quick as that of Mapping
        place = self._places.get(name)
        return self._others.get(name, default) if place is None else self._texts[place]

    def __iter__(self) -> Iterator[str]:
        return itertools.chain(self._places, self._others)

    def __len__(self) -> int:
        return len(self._places) + len(self._others)


class _AlikeTelegram(NamedTuple):
    """What a row says of a telegram besides what is its own."""

    make: Callable[..., Telegram]  # of what is its own
    faults: Sequence[Fault]
    trs: tuple[float | None, int | None]  # limit and verdict
    tza: tuple[float | None, int | None]
    tmas: tuple[float | None, int | None]

    @classmethod
    def of(cls, columns: Mapping[str, str]) -> _AlikeTelegram:
        """Work it out."""
        get = columns.get
        status = _integer(get("sis.status"))
        limits = [
            (_number(get(f"sis.{name}.limit")), _integer(get(f"sis.{name}.verdict"))) for name in ("trs", "tza", "tmas")
        ]
        make = partial(
            Telegram,
            get("sis.checksum.status") in _GOOD,
            _integer(get("sis.service")),
            _integer(get("sis.talker")),
            _integer(get("sis.listener")),
            get("sis.control.reaction") in _TRUE,
            status,
            bool(status) or _integer(get("sis.control.status")) == _CONTROL_ERROR,
            get("sis.control.error") in _TRUE,
            bool(get("sis.repeat_of")),
            bool(get("sis.command.unanswered")),
            first(get("sis.phase", "")),
            any(verdict in DOUBTFUL for _, verdict in limits),
            signs=tuple(dict.fromkeys(kind for field, kind in SIGNS.items() if get(field))),
        )
        return cls(make, _faults(columns), *limits)


@dataclass(frozen=True, slots=True, eq=False)
class _Alike:
    """What a row says besides what is its own, worked out once for all rows that say the same."""

    columns: Mapping[str, str]
    make: Callable[..., Packet]  # of what is its own
    parts: Sequence[Mapping[str, str]]  # of each telegram
    telegrams: Sequence[_AlikeTelegram]
    unknown: int  # intervals

    @classmethod
    def of(cls, columns: Mapping[str, str], parts: Sequence[Mapping[str, str]]) -> _Alike:
        """Work it out, with the columns of each telegram."""
        faults = _faults(columns)
        if len(parts) > 1:
            counts = Counter(fault for part in (beside(columns), *parts) for fault in _faults(part))
            counts |= Counter(faults)  # what cannot be dealt out counts once
            faults = tuple(fault for fault in FAULTS for _ in range(counts[fault]))
        unknown = _how_often(columns.get("sertap.interval.unknown"))
        return cls(columns, _making(columns, faults), parts, [_AlikeTelegram.of(part) for part in parts], unknown)


class _Rows(Protocol):
    """Makes packets of rows."""

    def packet(self, row: Any) -> Packet:
        """Return the packet of a row."""


class _Told:
    """Makes packets of the rows of the plugin's tap (plugin/docs/rows.md)."""

    def __init__(self, more: Sequence[str]) -> None:
        """Take rows that have these fields besides."""
        self._places = {name: place for place, name in enumerate(more)}
        self._alike = lru_cache(_REMEMBERED)(_alike_as_told)

    def packet(self, row: tuple[str, bytes]) -> Packet:
        """Return the packet of a row."""
        alike, own = self._alike(row[0]), row[1]
        seconds, time_s, uncertainty_s, nanoseconds, number, telegrams, intervals, count = _ROW.unpack_from(own)
        begin = _ROW.size + telegrams * _TIMES.size
        characters = begin + 8 * intervals
        end = characters + count
        said: list[list[Access]] = [[]] * telegrams
        columns, parts = alike.columns, alike.parts
        if len(own) > end:
            texts = safe(own[end:].decode(errors="replace")).split("\t")
            port = columns.get("frame.interface_name", "")
            said = [accesses(port, text.rstrip(JOINT)) for text in texts[len(self._places) :]]
            if self._places:
                columns, parts = self._with_more(texts, alike)
        places = range(_ROW.size, begin, _TIMES.size)
        return _packet(
            (
                number,
                seconds * _S + nanoseconds,
                time_s,
                None if isnan(uncertainty_s) else uncertainty_s,
                list(_doubles(intervals).unpack_from(own, begin)),
                own[characters:end],
            ),
            [
                _telegram(_TIMES.unpack_from(own, place), part, one, known)
                for place, part, one, known in zip(places, parts, said, alike.telegrams, strict=False)
            ],
            said,
            columns,
            alike,
        )

    def _with_more(self, texts: Sequence[str], alike: _Alike) -> tuple[Mapping[str, str], Sequence[Mapping[str, str]]]:
        """Return the columns of a packet and of its telegrams, with the other fields that were asked for."""
        columns = _Columns(self._places, texts, alike.columns)
        if len(alike.parts) == 1:
            return columns, [columns]
        more = apart(dict(zip(self._places, texts, strict=False)), len(alike.parts))
        return columns, [{**part, **said} for part, said in zip(alike.parts, more, strict=True)]


class _Printed:
    """Makes packets of the rows that `-T fields` prints. Each row ends with the columns that are not its own."""

    def __init__(self, names: Sequence[str], own: Collection[str]) -> None:
        """Take rows of these columns, of which these are own."""
        count = sum(name in own for name in names)
        self._others = list(names[count:])
        self._count = count
        self._unknown = [place for place, name in enumerate(_OWN) if name not in names]
        known = _OWN + tuple(name for name in names[:count] if name not in _OWN)
        self._places = {name: place for place, name in enumerate(known)}
        self._alike = lru_cache(_REMEMBERED)(self._work_out)

    def packet(self, row: str) -> Packet:
        """Return the packet of a row."""
        texts = row.split("\t", self._count)
        others = texts.pop()
        for place in self._unknown:
            texts.insert(place, "")
        alike = self._alike(others)
        return _printed_packet(_Columns(self._places, texts, alike.columns), texts, alike)

    def _work_out(self, text: str) -> _Alike:
        columns = dict(zip(self._others, text.split("\t"), strict=False))
        return _Alike.of(columns, _parts(columns))


def packet_of(columns: Mapping[str, str]) -> Packet:
    """Return the packet of a row that `-T fields` has printed."""
    return _printed_packet(columns, _own(columns), _Alike.of(columns, _parts(columns)))


@lru_cache(1024)
def _doubles(count: int) -> struct.Struct:
    return struct.Struct(f"={count}d")


def _alike_as_told(text: str) -> _Alike:
    """Return what a text of the tap says: a line of the packet, and one of each telegram."""
    lines = [safe(line) for line in text.split("\n")]
    columns = _named("".join(lines))
    return _Alike.of(columns, [columns] if len(lines) == 2 else [_named(line) for line in lines[1:]])  # noqa: PLR2004


def _named(line: str) -> dict[str, str]:
    columns: dict[str, str] = {}
    for name, _, value in (one.partition("=") for one in line.split("\t")[:-1]):
        columns[name] = columns[name] + JOINT + value if name in columns else value
    return columns


def _own(columns: Mapping[str, str]) -> list[str]:
    return [columns.get(name, "") for name in _OWN]


def _printed_packet(columns: Mapping[str, str], own: list[str], alike: _Alike) -> Packet:
    """Return the packet of a row: its own texts, and what is known of such rows."""
    number, epoch, relative, uncertainty, text = own[:5]
    seconds, _, decimals = epoch.partition(".")
    intervals_s = list(map(float, text.split(JOINT))) if text else []
    port = columns.get("frame.interface_name", "")
    each = [(own, columns)]
    if len(alike.telegrams) != 1:
        each = [(_own(part), part) for part in _parts(columns)]
    telegrams = [
        _telegram(_times(own), part, accesses(port, own[_ACCESSES]), known)
        for (own, part), known in zip(each, alike.telegrams, strict=True)
    ]
    epoch_ns, time_s, uncertainty_s = (
        int(f"{seconds}{decimals:0<9.9}"),
        float(relative or 0),
        _known_number(uncertainty),
    )
    characters = bytes.fromhex(columns.get(CHARACTERS, "").replace(JOINT, "").replace("0x", ""))
    own_of = int(number), epoch_ns, time_s, uncertainty_s, intervals_s, characters
    return _packet(own_of, telegrams, [accesses(port, own[_ACCESSES])], columns, alike)


def _times(own: list[str]) -> _OwnTimes:
    longest, command_in, silence, reaction, longest_judged, position, cycle, load = own[5:_ACCESSES]
    # A dissector without a verdict on TzA still has the longest interval of a record.
    return (
        _time(silence),
        _time(reaction),
        _time(longest_judged or longest),
        _time(cycle),
        _time(load),
        _known_integer(command_in),
        _known_integer(position),
    )


def _time(text: str) -> float:
    return _float(text) if text else math.nan


def _packet(
    own: tuple[int, int, float, float | None, list[float], bytes],
    telegrams: list[Telegram],
    said: list[list[Access]],
    columns: Mapping[str, str],
    alike: _Alike,
) -> Packet:
    """Return the packet of a row."""
    number, epoch_ns, time_s, uncertainty_s, intervals_s, characters = own
    since_s = intervals_s.pop(0) if intervals_s and not alike.unknown else None
    if since_s == _LONGEST_S:
        since_s = None  # it may be longer, and began before this capture
    if alike.unknown > 1:
        intervals_s = []  # nobody knows which ones they are
    return alike.make(
        number,
        epoch_ns / _S,
        time_s,
        uncertainty_s,
        intervals_s,
        since_s,
        telegrams,
        said[0] if len(said) == 1 else list(itertools.chain.from_iterable(said)),
        columns,
        alike,
        epoch_ns,
        characters,
    )


def _parts(columns: Mapping[str, str]) -> Sequence[Mapping[str, str]]:
    """Return the columns of each telegram of a packet. Most have one, and no others."""
    starts = columns.get(NECESSARY)
    if not starts:
        return []
    return apart(columns, starts.count(JOINT) + 1) if JOINT in starts else [columns]


def _faults(columns: Mapping[str, str]) -> Sequence[Fault]:
    """Return the faults of a telegram. What a damaged one says may be damaged, too."""
    found = tuple(fault for fault in FAULTS if rows.passes(fault.tests, columns))
    is_damaged = any(fault.name == "damaged" for fault in found)
    return tuple(fault for fault in found if fault.name not in _SAID) if is_damaged else found


def _making(columns: Mapping[str, str], faults: Sequence[Fault]) -> Callable[..., Packet]:
    """Return what makes a packet of what is its own."""
    get = columns.get
    return partial(
        Packet,
        get("frame.interface_name", ""),
        _integer(get("sertap.type")),
        _integer(get("sertap.line")),
        _integer(get("sertap.baud")),
        get("sertap.format", ""),
        _integer(get("sertap.framing")),
        _integer(get("sertap.event")),
        get("sertap.text", ""),
        _how_often(get("sertap.same_read")),
        sum(flag for name, flag in _LINE_ERRORS if _how_often(get(name))),
        faults,
    )


def _telegram(own: _OwnTimes, columns: Mapping[str, str], said: list[Access], alike: _AlikeTelegram) -> Telegram:
    silence_s, reaction_s, pause_s, cycle_s, load, command_in, position = own
    # Most of these are unknown: to ask before each call takes a third of the time.
    return alike.make(
        command_in or None,
        None if isnan(load) else load,
        None if isnan(silence_s) else Judged(silence_s, None, None),
        None if isnan(reaction_s) and alike.trs[1] is None else _judged(reaction_s, *alike.trs),
        None if isnan(pause_s) and alike.tza[1] is None else _judged(pause_s, *alike.tza),
        None if isnan(cycle_s) and alike.tmas[1] is None else _judged(cycle_s, *alike.tmas),
        position or None,
        columns,
        alike.faults,
        said,
    )


def _judged(time_s: float, limit_s: float | None, verdict: int | None) -> Judged:
    return Judged(0.0 if isnan(time_s) else time_s, limit_s, verdict)


def _integer(text: str | None) -> int | None:
    """Return the first of several values: a list of services has its own status before those of its services."""
    return int(first(text), 0) if text else None


def _number(text: str | None) -> float | None:
    return _float(text) if text else None


# For columns with few different texts.
_known_integer = lru_cache(1024)(_integer)
_known_number = lru_cache(1024)(_number)


def _float(text: str) -> float:
    """Return the first of several values. Nearly always there is only one."""
    try:
        return float(text)
    except ValueError:
        return float(first(text))


def _how_often(text: str | None) -> int:
    """Count the characters with a flag."""
    return sum(value in _TRUE for value in text.split(JOINT)) if text else 0
