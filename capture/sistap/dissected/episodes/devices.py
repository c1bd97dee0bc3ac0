# SPDX-License-Identifier: GPL-2.0-or-later
"""Which device is at an address: its firmware and type key (service 0x00)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from sistap.dissected.episodes.episode import ARROW, Hit
from sistap.dissected.episodes.faults import hit_of
from sistap.dissected.packets.dissection import Packet, Telegram

_IDENTIFY = 0x00
_TOLD = {"sis.firmware": "firmware", "sis.type_key": "type key"}


class Devices:
    """Those of a bus."""

    def __init__(self, before: Devices | None = None) -> None:
        """Begin with those of a good capture, or with none known."""
        self._known: dict[tuple[int, str], str] = dict(before._known) if before else {}

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return that another device answers."""
        hits: list[Hit] = []
        for telegram in packet.telegrams:
            if telegram.service == _IDENTIFY and telegram.is_reaction and telegram.good and not telegram.is_refusal:
                hits += self._of(packet, telegram)
        return hits

    def _of(self, packet: Packet, telegram: Telegram) -> Iterator[Hit]:
        station = telegram.talker
        for field, name in _TOLD.items():
            text = telegram.columns.get(field, "")
            if not text or station is None:
                continue
            before = self._known.get((station, name))
            self._known[station, name] = text
            if before not in (None, text):
                yield hit_of("exchanged", packet, station, f"{name} {before}{ARROW}{text}", topic=name)
