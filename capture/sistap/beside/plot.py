# SPDX-License-Identifier: GPL-2.0-or-later
"""Draws the lateness of all characters with matplotlib."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from sistap.beside.lateness import Lateness

_WIDE_IN, _HIGH_IN = 10.0, 4.0
_INSIDE, _OUTSIDE, _BOUND = "#0072b2", "#d1350f", "#8b95a1"


def picture(lateness: Lateness, title: str, kind: str) -> bytes:
    """Draw the lateness of each character over time, and its distribution."""
    import io

    figure = Figure(figsize=(_WIDE_IN, _HIGH_IN), layout="constrained", dpi=150)
    over_time, shares = figure.subplots(1, 2, sharey=True, width_ratios=[3, 1])
    characters = lateness.characters
    begin_ns = characters[0].true_ns
    for is_outside, colour, name in ((False, _INSIDE, "inside"), (True, _OUTSIDE, "outside")):
        chosen = [one for one in characters if one.is_outside == is_outside]
        over_time.plot(
            [(one.true_ns - begin_ns) / 1e9 for one in chosen],
            [one.latest_ns / 1e6 for one in chosen],
            ".",
            color=colour,
            markersize=3,
            label=f"{name}: {len(chosen)}",
            rasterized=True,
        )
    bounds = [((one.true_ns - begin_ns) / 1e9, one.uncertainty_ns / 1e6) for one in characters if one.uncertainty_ns]
    over_time.plot(*zip(*bounds, strict=True), color=_BOUND, linewidth=1, label="uncertainty") if bounds else None
    over_time.set(xlabel="seconds since the first character", ylabel="late by ms, against the quickest")
    over_time.legend()
    ordered = sorted(one.latest_ns / 1e6 for one in characters)
    shares.plot([100 * (place + 1) / len(ordered) for place in range(len(ordered))], ordered, color=_INSIDE)
    shares.set(xlabel="% of the characters")
    figure.suptitle(title)
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind)
    return buffer.getvalue()


def kind_of(path: Path) -> str:
    """Return the kind of picture by the ending of a file. ValueError if it is unknown."""
    kind = path.suffix.removeprefix(".").lower()
    if kind not in ("png", "svg"):
        raise ValueError(f"'{path}' does not say what to draw: end it in .png or .svg")
    return kind
