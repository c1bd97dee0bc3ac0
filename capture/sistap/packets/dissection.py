# SPDX-License-Identifier: GPL-2.0-or-later
"""What the dissector says about each packet, streamed from tshark: the only source of figures for the products."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from sistap.accesses.access import FIELD as ACCESSES
from sistap.accesses.access import Access, accesses
from sistap.line.settings import Flag
from sistap.packets.kept import Kept, Span
from sistap.wireshark import rows
from sistap.wireshark.rows import INFO_FIELDS, JOINT, NECESSARY, NO_DISSECTOR, damage, first, info, unknown_fields
from sistap.wireshark.tshark import Tshark, TsharkError

# Fields that the installed dissector lacks are left out and named in the report.
FIELDS = (
    "frame.number",
    "frame.time_epoch",
    "frame.time_relative",
    "frame.interface_name",
    "sertap.type",
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
    "sis.service",
    "sis.talker",
    "sis.listener",
    "sis.status",
    "sis.command_in",
    "sis.repeat_of",
    "sis.command.unanswered",
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
    ACCESSES,
)
_GOOD = {"1", "Good"}
_TRUE = {"1", "True"}
_LINE_ERRORS = (
    ("sertap.error.character", int(Flag.CHARACTER_ERROR)),
    ("sertap.error.break", int(Flag.BREAK)),
    ("sertap.error.unlocated", int(Flag.UNLOCATED_ERROR)),
    ("sertap.error.lost", int(Flag.LOST_BEFORE)),
)


class Judged(NamedTuple):
    """A time with its limit and verdict, in s; None without a value."""

    time_s: float
    limit_s: float | None
    verdict: int | None  # one of the three below


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
    command_in: int | None  # packet number
    is_repeat: bool
    unanswered: bool
    load_percent: float | None
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
    info: str = ""
    framing: int | None = None  # of a frame; 0: SIS
    columns: Mapping[str, str] = field(default_factory=dict, repr=False)  # as tshark printed them

    @property
    def end_s(self) -> float:
        """Return the time of its last character."""
        return self.time_s + sum(self.intervals_s)


class Dissection:
    """A capture as the installed dissector sees it, in two passes, so that later packets can explain earlier ones.

    Use it in a `with`.
    """

    def __init__(
        self,
        tshark: Tshark,
        capture: Path,
        more: Sequence[str] = (),
        *,
        preferences: Mapping[str, object] = MappingProxyType({}),
        keeps: bool = True,
    ) -> None:
        """Read these fields, too, with preferences of Wireshark.

        Nothing is read yet; what is not kept cannot be read again().
        """
        self._preferences = [word for name, value in preferences.items() for word in ("-o", f"{name}:{value}")]
        self._tshark = tshark
        self._capture = capture
        self._fields = (*FIELDS, *more, *(INFO_FIELDS if keeps else ()))
        self._keeps = keeps
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
        return [name for name in self._fields if name in self._unknown and name not in INFO_FIELDS]

    def packets(self) -> Iterator[Packet]:
        """Yield all packets, once. May raise NotACapture, TsharkError and Incomplete."""
        try:
            yield from self._packets()
        except _UnknownFields as unknown:
            self._unknown |= unknown.names
            if NECESSARY in self._unknown:
                raise TsharkError(NO_DISSECTOR) from None
            yield from self._packets()

    def again(self, numbers: Collection[int], spans: Collection[Span]) -> Iterator[Packet]:
        """Yield again the packets with these numbers, and those that begin in these spans."""
        for row in self._kept.rows(numbers, spans):
            packet = _packet(rows.columns(self._names, row))
            if packet.number in numbers or any(span.start_s <= packet.time_s <= span.end_s for span in spans):
                yield packet

    def _packets(self) -> Iterator[Packet]:
        self._names = [name for name in self._fields if name not in self._unknown]
        arguments = ["-r", str(self._capture), "-2", *self._preferences, *rows.printing(self._names)]
        came = False
        try:
            for line in self._tshark.lines(arguments):
                came = True
                packet = _packet(rows.columns(self._names, line))
                if self._keeps:
                    self._kept.put(packet.number, packet.time_s, line)
                yield packet
        except TsharkError as error:
            self._judge(error, came)

    def _judge(self, error: TsharkError, came: bool) -> None:
        """Tell a damaged capture from a file that is none, and from an unknown field."""
        if unknown := unknown_fields(str(error)):
            raise _UnknownFields(unknown) from None
        self.warning = damage(self._capture, error, came)


class _UnknownFields(Exception):
    """tshark does not know these fields."""

    def __init__(self, names: set[str]) -> None:
        super().__init__(", ".join(sorted(names)))
        self.names = names


def _packet(columns: dict[str, str]) -> Packet:
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
        info=info(columns),
        framing=_known_integer(columns.get("sertap.framing")),
        columns=columns,
    )


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
        command_in=_integer(get("sis.command_in")),
        is_repeat=bool(get("sis.repeat_of")),
        unanswered=bool(get("sis.command.unanswered")),
        load_percent=_number(get("sis.bus.load")),
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
    return Judged(float(first(time)), _known_number(limit), _known_integer(verdict)) if time else None


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
