# SPDX-License-Identifier: GPL-2.0-or-later
"""Stretches of a capture that are shown in full detail: those asked for, and those around what is worst."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from sistap.dissected.episodes.episode import Episode
from sistap.dissected.episodes.rules import RULES, Subject
from sistap.dissected.packets.dissection import Dissection, Packet
from sistap.dissected.packets.kept import Span
from sistap.dissected.wireshark.rows import FRAME, OTHER

WORST_SHOWN = 3  # windows around what is worst
PACKETS_KEPT = 1000  # in a window: more would be a grey bar and a page of many megabytes
_LEAST_MARGIN_S = 0.03  # so that what came before and after is seen, also at 9600 Bd
_LONGEST_PACKET_S = 5.0  # a packet that reaches into a window can begin this much earlier


@dataclass
class ReportWindow:
    """From `start_s` to `end_s`, in s since the first packet."""

    title: str
    start_s: float
    end_s: float
    packets: list[Packet] = field(default_factory=list)
    left_out: int = 0  # packets above PACKETS_KEPT

    def add(self, packet: Packet) -> None:
        """Take a packet of characters, if any of it is inside."""
        if packet.type not in (FRAME, OTHER) or packet.time_s > self.end_s or packet.end_s < self.start_s:
            return
        if len(self.packets) < PACKETS_KEPT:
            self.packets.append(packet)
        else:
            self.left_out += 1

    def shows(self, start_s: float, end_s: float) -> bool:
        """Tell whether it shows a time from its beginning to its end."""
        return self.start_s <= start_s and end_s <= self.end_s


def asked(start_s: float, length_s: float) -> ReportWindow:
    """Return a window that was asked for."""
    return ReportWindow(f"Asked for: {length_s:g} s from {start_s:g} s", start_s, start_s + length_s)


def around(episodes: Iterable[Episode], first_epoch_s: float, shown: Sequence[ReportWindow]) -> list[ReportWindow]:
    """Make windows around the worst of each kind that is about single telegrams, unless a window shows it already."""
    worst: dict[str, Episode] = {}
    for one in episodes:
        if one.rule.subject == Subject.LIMITS and one.kind != "clock":
            worst[one.kind] = max(worst.get(one.kind, one), one, key=_badness)
    made: list[ReportWindow] = []
    for one in sorted(worst.values(), key=lambda one: (-one.severity, _ORDER[one.kind])):
        waited_s = one.hit.worst or 0.0 if one.kind == "late" else 0.0
        start_s, end_s = one.hit.from_s - first_epoch_s - waited_s, one.hit.to_s - first_epoch_s
        if any(window.shows(start_s, end_s) for window in [*shown, *made]):
            continue
        margin_s = max((end_s - start_s) / 2, _LEAST_MARGIN_S)
        made.append(
            ReportWindow(f"Packet {one.hit.packet}: {one.rule.title}", max(start_s - margin_s, 0.0), end_s + margin_s)
        )
        if len(made) == WORST_SHOWN:
            break
    return made


def _badness(episode: Episode) -> tuple[int, float]:
    return episode.severity, episode.hit.worst or 0.0


_ORDER = {kind: number for number, kind in enumerate(RULES)}


def fill(dissection: Dissection, windows: Sequence[ReportWindow]) -> None:
    """Read the packets of all windows."""
    spans = [Span(max(window.start_s - _LONGEST_PACKET_S, 0), window.end_s) for window in windows]
    for packet in dissection.again(spans) if windows else ():
        for window in windows:
            window.add(packet)
