# SPDX-License-Identifier: GPL-2.0-or-later
"""The serial line as the rest of sistap sees it: its settings, and characters with their times and errors.

Only this passes from a reader to the framer. No later module knows what a serial port is.
"""

from __future__ import annotations

import enum
from typing import NamedTuple

PARITIES = "NEOMS"  # a letter's place is its code in the record (0 none .. 4 space)
STOP_HALF_BITS = {"1": 2, "1.5": 3, "2": 4}

UNCERTAINTY_UNKNOWN = 0xFFFFFFFF


def in_ms(uncertainty_ns: int) -> str:
    """Write an uncertainty in ms."""
    return "unknown" if uncertainty_ns >= UNCERTAINTY_UNKNOWN else f"{uncertainty_ns / 1e6:.2f} ms"


class Flag(enum.IntFlag):
    """What is known about one received character, as stored in the record."""

    SAME_READ = 0x01  # came in the same read as the character before
    CHARACTER_ERROR = 0x02  # parity or framing error; POSIX cannot tell which
    BREAK = 0x04
    LOST_BEFORE = 0x08  # characters were lost before this one
    UNLOCATED_ERROR = 0x10  # an error somewhere in its read, place unknown
    INTERVAL_UNKNOWN = 0x20  # first character on the line
    INTERVAL_SATURATED = 0x40  # the interval does not fit into 32 bits of nanoseconds

    # Set by the reader. The other flags are set where intervals are computed (framer).
    FROM_READER = CHARACTER_ERROR | BREAK | LOST_BEFORE | UNLOCATED_ERROR


ERROR_FLAGS = Flag.CHARACTER_ERROR | Flag.BREAK | Flag.LOST_BEFORE | Flag.UNLOCATED_ERROR


class LineSettings(NamedTuple):
    """Rate and character format of a line; parity is a letter of PARITIES, stop bits count in halves."""

    baud: int = 9600  # 0: unknown
    data_bits: int = 8
    parity: str = "E"
    stop_half_bits: int = 2

    @classmethod
    def parse(cls, baud: int, text: str) -> LineSettings:
        """Parse a format such as "8E1" or "7N1.5"; ValueError says what is wrong with it."""
        data, parity, stop = text[:1], text[1:2].upper(), text[2:]
        if data not in ("5", "6", "7", "8") or parity not in PARITIES or not parity or stop not in STOP_HALF_BITS:
            raise ValueError(
                f"format '{text}' is not data bits 5..8, parity N, E, O, M or S, stop bits 1, 1.5 or 2, such as 8E1"
            )
        return cls(baud, int(data), parity, STOP_HALF_BITS[stop])

    @property
    def format(self) -> str:
        """Return the format as people write it, "8E1"."""
        stop = {half_bits: text for text, half_bits in STOP_HALF_BITS.items()}[self.stop_half_bits]
        return f"{self.data_bits}{self.parity}{stop}"

    def __str__(self) -> str:
        return f"{self.baud} Bd {self.format}"

    @property
    def character_ns(self) -> int:
        """Return how long one character takes on the line, in ns; 0 if the rate is unknown."""
        if not self.baud:
            return 0
        half_bits = 2 * (1 + self.data_bits + (self.parity != "N")) + self.stop_half_bits
        return half_bits * 500_000_000 // self.baud


class Read(NamedTuple):
    """Characters that arrived together: what one read of a port delivered.

    `time_ns` (wall clock, ns since 1970) is the latest instant at which each of them can have arrived. Of k characters
    the i-th came at least (k-i) character times before it, and none earlier than `uncertainty_ns` before that.

    A read without characters gives the time of a source that has its own: nothing later has an earlier time.
    """

    line: int  # 0 shared bus, 1 and 2 the directions of a full-duplex tap
    time_ns: int
    data: bytes
    flags: bytes  # one Flag byte for each character, of FROM_READER
    uncertainty_ns: int = UNCERTAINTY_UNKNOWN
    settings: LineSettings | None = None  # settings of these characters; None: as at the beginning
    notices: tuple[str, ...] = ()  # of the source, to be reported before the characters
