# SPDX-License-Identifier: GPL-2.0-or-later
"""The wire over a socket: characters of a virtual bus with time and errors, and line settings.

The listener connects. Network byte order; DEVELOP.md says what each message means:

    from the bus   'V' (1)  version (1)  time ns (8)  length (2)  text (length)
    both ways      'S' (1)  baud (4)  data bits (1)  parity code (1)  stop half bits (1)
    both ways      'T' (1)  time ns (8)
    from the bus   'R' (1)  line (1)  count (2)  time ns (8)  uncertainty ns (4)
                   then count times: value (1)  flags (1)
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import NamedTuple

from sistap.tap.line.settings import PARITIES, STOP_HALF_BITS, LineSettings, Read

VERSION = 2

_SETTINGS = struct.Struct(">cIBBB")
_TIME = struct.Struct(">cQ")
_READ = struct.Struct(">cBHQI")
_HELLO = struct.Struct(">cBQH")
TIME_END_NS = 4_000_000_000 * 1_000_000_000  # in 2096; 32 bits for the seconds (RTAC) end ten years later
_TEXT_MAX = 0xFFFF  # bytes
_SHOWN_MAX = 1000  # characters of a text from the other end
CURE = ": give the address that `sistap bus` prints"
_STRANGER = f"the other end of the socket is not a sistap bus{CURE}"
_LATE = "the clock of the other end says a year after 2095: set it there"
_SIZES = {  # of a message, or of its beginning
    kind: form.size for kind, form in zip("VSTR", (_HELLO, _SETTINGS, _TIME, _READ), strict=True)
}
FROM_BUS, FROM_LISTENER = "VSTR", "ST"  # which messages they may say


class Hello(NamedTuple):
    """The first message of a bus."""

    time_ns: int  # now, by its clock
    adapter: str
    timing: str
    version: int = VERSION


class Time(NamedTuple):
    """Nothing arrives before this time, in ns since 1970."""

    time_ns: int


Message = Hello | LineSettings | Time | Read


def pack_settings(settings: LineSettings) -> bytes:
    """Return the message of line settings."""
    parity = PARITIES.index(settings.parity)
    return _SETTINGS.pack(b"S", settings.baud, settings.data_bits, parity, settings.stop_half_bits)


def pack_time(time_ns: int) -> bytes:
    """Return the message of time."""
    return _TIME.pack(b"T", time_ns)


def pack_read(read: Read) -> bytes:
    """Return the message of characters."""
    pairs = bytearray(2 * len(read.data))
    pairs[0::2] = read.data
    pairs[1::2] = read.flags
    return _READ.pack(b"R", read.line, len(read.data), read.time_ns, read.uncertainty_ns) + pairs


def pack_hello(hello: Hello) -> bytes:
    """Return the first message."""
    text = f"{hello.adapter}\n{hello.timing}".encode(errors="backslashreplace")[:_TEXT_MAX]
    return _HELLO.pack(b"V", hello.version, hello.time_ns, len(text)) + text


class Decoder:
    """Cuts a byte stream into messages, whatever pieces the socket delivers. It keeps at most one incomplete
    message.
    """

    def __init__(self, kinds: str = FROM_BUS) -> None:
        """Refuse messages that are not of these `kinds`."""
        self._pending = bytearray()
        self._kinds = kinds

    def feed(self, data: bytes) -> list[Message]:
        """Take what the socket delivered; return the complete messages. ValueError if the stream is not this
        protocol.
        """
        self._pending += data
        messages: list[Message] = []
        while message := self._next():
            messages.append(message)
        return messages

    def _next(self) -> Message | None:
        pending = self._pending
        kind = pending[:1].decode("latin-1")
        if not kind:
            return None
        if kind not in self._kinds:
            raise ValueError(_STRANGER)
        start = _SIZES[kind]
        if len(pending) < start:
            return None
        size = start + (_LENGTHS[kind](pending) if kind in _LENGTHS else 0)
        if len(pending) < size:
            return None
        message = _MAKE[kind](bytes(pending[:start]), bytes(pending[start:size]))
        if isinstance(message, Time | Read | Hello) and message.time_ns >= TIME_END_NS:
            raise ValueError(_LATE if message.time_ns < 1 << 63 else _STRANGER)
        del pending[:size]
        return message


def _text(data: bytes) -> str:
    """Decode a text from the other end, and make it safe for a terminal."""
    decoded = data.decode(errors="replace")[:_SHOWN_MAX]
    return "".join(letter if letter.isprintable() else f"\\u{ord(letter):04x}" for letter in decoded)


def _hello(head: bytes, rest: bytes) -> Hello:
    _, version, time_ns, _ = _HELLO.unpack(head)
    if version != VERSION:
        raise ValueError(
            f"it speaks version {version} of the wire, and this sistap {VERSION}: use the same at both ends"
        )
    adapter, _, timing = rest.partition(b"\n")
    return Hello(time_ns, _text(adapter), _text(timing))


def _read(head: bytes, pairs: bytes) -> Read:
    _, line, _, time_ns, uncertainty_ns = _READ.unpack(head)
    return Read(line, time_ns, pairs[0::2], pairs[1::2], uncertainty_ns)


def _settings(message: bytes, _: bytes) -> LineSettings:
    baud, data_bits, parity, stop = _SETTINGS.unpack(message)[1:]
    if parity >= len(PARITIES) or stop not in STOP_HALF_BITS.values() or not 5 <= data_bits <= 8:
        raise ValueError(_STRANGER)
    return LineSettings(baud, data_bits, PARITIES[parity], stop)


# How many bytes follow the beginning of a message, and how to decode it.
_LENGTHS: dict[str, Callable[[bytearray], int]] = {
    "V": lambda pending: int(_HELLO.unpack_from(pending)[-1]),
    "R": lambda pending: 2 * int(_READ.unpack_from(pending)[2]),
}
_MAKE: dict[str, Callable[[bytes, bytes], Message]] = {
    "V": _hello,
    "S": _settings,
    "T": lambda head, _: Time(_TIME.unpack(head)[1]),
    "R": _read,
}
