# SPDX-License-Identifier: GPL-2.0-or-later
"""Service 0x02: flash operation (IF02 chapter 5; 0x10, 0x0B and the CRC32 as in the IndraDrive manual)."""

from __future__ import annotations

import random
import zlib
from collections.abc import Callable
from typing import NamedTuple

from sisbus.service import Request, ServiceFailed, ServiceRefused, Status, by_subservice
from sisbus.stations.station import Edition


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


# -- The loader ------------------------------------------------------------------------------------------------------

LONGEST_READ = 244  # bytes
_EVERYTHING = b"\xff" * 8  # the whole flash
_FIRMWARE_TARGET, _LOADER_TARGET = 0, 1
_FLASH = 4  # device type
_DEVICES = {2: RAM, 3: DUAL_PORT_RAM}  # device types with plain writes

# Error bytes; the code is the subservice followed by this byte.
_FIRMWARE_DELETED = 0x02
_READ_ERROR, _TOO_MUCH = 0x00, 0x0B
_ERASE_TIMEOUT, _ONLY_IN_LOADER = 0x00, 0x0A
_RAM_ERROR, _VERIFY_ERROR, _PROGRAM_TIMEOUT = 0xFF, 0xE0, 0xE1
_ADDITIVE_WRONG, _CRC_WRONG = 0x01, 0x02


class Flash:
    """A station's loader.

    A failure is a system error of the station until 0x9F resets it.
    """

    def __init__(
        self,
        memory: Memory,
        phase: Callable[[int], int],
        edition: Edition,
        restart: Callable[[], None],
        worn: bool = False,
    ) -> None:
        """Start in the firmware.

        `phase` returns the phase at a time, `restart` acts on a reboot; a `worn` flash cannot be erased or programmed
        in time.
        """
        self._memory = memory
        self._phase = phase
        self._edition = edition
        self._restart = restart
        self._worn = worn
        self.in_loader = False
        self.error = False
        self._plain = by_subservice(
            0x02,
            {
                0x90: self._shutdown,
                0x91: self._reboot,
                0x92: self._read,
                0x93: lambda data, now_ns: FIRMWARE.begin.to_bytes(4, "little"),  # where its header is
                0x94: self._erase,
                0x96: self._program,
                0x97: self._build_checksum,
                0x9F: self._reset,
            },
        )
        self.service = self._plain._replace(execute=self._noticed)

    def _noticed(self, request: Request) -> bytes:
        try:
            return self._plain.execute(request)
        except ServiceFailed:
            self.error = True
            raise

    def _shutdown(self, data: bytes, now_ns: int) -> bytes:
        if data[0] not in (_FIRMWARE_TARGET, _LOADER_TARGET):
            raise ServiceRefused(Status.INVALID_ADDRESS)
        self._check_start(now_ns, firmware=data[0] == _FIRMWARE_TARGET)
        self.in_loader = data[0] == _LOADER_TARGET
        return b""

    def _reboot(self, data: bytes, now_ns: int) -> bytes:
        self._check_start(now_ns, firmware=True)
        self.in_loader = False
        self._restart()
        return b""

    def _check_start(self, now_ns: int, firmware: bool) -> None:
        code = None if self.in_loader else self._edition.no_shutdown.get(self._phase(now_ns))
        if code is not None:
            raise ServiceFailed(bytes([code]))
        if firmware and not self._memory.has_firmware:
            raise ServiceFailed(bytes([_FIRMWARE_DELETED]))

    def _read(self, data: bytes, now_ns: int) -> bytes:
        if data[4] > LONGEST_READ:
            raise ServiceFailed(bytes([_TOO_MUCH]))
        block = self._memory.read(_address(data), data[4])
        if block is None:
            raise ServiceFailed(bytes([_READ_ERROR]))
        return block

    def _erase(self, data: bytes, now_ns: int) -> bytes:
        if not self.in_loader:
            raise ServiceFailed(bytes([_ONLY_IN_LOADER]))
        if self._worn:
            raise ServiceFailed(bytes([_ERASE_TIMEOUT]))
        block = FIRMWARE if data[:8] == _EVERYTHING else (_address(data), _address(data[4:]))
        if not self._memory.erase(*block):
            raise ServiceRefused(Status.INVALID_ADDRESS)
        return b""

    def _program(self, data: bytes, now_ns: int) -> bytes:
        address, device, contents = _address(data), data[4], data[5:]
        if device == _FLASH:
            if self._worn:
                raise ServiceFailed(bytes([_PROGRAM_TIMEOUT]))
            if not self._memory.program(address, contents):
                raise ServiceFailed(bytes([_VERIFY_ERROR]))
        elif device not in _DEVICES:
            raise ServiceRefused(Status.INVALID_ADDRESS)
        elif not self._memory.write(_DEVICES[device], address, contents):
            raise ServiceFailed(bytes([_RAM_ERROR]))
        return b""

    def _build_checksum(self, data: bytes, now_ns: int) -> bytes:
        whole = self._memory.read(_address(data), _address(data[4:]))
        if self._edition.crc32:
            return _crc32(whole)
        if whole is None or not additive_good(whole):
            raise ServiceFailed(bytes([_ADDITIVE_WRONG]))
        if not crc_good(whole):
            raise ServiceFailed(bytes([_CRC_WRONG]))
        return b""

    def _reset(self, data: bytes, now_ns: int) -> bytes:
        self.error = False
        return b""


def _crc32(block: bytes | None) -> bytes:
    """Return a CRC32 (IndraDrive). Only the master knows which block has which checksum."""
    if block is None:
        raise ServiceRefused(Status.INVALID_ADDRESS)
    return zlib.crc32(block).to_bytes(4, "little")


def _address(data: bytes) -> int:
    return int.from_bytes(data[:4], "little")
