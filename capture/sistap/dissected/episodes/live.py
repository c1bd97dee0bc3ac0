# SPDX-License-Identifier: GPL-2.0-or-later
"""What happens, told while it happens. A day is remembered: memory is bounded for months."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from sistap.dissected.episodes.engine import Bus, Engine
from sistap.dissected.episodes.episode import Hit
from sistap.dissected.episodes.rules import RULES, THRESHOLDS, Severity, Thresholds
from sistap.dissected.packets.dissection import Packet, Telegram
from sistap.dissected.wireshark.rows import EVENT
from sistap.tap.records.record import KEPT, Event

FIELD = "sis.unanswered_before"  # of a command: the one before it had no reaction; one pass does not know it earlier
LIVE = THRESHOLDS._replace(memory_s=86_400.0)
_CERTAIN = {"clock"}  # as a note, too


class LiveEpisodes:
    """The engine, packet by packet as they come."""

    def __init__(self, thresholds: Thresholds = LIVE) -> None:
        """Begin with no packet."""
        self._engine = Engine(thresholds=thresholds)
        self._learning_s = thresholds.learning_s
        self._began_s = math.inf
        self._apart: set[Bus] = set()  # of which packets were left out
        self._asked: dict[tuple[Bus, int | None], tuple[Packet, Telegram]] = {}  # the last command of each master
        self._last_s: dict[tuple[str, str, int | None, str], float] = {}  # when what goes on was last there

    def add(self, packet: Packet) -> list[Hit]:
        """Return what is not as usual in a packet, or since a little earlier."""
        self._began_s = min(self._began_s, packet.epoch_s)
        bus = self._engine.bus_of(packet)
        if bus in self._apart:
            self._apart.remove(bus)
            self._engine.live(_seam(packet), is_learning=True)
        self._follow(packet, bus)
        is_learning = packet.epoch_s - self._began_s < self._learning_s
        return [hit for hit in self._engine.live(packet, is_learning=is_learning) if self._matters(hit)]

    def silent(self, now_s: float) -> list[Hit]:
        """Return the silences that last while no packet comes, each once."""
        return self._engine.silent(now_s)

    def skip(self) -> None:
        """Go on after packets that nobody has looked at."""
        self._asked.clear()
        self._apart = set(self._engine.buses)

    def _follow(self, packet: Packet, bus: Bus) -> None:
        """Tell the engine of commands without a reaction."""
        if packet.type != EVENT and not any(telegram.good for telegram in packet.telegrams):
            self._asked = {asked: one for asked, one in self._asked.items() if asked[0] is not bus}  # perhaps answered
        for telegram in packet.telegrams:
            if telegram.good and not telegram.is_reaction:
                asked = bus, telegram.talker
                before = self._asked.get(asked)
                if before and telegram.columns.get(FIELD):
                    self._engine.unanswered(*before)
                self._asked[asked] = packet, telegram

    def _matters(self, hit: Hit) -> bool:
        rule = RULES[hit.kind]
        is_unsure = hit.severity == Severity.NOTE
        if not rule.is_kept or (is_unsure and hit.kind not in _CERTAIN):
            return False
        if not rule.goes_on:
            return True
        key = hit.kind, hit.port, hit.station, hit.topic
        last_s, self._last_s[key] = self._last_s.get(key, -math.inf), hit.to_s
        return hit.from_s - last_s >= rule.join_s


def _seam(packet: Packet) -> Packet:
    """Return the beginning of a file, as a recorder's, that begins with a packet."""
    nothing: dict[str, Any] = {"telegrams": [], "accesses": [], "intervals_s": [], "alike": object()}
    return replace(packet, type=EVENT, event=Event.CAPTURE_STARTED, text=KEPT, **nothing)
