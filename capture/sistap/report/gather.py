# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a capture: counts everything as it comes, then fetches the windows that turned out worst from what was kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from sistap.packets.dissection import Dissection
from sistap.packets.moments import Moment
from sistap.report import windows
from sistap.report.figures import Figures
from sistap.report.windows import Window
from sistap.terminal.garbage import uncollected
from sistap.terminal.visible import visible
from sistap.wireshark.tshark import Tshark

_PROGRESS_EVERY = 5000  # packets


@dataclass
class Report:
    """All that is known of a capture, before it is put into words and pictures."""

    name: str  # of the capture
    figures: Figures
    worst: list[Moment]
    info: dict[int, str]  # lines of Wireshark's packet list, by packet number
    windows: list[Window]
    missing: list[str]  # fields that the installed dissector does not know
    warning: str  # what tshark said of a capture that is cut
    limits_ms: Mapping[str, int]  # tza and trs, where the person who asks tells them


def gather(
    tshark: Tshark,
    capture: Path,
    asked: Sequence[Window],
    progress: Callable[[str], None],
    limits_ms: Mapping[str, int] = MappingProxyType({}),
) -> Report:
    """Read a capture; `asked` are the windows that a person wants to see, `limits_ms` those to judge by.

    NotACapture, TsharkError, Incomplete.
    """
    figures = Figures()
    preferences = {f"sis.{name}_ms": value for name, value in limits_ms.items()}
    with Dissection(tshark, capture, preferences=preferences) as dissection, uncollected():
        progress(f"reading {capture}")
        for packet in dissection.packets():
            figures.add(packet)
            if figures.packets % _PROGRESS_EVERY == 0:
                progress(f"{figures.packets} packets read, {packet.time_s:.0f} s of the capture")
        worst = figures.moments.worst()
        shown = [*asked, *windows.around(worst, asked)]
        progress(f"{figures.packets} packets read; reading the worst of them once more")
        info = windows.fill(dissection, shown, worst)
    return Report(visible(capture.name), figures, worst, info, shown, dissection.missing, dissection.warning, limits_ms)
