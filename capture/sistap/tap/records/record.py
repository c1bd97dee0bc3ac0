# SPDX-License-Identifier: GPL-2.0-or-later
"""The record: one packet of protocol `sertap` as bytes (layout: plugin/docs/record.md; network byte order)."""

from __future__ import annotations

import enum
import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from sistap.tap.line.settings import ERROR_FLAGS, PARITIES, UNCERTAINTY_UNKNOWN, Flag, LineSettings

VERSION = 1
HEADER = struct.Struct(">BBBBIBBBBIHH")
MAX_CHARACTERS = 43_000  # 6 bytes for each: Wireshark refuses a file with a packet above 262,144 bytes
INTERVAL_MAX = 0xFFFFFFFF
KEPT = "; kept: "  # in the text that starts a file of the recorder: nothing from before it was kept
CLOCK_MOVED = "the wall clock moved by {:+.3f} s"  # in the text of a marker: times of the capture go on without it
LARGEST_RATE = 0xFFFFFFFF
_NO_ERROR = Flag(0)
_NO_ERRORS = bytes(flags for flags in range(256) if not flags & ERROR_FLAGS)


def interval_text(interval_ns: int) -> str:
    """Write an interval in ms. The longest that can be stored was any longer."""
    return f"{'more than ' if interval_ns == INTERVAL_MAX else ''}{interval_ns / 1e6:.3f} ms"


class Type(enum.IntEnum):
    """The contents of a record."""

    FRAME = 0
    OTHER = 1
    EVENT = 2
    BEFORE = 3  # a frame from before this file: learned from, not counted, not judged


class Framing(enum.IntEnum):
    """The rule by which frames were cut; the key of Wireshark's table `sertap.framing`."""

    SIS = 0
    PROCEDURE_3964R = 1
    ASCII = 2
    SILENCE = 255


class Event(enum.IntEnum):
    """Event codes of records of type EVENT."""

    NONE = 0
    CAPTURE_STARTED = 1
    SETTINGS_CHANGED = 2
    CHARACTERS_LOST = 3
    ADAPTER_LOST = 4
    MARKER = 5
    LIMITS_TOLD = 6  # by the user; the text is for the dissector: TzA = 8 ms, TrS = 20 ms
    TOLD_BEFORE = 7  # facts from before, of earlier versions: see Type.BEFORE

    @classmethod
    def _missing_(cls, value: object) -> Event | None:
        """Keep the number of an event of a later version."""
        if not isinstance(value, int):
            return None
        later = int.__new__(cls, value)
        later._name_, later._value_ = f"LATER_{value}", value
        return later


class Character(NamedTuple):
    """A character of a record. It came between `time_ns - uncertainty` of the record and `time_ns`."""

    time_ns: int
    value: int
    flags: Flag


class Record(NamedTuple):
    """One record. `intervals[i]` is ns since the character before it on that line; for an event both arrays are empty.

    `time_ns` is not part of the bytes: it is the packet's time stamp, that of the first character.
    """

    time_ns: int
    type: Type
    line: int
    settings: LineSettings
    data: bytes
    intervals: Sequence[int] = ()
    flags: bytes = b""
    uncertainty_ns: int = UNCERTAINTY_UNKNOWN
    framing: Framing = Framing.SIS
    event: Event = Event.NONE
    checksum_bad: bool = False  # a complete telegram with a wrong checksum; not stored, but in the packet flags

    def pack(self) -> bytes:
        """Return the bytes of the record. OverflowError above MAX_CHARACTERS."""
        count = len(self.data)
        if count > MAX_CHARACTERS:
            raise OverflowError(f"{count} characters do not fit into one record")
        settings = self.settings
        header = HEADER.pack(
            VERSION,
            HEADER.size,
            self.type,
            self.line,
            settings.baud,
            settings.data_bits,
            PARITIES.index(settings.parity),
            settings.stop_half_bits,
            self.framing,
            self.uncertainty_ns,
            count,
            self.event,
        )
        if self.type == Type.EVENT:
            return header + self.data
        return header + self.data + struct.pack(f">{count}I", *self.intervals) + self.flags

    def characters(self) -> Iterator[Character]:
        """Yield its characters; an event has none."""
        time_ns = self.time_ns
        for place, (interval, flags) in enumerate(zip(self.intervals, self.flags, strict=True)):
            time_ns += interval if place else 0
            yield Character(time_ns, self.data[place], Flag(flags))

    @property
    def end_ns(self) -> int:
        """Return the time of its last character."""
        return self.time_ns + sum(self.intervals[1:])

    @property
    def is_good_frame(self) -> bool:
        """Tell whether it is a frame without a wrong checksum."""
        return self.type == Type.FRAME and not self.checksum_bad

    @property
    def is_handshake(self) -> bool:
        """Tell whether it is a frame of one character of a 3964R handshake, not a telegram."""
        return self.framing == Framing.PROCEDURE_3964R and self.type == Type.FRAME and len(self.data) == 1

    @property
    def errors(self) -> Flag:
        """Return all line errors of the record's characters, ORed."""
        union = 0
        for flag in self.flags.translate(None, _NO_ERRORS):  # nearly always nothing is left
            union |= flag
        return Flag(union) & ERROR_FLAGS if union else _NO_ERROR


def event(time_ns: int, line: int, settings: LineSettings, code: Event, text: str) -> Record:
    """Return an event record; cut off text that does not fit."""
    data = text.encode(errors="backslashreplace")[:MAX_CHARACTERS].decode(errors="ignore").encode()
    return Record(time_ns, Type.EVENT, line, settings, data, event=code)


def unpack(data: bytes, time_ns: int = 0) -> Record:
    """Parse the bytes of a record. ValueError says what does not fit."""
    if len(data) < HEADER.size:
        raise ValueError(f"{len(data)} bytes are shorter than the header of a record ({HEADER.size})")
    version, size, kind, line, baud, bits, parity, stop, framing, uncertainty, count, code = HEADER.unpack_from(data)
    if version != VERSION:
        raise ValueError(f"record version {version} is not {VERSION}")
    per_character = 1 if kind == Type.EVENT else 6
    if size < HEADER.size or len(data) != size + per_character * count:
        raise ValueError(f"{count} characters do not fit a record of {len(data)} bytes with a header of {size}")
    settings = LineSettings(baud, bits, PARITIES[parity], stop)
    characters = data[size : size + count]
    intervals: tuple[int, ...] = ()
    flags = b""
    if kind != Type.EVENT:
        intervals = struct.unpack_from(f">{count}I", data, size + count)
        flags = data[size + 5 * count :]
    return Record(
        time_ns, Type(kind), line, settings, characters, intervals, flags, uncertainty, Framing(framing), Event(code)
    )
