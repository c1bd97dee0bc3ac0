# SPDX-License-Identifier: GPL-2.0-or-later
"""Service 0x02: flash operation (IF02 chapter 5; 0x10, 0x0B and the CRC32 as in the IndraDrive manual)."""

from __future__ import annotations

import zlib
from collections.abc import Callable

from sistap.bus.service import ServiceFailed, ServiceRefused, Status, Subservice, by_subservice
from sistap.bus.stations.edition import Edition
from sistap.bus.stations.memory import DUAL_PORT_RAM, FIRMWARE, RAM, Memory, additive_good, crc_good

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
        self.service = by_subservice(
            {
                0x90: self._noticed(5, self._shutdown),
                0x91: self._noticed(4, self._reboot),
                0x92: self._noticed(5, self._read),
                0x93: Subservice(0, self._find_header),
                0x94: self._noticed(8, self._erase),
                0x96: self._noticed(5, self._program),
                0x97: self._noticed(8, self._build_checksum),
                0x9F: Subservice(0, self._reset),
            }
        )

    def _noticed(self, least: int, execute: Callable[[bytes, int], bytes]) -> Subservice:
        def noticing(data: bytes, now_ns: int) -> bytes:
            try:
                return execute(data, now_ns)
            except ServiceFailed:
                self.error = True
                raise

        return Subservice(least, noticing)

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

    def _find_header(self, data: bytes, now_ns: int) -> bytes:
        return FIRMWARE.begin.to_bytes(4, "little")

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
