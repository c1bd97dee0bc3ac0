# SPDX-License-Identifier: GPL-2.0-or-later
"""The memory of a station: flash with loader and firmware, RAM and dual-port RAM; modules and their checksums.

No document has a memory map; this one is small enough to be downloaded in a minute.
"""

from __future__ import annotations

import random
import zlib
from typing import NamedTuple


class Area(NamedTuple):
    """A range of addresses."""

    begin: int
    size: int

    def has(self, address: int, length: int) -> bool:
        """Tell whether a block lies in it."""
        return self.begin <= address and address + length <= self.begin + self.size


LOADER = Area(0x0000_0000, 0x1000)  # loader and kernel: never erased
FIRMWARE = Area(0x0000_1000, 0x3000)  # the base module, its header at the start
RAM = Area(0x0080_0000, 0x1000)
DUAL_PORT_RAM = Area(0x0090_0000, 0x0400)

_AREAS = (LOADER, FIRMWARE, RAM, DUAL_PORT_RAM)
_ERASED = 0xFF
CHECKSUMS = 6  # bytes at the end of a module


def module(payload: bytes) -> bytes:
    """Return a module: the payload, its CRC32, and the word that makes the sum of all words zero (chapter 5.1, 0x97).

    The documents do not define the CRC32 or the unit of the sum. This is the CRC32 of Ethernet, and words are the unit
    that can give zero. The payload has an even length.
    """
    whole = payload + zlib.crc32(payload).to_bytes(4, "little")
    return whole + (-_sum_of_words(whole) & 0xFFFF).to_bytes(2, "little")


def additive_good(whole: bytes) -> bool:
    """Tell whether the words of a module add up to zero."""
    return len(whole) > CHECKSUMS and len(whole) % 2 == 0 and _sum_of_words(whole) == 0


def crc_good(whole: bytes) -> bool:
    """Tell whether a module has the CRC32 of its payload."""
    payload, crc = whole[:-CHECKSUMS], whole[-CHECKSUMS:-2]
    return zlib.crc32(payload) == int.from_bytes(crc, "little")


def _sum_of_words(data: bytes) -> int:
    return sum(int.from_bytes(data[place : place + 2], "little") for place in range(0, len(data), 2)) & 0xFFFF


class Memory:
    """The contents of the memory."""

    def __init__(self, seed: str) -> None:
        """Fill it; `seed` decides the contents."""
        contents = random.Random(seed)
        self._bytes = {area: bytearray(contents.randbytes(area.size)) for area in _AREAS}
        self._bytes[FIRMWARE][:] = module(contents.randbytes(FIRMWARE.size - CHECKSUMS))

    def read(self, address: int, length: int) -> bytes | None:
        """Return a block; None if there is no such memory."""
        for area in _AREAS:
            if area.has(address, length):
                return bytes(self._bytes[area][address - area.begin : address - area.begin + length])
        return None

    def write(self, area: Area, address: int, data: bytes) -> bool:
        """Write a block; return False if it is not in that area."""
        if area.has(address, len(data)):
            self._bytes[area][address - area.begin : address - area.begin + len(data)] = data
            return True
        return False

    def program(self, address: int, data: bytes) -> bool:
        """Program flash, which only clears bits. Return False if the result differs from the data."""
        before = self.read(address, len(data)) if FIRMWARE.has(address, len(data)) else None
        if before is None:
            return False
        after = bytes(old & new for old, new in zip(before, data, strict=True))
        return self.write(FIRMWARE, address, after) and after == data

    def erase(self, address: int, length: int) -> bool:
        """Erase flash; return False outside the firmware's area."""
        return FIRMWARE.has(address, length) and self.write(FIRMWARE, address, bytes([_ERASED]) * length)

    @property
    def has_firmware(self) -> bool:
        """Tell whether there is a base module to start."""
        return any(byte != _ERASED for byte in self._bytes[FIRMWARE]) and additive_good(self._bytes[FIRMWARE])
