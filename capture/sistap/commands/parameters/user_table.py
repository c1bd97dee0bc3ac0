# SPDX-License-Identifier: GPL-2.0-or-later
"""Wireshark's table "SIS parameters": its file `sis_parameters`, which the plugin and sis.lua read."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.commands.parameters.backup import Drive, Saved
from sistap.dissected.telegrams.values import shown_limit
from sistap.tap.sis.telegram import shown

_PLAIN = frozenset(range(0x20, 0x7F)) - frozenset(b'"\\')


def lines(drive: Drive, station: str) -> Iterator[str]:
    """Yield the rows of a drive; an empty station is every station."""
    for saved in drive.parameters:
        yield ",".join(map(_cell, _row(saved, station)))


def _row(saved: Saved, station: str) -> tuple[str, ...]:
    kind, set_, number = saved.ident.split("-")
    limits = (shown_limit(saved.attribute, limit, saved.unit) for limit in (saved.minimum, saved.maximum))
    attribute = f"0x{saved.attribute.bits:08x}"
    return (kind, number if set_ == "0" else f"{set_}-{number}", saved.name, saved.unit, attribute, *limits, station)


def _cell(text: str) -> str:
    """Quote a text as Wireshark reads it."""
    return '"' + "".join(chr(byte) if byte in _PLAIN else f"\\x{byte:02x}" for byte in shown(text).encode()) + '"'
