# SPDX-License-Identifier: GPL-2.0-or-later
"""Keeps what happens, as `sistap report` tells it."""

from __future__ import annotations

from collections.abc import Sequence

from sistap.episodes.episode import Hit, severity_of
from sistap.episodes.live import FIELD, Live
from sistap.episodes.rules import Thresholds
from sistap.explain.fields import Fields
from sistap.explain.relay import Judged
from sistap.packets.dissection import FIELDS, packet_of
from sistap.recorder.reasons import FAULTS, NOTHING, ByFilter, Reason
from sistap.wireshark.tshark import Tshark


class ByEpisodes:
    """Keeps what begins or goes on."""

    finds = False  # tshark prints every packet

    def __init__(self, tshark: Tshark, thresholds: Thresholds) -> None:
        """Ask tshark for its fields. TsharkError if it has no dissector for SIS."""
        self._fields = Fields(tshark, (*FIELDS, FIELD))
        self._live = Live(thresholds)

    def arguments(self, _: bytes | None) -> Sequence[str]:
        """Return the arguments for tshark."""
        return self._fields.arguments

    def columns(self, line: str) -> dict[str, str]:
        """Split what tshark prints."""
        return self._fields.columns(line)

    def reason(self, judged: Judged) -> Reason | None:
        """Return why a packet is kept; None: it is not."""
        if judged.is_unjudged:
            self._live.skip()
        return _worst(self._live.add(packet_of(judged.columns))) if judged.columns else None

    def silent(self, now_ns: int) -> Reason | None:
        """Return why the silence is kept that lasts."""
        return _worst(self._live.silent(now_ns / 1e9))


Judge = ByEpisodes | ByFilter


def judges(tshark: Tshark, keep: Sequence[str], thresholds: Thresholds) -> list[Judge]:
    """Return who decides: one for each value of --keep. UsageError; TsharkError without a dissector for SIS."""
    if NOTHING in keep:
        return []
    watching: list[Judge] = [ByEpisodes(tshark, thresholds)] if FAULTS in keep else []
    return watching + [ByFilter(tshark, one) for one in dict.fromkeys(keep) if one != FAULTS]


def _worst(hits: Sequence[Hit]) -> Reason | None:
    """Return the worst as a reason, from the beginning of all."""
    if not hits:
        return None
    kind = max(hits, key=severity_of).kind
    return Reason(kind.replace("_", "-"), round(min(hit.from_s for hit in hits) * 1e9))
