# SPDX-License-Identifier: GPL-2.0-or-later
"""Keeps what happens, as `sistap report` tells it; and passes values on."""

from __future__ import annotations

from collections.abc import Sequence

from sistap.commands.recorder.reasons import FAULTS, NOTHING, ByFilter, Reason
from sistap.commands.recorder.values import Values
from sistap.dissected.episodes.episode import Hit, severity_of
from sistap.dissected.episodes.live import FIELD, Live
from sistap.dissected.episodes.rules import Thresholds
from sistap.dissected.explain.fields import Fields
from sistap.dissected.explain.relay import Judged
from sistap.dissected.packets.dissection import FIELDS, packet_of
from sistap.dissected.wireshark.tshark import Tshark


class ByEpisodes:
    """Keeps what begins or goes on, if `keeps`; gives `values` all values of parameters."""

    finds = False  # tshark prints every packet

    def __init__(self, tshark: Tshark, thresholds: Thresholds, values: Values | None, *, keeps: bool) -> None:
        """Ask tshark for its fields. TsharkError if it has no dissector for SIS."""
        self._fields = Fields(tshark, (*FIELDS, FIELD))
        self._live = Live(thresholds) if keeps else None
        self._values = values

    def arguments(self, _: bytes | None) -> Sequence[str]:
        """Return the arguments for tshark."""
        return self._fields.arguments

    def columns(self, line: str) -> dict[str, str]:
        """Split what tshark prints."""
        return self._fields.columns(line)

    def reason(self, judged: Judged) -> Reason | None:
        """Return why a packet is kept; None: it is not."""
        if judged.is_unjudged and self._live:
            self._live.skip()
        if not judged.columns:
            return None
        packet = packet_of(judged.columns)
        if self._values:
            self._values.put(judged.entry.time_ns, packet.accesses)
        return _worst(self._live.add(packet)) if self._live else None

    def silent(self, now_ns: int) -> Reason | None:
        """Return why the silence is kept that lasts."""
        return _worst(self._live.silent(now_ns / 1e9)) if self._live else None


Judge = ByEpisodes | ByFilter


def judges(tshark: Tshark, keep: Sequence[str], thresholds: Thresholds, values: Values | None = None) -> list[Judge]:
    """Return who decides: one for each value of --keep; and who gives `values` all values. Refusal
    without a dissector for SIS.
    """
    keeps = FAULTS in keep
    watching: list[Judge] = [ByEpisodes(tshark, thresholds, values, keeps=keeps)] if keeps or values else []
    return watching + [ByFilter(tshark, one) for one in dict.fromkeys(keep) if one not in (FAULTS, NOTHING)]


def _worst(hits: Sequence[Hit]) -> Reason | None:
    """Return the worst as a reason, from the beginning of all."""
    if not hits:
        return None
    kind = max(hits, key=severity_of).kind
    return Reason(kind.replace("_", "-"), round(min(hit.from_s for hit in hits) * 1e9))
