# SPDX-License-Identifier: GPL-2.0-or-later
"""What adapters of several makers have in common: characters in transfers, formats, rates, line errors."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.commands.imports.usb_transfers import Setup
from sistap.tap.analyser.finding import BAUDS
from sistap.tap.line.settings import Flag, LineSettings

# The line status of a 16550, as FTDI and CP210x adapters say it.
_OVERRUN, _PARITY, _FRAMING, _BREAK = 0x02, 0x04, 0x08, 0x10

_TOLERANCE = 0.01  # a divisor is closer than this to the usual rates


class Plain:
    """The transfers of an adapter with characters and nothing else. Other adapters put something between them."""

    def asked(self, setup: Setup) -> None:
        """Take note of a request to the adapter."""

    def packets(self, data: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Split a transfer: characters and flags of each part that has any."""
        if data:
            yield data, bytes(len(data))

    def is_full(self, data: bytes) -> bool:  # noqa: ARG002
        """Tell whether more may have waited in the adapter than the transfer has room for."""
        return False


def with_format(settings: LineSettings, bits: int, parity: int, stop: int) -> LineSettings:
    """Return settings with this format, in the numbers that most adapters use; unchanged if it cannot be."""
    if bits not in (5, 6, 7, 8) or parity > 4 or stop > 2:
        return settings
    return settings._replace(data_bits=bits, parity="NOEMS"[parity], stop_half_bits=stop + 2)


def rate(*readings: float) -> int:
    """Return the rate in Bd that a divisor means. Of several readings, the one closest to a usual rate is right."""
    error, usual, reading = min((abs(each / usual - 1), usual, each) for each in readings for usual in BAUDS)
    return usual if error < _TOLERANCE else round(reading)


def flags(status: int, count: int) -> bytes:
    """Return the flags of characters that share a line status: an error has a known place only in a single one."""
    error = 0
    if status & _BREAK:
        error = Flag.BREAK
    elif status & (_PARITY | _FRAMING):
        error = Flag.CHARACTER_ERROR
    if (error or status & _OVERRUN) and count > 1:  # a loss is before one of them, too
        error = Flag.UNLOCATED_ERROR
    first = error | (Flag.LOST_BEFORE if status & _OVERRUN else 0)
    return bytes([first]) + bytes([error]) * (count - 1)
