# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a capture: counts everything as it comes, then fetches the windows that turned out worst from what was kept."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from sistap.commands.report import windows
from sistap.commands.report.figures import Figures
from sistap.commands.report.unjudged import unjudged
from sistap.commands.report.windows import ReportWindow
from sistap.dissected.captures.portions import Portion
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.episodes.lines import AnswerLine, lines
from sistap.dissected.episodes.rules import THRESHOLDS, Thresholds
from sistap.dissected.packets.dissection import Dissection
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.garbage import uncollected

_PROGRESS_EVERY = 5000  # packets


@dataclass
class Report:
    """All that is known of a capture, before it is put into words and pictures."""

    figures: Figures
    episodes: list[Episode]  # the worst first
    windows: list[ReportWindow]
    missing: list[str]  # fields that the installed dissector does not know
    warning: str  # what tshark said of a capture that is cut
    limits_ms: Mapping[str, int]  # tza and trs, where the person who asks tells them
    undescribed: int = 0  # parameters of which only bytes are known
    name: str = ""  # of the capture
    files: int = 1  # read as one
    left_out: list[str] = field(default_factory=list)  # files, or parts of them, that could not be read

    @property
    def answer(self) -> list[AnswerLine]:
        """Return the five lines that say what happened."""
        begin_s = self.figures.first_epoch_s or 0.0
        end_s = begin_s + self.figures.duration_s
        return lines(self.episodes, begin_s, end_s, unjudged(self.figures), self.undescribed)


def learned(tshark: Tshark, captures: Iterable[Portion], thresholds: Thresholds) -> Engine:
    """Return what knows a good capture. Refusal."""
    engine = Engine(thresholds=thresholds)
    with Dissection(tshark, captures, keeps=False) as dissection, uncollected():
        for packet in dissection.packets():
            engine.add(packet)
    return engine


def gather(  # noqa: PLR0913 - each comes from another part
    tshark: Tshark,
    captures: Iterable[Portion],
    asked: Sequence[ReportWindow],
    progress: Callable[[str], None],
    limits_ms: Mapping[str, int] = MappingProxyType({}),
    since_s: float = -math.inf,
    thresholds: Thresholds = THRESHOLDS,
    before: Engine | None = None,
    *,
    has_windows: bool = True,
) -> Report:
    """Read captures as one; `asked` are the windows that a person wants to see, `limits_ms` those to judge by. What
    came before `since_s` only tells what is usual, and so does the engine `before` of a good capture. Without windows,
    nothing is kept for them.

    Refusal.
    """
    figures, engine = Figures(), Engine(before, thresholds, since_s)
    preferences = {f"sis.{name}_ms": value for name, value in limits_ms.items()}
    dissecting = Dissection(tshark, captures, preferences=preferences, keeps=has_windows, since_s=since_s)
    with dissecting as dissection, uncollected():
        for packet in dissection.packets():
            engine.add(packet)
            if packet.is_before:
                continue
            figures.add(packet)
            if figures.packets % _PROGRESS_EVERY == 0:
                progress(f"{figures.packets} packets read, {packet.time_s:.0f} s of the capture")
        figures.finish()
        episodes = [episode for episode in engine.finish() if episode.to_s >= since_s]
        episodes.sort(key=lambda one: (-one.severity, one.from_s))
        shown = [*asked, *windows.around(episodes, figures.first_epoch_s or 0.0, asked)] if has_windows else []
        if shown:
            progress(f"{figures.packets} packets read; reading the worst of them once more")
            windows.fill(dissection, shown)
    said = dissection.missing, dissection.warning, limits_ms
    return Report(figures, episodes, shown, *said, engine.undescribed)
