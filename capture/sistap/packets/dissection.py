# SPDX-License-Identifier: GPL-2.0-or-later
"""What the dissector says about each packet, streamed from tshark: the only source of figures for the products."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from sistap.accesses.access import FIELD as ACCESSES
from sistap.accesses.access import Access, accesses
from sistap.line.settings import Flag
from sistap.packets.kept import Kept, Span
from sistap.records.record import KEPT, Event
from sistap.sis.faults import FAULTS
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
_BEGINNING = {Event.CAPTURE_STARTED, Event.LIMITS_TOLD}
_GOOD = {"1", "Good"}
_TRUE = {"1", "True"}
_CONTROL_ERROR = 6  # status bits of the edition ECODRIVE03: error
_LINE_ERRORS = (
    ("sertap.error.character", int(Flag.CHARACTER_ERROR)),
    ("sertap.error.break", int(Flag.BREAK)),
    ("sertap.error.unlocated", int(Flag.UNLOCATED_ERROR)),
    ("sertap.error.lost", int(Flag.LOST_BEFORE)),
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
        self._fields = (*FIELDS, *more)
        self._keeps = keeps
        self._since_s = since_s
        self._zero_s = 0.0 if since_s == -math.inf else None  # where the seconds begin; None: not yet reached
        self._unknown: set[str] = set()
        self._names: list[str] = []  # of the columns
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
            packet = packet_of(rows.columns(self._names, row))
            packet.time_s -= self._zero_s or 0.0
            if any(span.start_s <= packet.time_s <= span.end_s for span in spans):
                yield packet

    def _packets(self) -> Iterator[Packet]:
        self._names = [name for name in self._fields if name not in self._unknown]
        arguments = ["-r", str(self._capture), "-2", *self._preferences, *rows.printing(self._names)]
        came = False
        try:
            for line in self._tshark.lines(arguments):
                came = True
                packet = packet_of(rows.columns(self._names, line))
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


def packet_of(columns: dict[str, str]) -> Packet:
    """Return the packet of a row."""
    return Packet(
        number=int(columns["frame.number"]),
        epoch_s=float(columns["frame.time_epoch"] or 0),
        time_s=float(columns["frame.time_relative"] or 0),
        interface=columns.get("frame.interface_name", ""),
        type=_known_integer(columns.get("sertap.type")),
        baud=_known_integer(columns.get("sertap.baud")),
        format=columns.get("sertap.format", ""),
        uncertainty_s=_number(columns.get("sertap.uncertainty")),
        event=_known_integer(columns.get("sertap.event")),
        text=columns.get("sertap.text", ""),
        intervals_s=_intervals(columns),
        same_read=_how_often(columns.get("sertap.same_read")),
        errors=_errors(columns),
        telegrams=_telegrams(columns),
        accesses=list(accesses(columns)),
        framing=_known_integer(columns.get("sertap.framing")),
        columns=columns,
        since_s=_since(columns),
        line=_known_integer(columns.get("sertap.line")),
    )


def _since(columns: dict[str, str]) -> float | None:
    """Return the interval before the first character, unless one of them is unknown."""
    text = columns.get("sertap.interval")
    return float(first(text)) if text and not _how_often(columns.get("sertap.interval.unknown")) else None


def _intervals(columns: dict[str, str]) -> list[float]:
    """Return the intervals inside a record: without the one before its first character, which may be unknown."""
    text = columns.get("sertap.interval")
    if not text:
        return []
    unknown = _how_often(columns.get("sertap.interval.unknown"))
    if unknown > 1:
        return []  # nobody knows which ones they are
    intervals = list(map(float, text.split(JOINT)))
    return intervals if unknown else intervals[1:]


def _errors(columns: dict[str, str]) -> int:
    errors = 0
    for name, flag in _LINE_ERRORS:
        if _how_often(columns.get(name)):
            errors |= flag
    return errors


def _telegrams(columns: dict[str, str]) -> list[Telegram]:
    """Return the telegrams of a packet: TCP may carry several."""
    starts = columns.get("sis.start")
    if not starts:
        return []
    count = starts.count(JOINT) + 1
    if count == 1:
        return [_telegram(columns)]
    # If not all of them have a field, its values are ambiguous and are left out.
    split = {name: text.split(JOINT) for name, text in columns.items() if name.startswith("sis.")}
    return [
        _telegram({name: texts[index] for name, texts in split.items() if len(texts) == count})
        for index in range(count)
    ]


def _telegram(columns: dict[str, str]) -> Telegram:
    get = columns.get
    return Telegram(
        good=get("sis.checksum.status") in _GOOD,
        service=_known_integer(get("sis.service")),
        talker=_known_integer(get("sis.talker")),
        listener=_known_integer(get("sis.listener")),
        is_reaction=get("sis.control.reaction") in _TRUE,
        status=_known_integer(get("sis.status")),
        is_refusal=bool(_known_integer(get("sis.status")))
        or _known_integer(get("sis.control.status")) == _CONTROL_ERROR,
        has_system_error=get("sis.control.error") in _TRUE,
        command_in=_integer(get("sis.command_in")),
        is_repeat=bool(get("sis.repeat_of")),
        unanswered=bool(get("sis.command.unanswered")),
        load_percent=_number(get("sis.bus.load")),
        silence=_judged(get("sis.silence_before"), None, None),
        reaction=_judged(get("sis.reaction_time"), get("sis.trs.limit"), get("sis.trs.verdict")),
        # A dissector without a verdict on TzA still has the longest interval of a record.
        pause=_judged(
            get("sis.tza.interval_max") or get("sertap.interval.max"), get("sis.tza.limit"), get("sis.tza.verdict")
        ),
        cycle=_judged(get("sis.tmas.cycle"), get("sis.tmas.limit"), get("sis.tmas.verdict")),
        pause_position=_known_integer(get("sis.tza.position")),
        columns=columns,
    )


def _judged(time: str | None, limit: str | None, verdict: str | None) -> Judged | None:
    if not time and not verdict:
        return None
    return Judged(float(first(time)) if time else 0.0, _known_number(limit), _known_integer(verdict))


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
