# SPDX-License-Identifier: GPL-2.0-or-later
"""The telegrams that a tshark must know if it starts in the middle of a capture.

The dissector remembers the limits and rates that were set (service 0x03), and what was read of parameters: their names,
units and attributes. So the last of each of these commands is kept, with its reaction. The memory is bounded.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass

from sistap.sis import telegram
from sistap.sis.telegram import Header

_OPERATING_DATA = 7  # the element that is the value, bits 3 to 5 of the parameter control
_TOLD = {0x03}
_READ = {0x10, 0x11, 0x80, 0x81, 0x90, 0x91}
MOST_TOLD, MOST_READ, MOST_OPEN = 500, 4000, 100


@dataclass(slots=True)
class _Exchange:
    number: int  # in the order of the commands
    is_value: bool
    command: bytes  # as a block
    reaction: bytes = b""


class Memory:
    """The last exchanges that the dissector learns from, in order."""

    def __init__(self) -> None:
        self._number = 0
        self._kept: tuple[tuple[set[int], int, OrderedDict[tuple[object, ...], _Exchange]], ...] = (
            (_TOLD, MOST_TOLD, OrderedDict()),
            (_READ, MOST_READ, OrderedDict()),
        )
        self._open: OrderedDict[tuple[int, int], tuple[Header, bytes]] = OrderedDict()  # reads, keyed by their stations

    def take(self, data: bytes, block: bytes) -> None:
        """Take a good telegram and its block."""
        header = telegram.parse(data)
        if header.service in _TOLD and not header.reaction:  # most of these have no reaction: they are broadcast
            self._keep(header, block)
        if header.service not in _TOLD | _READ:
            return
        stations = header.sender, header.receiver
        if not header.reaction:
            self._open[stations] = header, block
            _bound(self._open, MOST_OPEN)
            return
        # A device may swap the addresses in its reactions.
        asked = self._open.pop(stations, None) or self._open.pop(stations[::-1], None)
        if asked and asked[0].service == header.service:
            self._keep(*asked, block)

    def blocks(self, *, values: bool = True) -> Iterator[bytes]:
        """Yield the block of each telegram; without values, only what explains others: limits, names, units."""
        exchanges = [exchange for _, _, kept in self._kept for exchange in kept.values()]
        for exchange in sorted(exchanges, key=lambda exchange: exchange.number):
            if values or not exchange.is_value:
                yield exchange.command
                if exchange.reaction:
                    yield exchange.reaction

    def _keep(self, header: Header, command: bytes, reaction: bytes = b"") -> None:
        is_value = header.service in _READ and bool(header.body) and header.body[0] >> 3 & 7 == _OPERATING_DATA
        exchange = _Exchange(self._number, is_value, command, reaction)
        self._number += 1
        # Ignore number and checksum: then a repeated command is the same.
        key = header.service, header.sender, header.receiver, header.subaddresses, header.body
        for services, most, kept in self._kept:
            if header.service in services:
                kept.pop(key, None)
                kept[key] = exchange
                _bound(kept, most)


def _bound(
    kept: OrderedDict[tuple[int, int], tuple[Header, bytes]] | OrderedDict[tuple[object, ...], _Exchange], most: int
) -> None:
    while len(kept) > most:
        kept.popitem(last=False)
