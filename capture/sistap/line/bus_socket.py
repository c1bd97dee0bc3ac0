# SPDX-License-Identifier: GPL-2.0-or-later
"""The wire over a socket: characters with time, errors and line settings, for what a pty cannot carry.

The tap connects and says its own line settings, again whenever they change; the bus answers with reads. Network byte
order:

    both ways    'S' (1)  baud (4)  data bits (1)  parity code (1)  stop half bits (1)
    both ways    'T' (1)  time ns since 1970 (8)
    bus -> tap   'R' (1)  line (1)  count (2)  time ns since 1970 (8)  uncertainty ns (4)
                 then count times: value (1)  flags (1)

An 'S' of the bus repeats that of the tap: what follows it was heard with these settings. A 'T' of the bus says that
nothing arrives before that time. A bus whose time is simulated then waits until the tap has said the same 'T': that it
has dealt with all that came before, and what settings it wants from now on. It waits only for taps that said 'T' with
the time 0 when they connected.

One 'R' is what one read of a real adapter would have delivered: several characters in it share its time. The end of the
connection is the end of the bus (an unplugged adapter).
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from sistap.line.settings import PARITIES, STOP_HALF_BITS, LineSettings, Read

_SETTINGS = struct.Struct(">cIBBB")
_TIME = struct.Struct(">cQ")
_READ = struct.Struct(">cBHQI")
_TIME_END_NS = 4_000_000_000 * 1_000_000_000  # in 2096; 32 bits for the seconds (RTAC) end ten years later
_STRANGER = "the other end of the socket is not a sistap bus or tap"
_SIZES = {b"S": _SETTINGS.size, b"T": _TIME.size, b"R": _READ.size}  # of a message, or of its beginning


class Time(NamedTuple):
    """Nothing arrives before this time, in ns since 1970; from a tap: all that did was dealt with."""

    time_ns: int


Message = LineSettings | Time | Read


def pack_settings(settings: LineSettings) -> bytes:
    """Make the message of line settings."""
    parity = PARITIES.index(settings.parity)
    return _SETTINGS.pack(b"S", settings.baud, settings.data_bits, parity, settings.stop_half_bits)


def pack_time(time_ns: int) -> bytes:
    """Make the message of time."""
    return _TIME.pack(b"T", time_ns)


def pack_read(read: Read) -> bytes:
    """Make the message of characters."""
    pairs = bytearray(2 * len(read.data))
    pairs[0::2] = read.data
    pairs[1::2] = read.flags
    return _READ.pack(b"R", read.line, len(read.data), read.time_ns, read.uncertainty_ns) + pairs


class Decoder:
    """Cuts a byte stream into messages, however the socket packed it."""

    def __init__(self) -> None:
        """Start with nothing received."""
        self._pending = bytearray()

    def feed(self, data: bytes) -> list[Message]:
        """Take what the socket delivered, give the messages that are complete. ValueError if this is no wire."""
        self._pending += data
        messages: list[Message] = []
        while message := self._next():
            messages.append(message)
        return messages

    def _next(self) -> Message | None:
        pending = self._pending
        kind = bytes(pending[:1])
        size = _SIZES.get(kind, 0)
        if kind and not size:
            raise ValueError(_STRANGER)
        if not kind or len(pending) < size:
            return None
        message: Message | None
        if kind == b"S":
            message = _settings(pending)
        elif kind == b"T":
            message = Time(_TIME.unpack_from(pending)[1])
        else:
            _, line, count, time_ns, uncertainty_ns = _READ.unpack_from(pending)
            start, size = size, size + 2 * count
            if len(pending) < size:
                return None
            pairs = bytes(pending[start:size])
            message = Read(line, time_ns, pairs[0::2], pairs[1::2], uncertainty_ns)
        if not isinstance(message, LineSettings) and message.time_ns >= _TIME_END_NS:
            raise ValueError(_STRANGER)
        del pending[:size]
        return message


def _settings(message: bytes | bytearray) -> LineSettings:
    _, baud, data_bits, parity, stop = _SETTINGS.unpack_from(message)
    if parity >= len(PARITIES) or stop not in STOP_HALF_BITS.values() or not 5 <= data_bits <= 8:
        raise ValueError(_STRANGER)
    return LineSettings(baud, data_bits, PARITIES[parity], stop)
