# SPDX-License-Identifier: GPL-2.0-or-later
"""The wire over a socket: characters with time, errors and line settings, for what a pty cannot carry.

The tap connects and says its own line settings, again whenever they change; the bus answers with reads. Network byte
order:

    tap -> bus   'S' (1)  baud (4)  data bits (1)  parity code (1)  stop half bits (1)
    bus -> tap   'R' (1)  line (1)  count (2)  time ns since 1970 (8)  uncertainty ns (4)
                 then count times: value (1)  flags (1)

One 'R' is what one read of a real adapter would have delivered: several characters in it share its time. The end of the
connection is the end of the bus (an unplugged adapter).
"""

from __future__ import annotations

import struct

from sistap.line import PARITIES, LineSettings, Read

_SETTINGS = struct.Struct(">cIBBB")
_READ = struct.Struct(">cBHQI")
_TIME_END_NS = 4_000_000_000 * 1_000_000_000  # in 2096; 32 bits for the seconds (RTAC) end ten years later
SETTINGS_SIZE = _SETTINGS.size


def pack_settings(settings: LineSettings) -> bytes:
    """Make the tap's message."""
    parity = PARITIES.index(settings.parity)
    return _SETTINGS.pack(b"S", settings.baud, settings.data_bits, parity, settings.stop_half_bits)


def unpack_settings(message: bytes) -> LineSettings:
    """Read the tap's message, SETTINGS_SIZE bytes. ValueError if it is none."""
    kind, baud, data_bits, parity, stop = _SETTINGS.unpack(message)
    if kind != b"S" or parity >= len(PARITIES):
        raise ValueError("this is not a message of a tap")
    return LineSettings(baud, data_bits, PARITIES[parity], stop)


def pack_read(read: Read) -> bytes:
    """Make the bus's message."""
    pairs = bytearray(2 * len(read.data))
    pairs[0::2] = read.data
    pairs[1::2] = read.flags
    return _READ.pack(b"R", read.line, len(read.data), read.time_ns, read.uncertainty_ns) + pairs


class ReadDecoder:
    """Cuts a byte stream into reads, however the socket packed it."""

    def __init__(self) -> None:
        """Start with nothing received."""
        self._pending = bytearray()

    def feed(self, data: bytes) -> list[Read]:
        """Take what the socket delivered, give the reads that are complete. ValueError if this is no wire."""
        self._pending += data
        reads: list[Read] = []
        while len(self._pending) >= _READ.size:
            kind, line, count, time_ns, uncertainty_ns = _READ.unpack_from(self._pending)
            if kind != b"R" or time_ns >= _TIME_END_NS:
                raise ValueError("the other end of the socket is not a sistap bus")
            end = _READ.size + 2 * count
            if len(self._pending) < end:
                break
            pairs = bytes(self._pending[_READ.size : end])
            reads.append(Read(line, time_ns, pairs[0::2], pairs[1::2], uncertainty_ns))
            del self._pending[:end]
        return reads
