# SPDX-License-Identifier: GPL-2.0-or-later
"""What the dissector says about each packet, streamed from tshark: the only source of figures for the products."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from sistap.accesses.access import FIELD as ACCESSES
from sistap.accesses.access import Access, accesses
from sistap.line.settings import Flag
from sistap.packets.kept import Kept, Span
from sistap.records.record import KEPT, Event
from sistap.sis.faults import FAULTS, Fault
from sistap.wireshark import rows
from sistap.wireshark.rows import (
    EVENT,
    JOINT,
    NECESSARY,
    NO_DISSECTOR,
    damage,
    first,
    unknown_fields,
)
from sistap.wireshark.tshark import Tshark, TsharkError

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
    ACCESSES,
)
_TESTED = rows.tested(test for fault in FAULTS for test in fault.tests)
FIELDS = tuple(dict.fromkeys((*_SHOWN, *_TESTED)))
# Those that differ from packet to packet. All others together have few different texts in a capture.
_OWN = {
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
}.difference(_TESTED)
_REMEMBERED = 2048  # of the texts of all others; each takes some 5 kB
_BEGINNING = {Event.CAPTURE_STARTED, Event.LIMITS_TOLD}
_GOOD = {"1", "Good"}
_TRUE = {"1", "True"}
LOST = int(Flag.LOST_BEFORE)  # in the errors of a packet
_CONTROL_ERROR = 6  # status bits of the edition ECODRIVE03: error
_LINE_ERRORS = (
    ("sertap.error.character", int(Flag.CHARACTER_ERROR)),
    ("sertap.error.break", int(Flag.BREAK)),
    ("sertap.error.unlocated", int(Flag.UNLOCATED_ERROR)),
    ("sertap.error.lost", LOST),
)


class Judged(NamedTuple):
    """A time with its limit and verdict, in s; None without a value."""

    time_s: float  # 0: not measured, because all came in one read
    limit_s: float | None
    verdict: int | None  # one of the three below

    @property
    def measured_s(self) -> list[float]:
        """Return the time if it was measured."""
        return [self.time_s] if self.time_s else []


OK, EXCEEDED, UNRESOLVED = 0, 1, 2


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
    command_in: int | None  # packet number
    is_repeat: bool
    unanswered: bool
    load_percent: float | None
    silence: Judged | None  # of the line, before it; there is no limit
    reaction: Judged | None  # TrS
    pause: Judged | None  # TzA; the longest inside the telegram
    cycle: Judged | None  # Tmas
    pause_position: int | None  # of the character after it, from 1
    columns: Mapping[str, str] = field(default_factory=dict, repr=False)  # as tshark printed them

    @property
    def judged(self) -> tuple[Judged | None, Judged | None, Judged | None]:
        """Return the times that have a limit."""
        return self.reaction, self.pause, self.cycle


@dataclass(slots=True)
class Packet:
    """A packet: a record of the serial tap, or any other carrier of telegrams. Times in s."""

    number: int
    epoch_s: float
    time_s: float  # since the first packet
    interface: str
    type: int | None  # FRAME, OTHER, EVENT; None: not a record of the tap
    baud: int | None
    format: str
    uncertainty_s: float | None
    event: int | None
    text: str
    intervals_s: list[float]  # from the second character on
    same_read: int  # characters from the same read as the one before
    errors: int  # Flags, ORed
    telegrams: list[Telegram] = field(default_factory=list)
    accesses: list[Access] = field(default_factory=list)  # to parameters
    framing: int | None = None  # of a frame; 0: SIS
    columns: Mapping[str, str] = field(default_factory=dict, repr=False)  # as tshark printed them
    faults: Sequence[Fault] = ()
    since_s: float | None = None  # from the character before it on its line to its first; None: unknown
    line: int | None = None
    length_s: float = field(init=False)
    is_before: bool = False  # the time from which on the capture is told
    is_again: bool = False  # an event at the beginning of a file that continues another, which began with it, too

    def __post_init__(self) -> None:
        """Add up its intervals once."""
        self.length_s = sum(self.intervals_s)

    @property
    def is_kept_apart(self) -> bool:
        """Tell whether a file of the recorder begins here: what came just before it is not in the capture."""
        return self.type == EVENT and self.event == Event.CAPTURE_STARTED and KEPT in self.text

    @property
    def end_s(self) -> float:
        """Return the time of its last character."""
        return self.time_s + self.length_s

    @property
    def ended_s(self) -> float:
        """Return the time of its last character, since 1970."""
        return self.epoch_s + self.length_s


class Dissection:
    """A capture as the installed dissector sees it, in two passes, so that later packets can explain earlier ones.

    Use it in a `with`.
    """

    def __init__(  # noqa: PLR0913 - each comes from another part
        self,
        tshark: Tshark,
        capture: Path,
        more: Sequence[str] = (),
        *,
        preferences: Mapping[str, object] = MappingProxyType({}),
        keeps: bool = True,
        since_s: float = -math.inf,
    ) -> None:
        """Read these fields, too, with preferences of Wireshark.

        Nothing is read yet; what is not kept cannot be read again(), nor what came before `since_s`. From there on the
        seconds of the capture are counted.
        """
        self._preferences = [word for name, value in preferences.items() for word in ("-o", f"{name}:{value}")]
        self._tshark = tshark
        self._capture = capture
        self._more = more
        self._fields = (*FIELDS, *more)
        self._keeps = keeps
        self._since_s = since_s
        self._zero_s = 0.0 if since_s == -math.inf else None  # where the seconds begin; None: not yet reached
        self._unknown: set[str] = set()
        self._rows = _Rows((), ())
        self._kept = Kept()
        self.warning = ""  # what tshark said at the end of a capture that is cut off

    def __enter__(self) -> Dissection:
        return self

    def __exit__(self, *error: object) -> None:
        self._kept.__exit__(*error)

    @property
    def missing(self) -> list[str]:
        """Return the fields that the installed dissector lacks; valid after the first packets."""
        return [name for name in self._fields if name in self._unknown]

    def packets(self) -> Iterator[Packet]:
        """Yield all packets, once. May raise NotACapture, TsharkError and Incomplete."""
        try:
            yield from _of_traffic(self._packets())
        except _UnknownFields as unknown:
            self._unknown |= unknown.names
            if NECESSARY in self._unknown:
                raise TsharkError(NO_DISSECTOR) from None
            yield from _of_traffic(self._packets())

    def again(self, spans: Collection[Span]) -> Iterator[Packet]:
        """Yield again the packets that begin in these spans."""
        for row in self._kept.rows(spans):
            packet = self._rows.packet(row)
            packet.time_s -= self._zero_s or 0.0
            if any(span.start_s <= packet.time_s <= span.end_s for span in spans):
                yield packet

    def _packets(self) -> Iterator[Packet]:
        self._rows = _Rows([name for name in self._fields if name not in self._unknown], self._more)
        arguments = ["-r", str(self._capture), "-2", *self._preferences, *rows.printing(self._rows.names)]
        came = False
        try:
            for line in self._tshark.lines(arguments):
                came = True
                packet = self._rows.packet(line)
                if self._zero_s is None and packet.epoch_s >= self._since_s:
                    self._zero_s = packet.time_s
                packet.is_before = self._zero_s is None
                packet.time_s -= self._zero_s or 0.0
                if self._keeps and not packet.is_before:
                    self._kept.put(packet.time_s, line)
                yield packet
        except TsharkError as error:
            self._judge(error, came)

    def _judge(self, error: TsharkError, came: bool) -> None:
        """Tell a damaged capture from a file that is none, and from an unknown field."""
        if unknown := unknown_fields(str(error)):
            raise _UnknownFields(unknown) from None
        self.warning = damage(self._capture, error, came)


def _of_traffic(packets: Iterable[Packet]) -> Iterator[Packet]:
    """Leave out what a file begins with because it continues another: what was told before, and known descriptions."""
    begun: set[tuple[str, int | None, str]] = set()
    beginning: list[Packet] = []
    for packet in packets:
        if packet.type == EVENT and packet.event in _BEGINNING:
            beginning.append(packet)
            continue
        is_again = packet.type == EVENT and packet.event == Event.TOLD_BEFORE
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


class _UnknownFields(Exception):
    """tshark does not know these fields."""

    def __init__(self, names: set[str]) -> None:
        super().__init__(", ".join(sorted(names)))
        self.names = names


class _AlikeTelegram(NamedTuple):
    """What a row says of a telegram besides what is its own."""

    fields: dict[str, Any]  # of a Telegram
    trs: tuple[float | None, int | None]  # limit and verdict
    tza: tuple[float | None, int | None]
    tmas: tuple[float | None, int | None]

    @classmethod
    def of(cls, columns: Mapping[str, str]) -> _AlikeTelegram:
        """Work it out."""
        get = columns.get
        fields = {
            "good": get("sis.checksum.status") in _GOOD,
            "service": _integer(get("sis.service")),
            "talker": _integer(get("sis.talker")),
            "listener": _integer(get("sis.listener")),
            "is_reaction": get("sis.control.reaction") in _TRUE,
            "status": _integer(get("sis.status")),
            "is_refusal": bool(_integer(get("sis.status"))) or _integer(get("sis.control.status")) == _CONTROL_ERROR,
            "has_system_error": get("sis.control.error") in _TRUE,
            "is_repeat": bool(get("sis.repeat_of")),
            "unanswered": bool(get("sis.command.unanswered")),
        }
        trs, tza, tmas = (
            (_number(get(f"sis.{name}.limit")), _integer(get(f"sis.{name}.verdict"))) for name in ("trs", "tza", "tmas")
        )
        return cls(fields, trs, tza, tmas)


class _Alike(NamedTuple):
    """What a row says besides what is its own, worked out once for all rows that say the same."""

    columns: dict[str, str]
    packet: dict[str, Any]  # fields of a Packet
    telegram: _AlikeTelegram | None  # if there is exactly one
    telegrams: int
    unknown: int  # intervals

    @classmethod
    def of(cls, columns: dict[str, str]) -> _Alike:
        """Work it out."""
        starts = columns.get("sis.start")
        telegrams = starts.count(JOINT) + 1 if starts else 0
        unknown = _how_often(columns.get("sertap.interval.unknown"))
        return cls(
            columns, _of_packet(columns), _AlikeTelegram.of(columns) if telegrams == 1 else None, telegrams, unknown
        )


class _Rows:
    """Makes packets of the rows that tshark prints. Each row ends with the columns that are not its own."""

    def __init__(self, names: Collection[str], more: Collection[str]) -> None:
        """Print these fields; `more` of them are own, too."""
        own = _OWN.union(more)
        self._own = [name for name in names if name in own]
        self._others = [name for name in names if name not in own]
        self.names = self._own + self._others
        self._alike = lru_cache(_REMEMBERED)(self._work_out)

    def packet(self, row: str) -> Packet:
        """Return the packet of a row."""
        texts = rows.safe(row).split("\t", len(self._own))
        alike = self._alike("\t".join(texts[len(self._own) :]))
        columns = alike.columns.copy()
        columns.update(zip(self._own, texts, strict=False))
        return packet_of(columns, alike)

    def _work_out(self, text: str) -> _Alike:
        own = dict.fromkeys(self._own, "")  # a copy of the columns has room for them
        return _Alike.of(own | dict(zip(self._others, text.split("\t"), strict=False)))


def packet_of(columns: dict[str, str], alike: _Alike | None = None) -> Packet:
    """Return the packet of a row; `alike`: what is known of such rows."""
    alike = alike or _Alike.of(columns)
    text = columns.get("sertap.interval")
    intervals_s = list(map(float, text.split(JOINT))) if text else []
    return Packet(
        number=int(columns["frame.number"]),
        epoch_s=float(columns["frame.time_epoch"] or 0),
        time_s=float(columns["frame.time_relative"] or 0),
        uncertainty_s=_known_number(columns.get("sertap.uncertainty")),
        intervals_s=_inside(intervals_s, alike.unknown),
        telegrams=_telegrams(columns, alike),
        accesses=list(accesses(columns)) if columns.get(ACCESSES) else [],
        columns=columns,
        since_s=intervals_s[0] if intervals_s and not alike.unknown else None,
        **alike.packet,
    )


def _inside(intervals_s: list[float], unknown: int) -> list[float]:
    """Return the intervals inside a record: without the one before its first character, which may be unknown."""
    if unknown > 1:
        return []  # nobody knows which ones they are
    return intervals_s if unknown else intervals_s[1:]


def _of_packet(columns: Mapping[str, str]) -> dict[str, Any]:
    get = columns.get
    return {
        "interface": get("frame.interface_name", ""),
        "type": _integer(get("sertap.type")),
        "baud": _integer(get("sertap.baud")),
        "format": get("sertap.format", ""),
        "event": _integer(get("sertap.event")),
        "text": get("sertap.text", ""),
        "same_read": _how_often(get("sertap.same_read")),
        "errors": sum(flag for name, flag in _LINE_ERRORS if _how_often(get(name))),
        "framing": _integer(get("sertap.framing")),
        "line": _integer(get("sertap.line")),
        "faults": tuple(fault for fault in FAULTS if rows.passes(fault.tests, columns)),
    }


def _telegrams(columns: dict[str, str], alike: _Alike) -> list[Telegram]:
    """Return the telegrams of a packet: TCP may carry several."""
    if alike.telegram:
        return [_telegram(columns, alike.telegram)]
    # If not all of them have a field, its values are ambiguous and are left out.
    split = {name: text.split(JOINT) for name, text in columns.items() if name.startswith("sis.")}
    parts = [
        {name: texts[index] for name, texts in split.items() if len(texts) == alike.telegrams}
        for index in range(alike.telegrams)
    ]
    return [_telegram(part, _AlikeTelegram.of(part)) for part in parts]


def _telegram(columns: Mapping[str, str], alike: _AlikeTelegram) -> Telegram:
    get = columns.get
    return Telegram(
        command_in=_integer(get("sis.command_in")),
        load_percent=_number(get("sis.bus.load")),
        silence=_judged(get("sis.silence_before")),
        reaction=_judged(get("sis.reaction_time"), *alike.trs),
        # A dissector without a verdict on TzA still has the longest interval of a record.
        pause=_judged(get("sis.tza.interval_max") or get("sertap.interval.max"), *alike.tza),
        cycle=_judged(get("sis.tmas.cycle"), *alike.tmas),
        pause_position=_known_integer(get("sis.tza.position")),
        columns=columns,
        **alike.fields,
    )


def _judged(time: str | None, limit_s: float | None = None, verdict: int | None = None) -> Judged | None:
    if not time and verdict is None:
        return None
    return Judged(float(first(time)) if time else 0.0, limit_s, verdict)


def _integer(text: str | None) -> int | None:
    """Return the first of several values: a list of services has its own status before those of its services."""
    return int(first(text), 0) if text else None


def _number(text: str | None) -> float | None:
    return float(first(text)) if text else None


# For columns with few different texts.
_known_integer = lru_cache(1024)(_integer)
_known_number = lru_cache(1024)(_number)


def _how_often(text: str | None) -> int:
    """Count the characters with a flag."""
    return sum(value in _TRUE for value in text.split(JOINT)) if text else 0
