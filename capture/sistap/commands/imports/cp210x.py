# SPDX-License-Identifier: GPL-2.0-or-later
"""Decodes what a CP210x says over USB: line settings in requests, line errors among the characters.

The requests follow Silicon Labs' AN571 and Linux' cp210x.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from sistap.commands.imports.usb_line import Plain, flags, rate, with_format
from sistap.commands.imports.usb_transfers import Setup
from sistap.tap.line.settings import Flag, LineSettings

VENDORS = frozenset({0x10C4})
ESCAPE = 0xEC  # as Linux chooses it
_INTERFACE_REQUEST = 0x41
_SET_DIVISOR, _SET_FORMAT, _EMBED_EVENTS, _SET_RATE = 0x01, 0x03, 0x15, 0x1E
# Enable, divisor, format, modem control, purge, flow control, events, characters, rate.
REQUESTS = frozenset(
    (_INTERFACE_REQUEST, request)
    for request in (0x00, _SET_DIVISOR, _SET_FORMAT, 0x07, 0x12, 0x13, _EMBED_EVENTS, 0x19, _SET_RATE)
)
_CLOCK = 3_686_400  # Hz


def settings_after(setup: Setup, data: bytes, settings: LineSettings) -> LineSettings:
    """Return the line settings after a request."""
    if setup.type != _INTERFACE_REQUEST:
        return settings
    if setup.request == _SET_RATE and len(data) >= 4:
        return settings._replace(baud=int.from_bytes(data[:4], "little"))
    if setup.request == _SET_DIVISOR and setup.value:
        return settings._replace(baud=rate(_CLOCK / setup.value))
    if setup.request == _SET_FORMAT:
        return with_format(settings, setup.value >> 8, setup.value >> 4 & 0x0F, setup.value & 0x0F)
    return settings


class Events(Plain):
    """The transfers of a CP210x. With embedded events, an escape character begins what is no character.

    What follows it: 0 it is a character itself, 1 line status and the character that has it, 2 line status of a loss, 3
    modem status. An event may begin in one transfer and end in the next.
    """

    _ITEM = (
        rb"(?s)(?P<plain>(?:[^E]|E(?=[^\x00-\x03]))+)|"
        rb"E(?:(?P<itself>\x00)|\x01(?P<status>.)(?P<one>.)|\x02(?P<lost>.)|\x03.)"
    )

    def __init__(self, escape: int = 0) -> None:
        """`escape` is 0 without embedded events."""
        self._begin(escape)

    def _begin(self, escape: int) -> None:
        self._item = re.compile(self._ITEM.replace(b"E", re.escape(bytes([escape])))) if escape else None
        self._rest = b""  # the beginning of an event
        self._lost = Flag(0)  # before the next character

    def asked(self, setup: Setup) -> None:
        """Note that events are switched on or off."""
        if (setup.type, setup.request) == (_INTERFACE_REQUEST, _EMBED_EVENTS):
            self._begin(setup.value & 0xFF)

    def packets(self, data: bytes) -> Iterator[tuple[bytes, bytes]]:
        """Take the events out of a transfer."""
        if not self._item:
            yield from super().packets(data)
            return
        data, at = self._rest + data, 0
        while item := self._item.match(data, at):
            at = item.end()
            characters = item["plain"] or item["one"] or (item["itself"] and item[0][:1])
            if item["lost"]:
                self._lost |= Flag(flags(item["lost"][0], 1)[0]) & Flag.LOST_BEFORE
            if characters:
                first = flags(item["status"][0], 1)[0] if item["status"] else 0
                yield characters, bytes([first | self._lost]) + bytes(len(characters) - 1)
                self._lost = Flag(0)
        self._rest = data[at:]
