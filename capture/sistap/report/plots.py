# SPDX-License-Identifier: GPL-2.0-or-later
"""The pictures of a report, drawn by matplotlib. What was counted in bins is drawn from bins."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path as Outline
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from sistap.accesses.listing import Listed
from sistap.report.curves import Curve, Point
from sistap.report.dissection import EXCEEDED, Packet, Telegram
from sistap.report.distribution import Distribution, Slices
from sistap.report.gather import Report
from sistap.report.moments import KINDS
from sistap.report.tables import ms, of_device
from sistap.report.windows import Window
from sistap.sis.names import service_name

# By role, on white paper. The page gives each role another colour in the dark. Blue, green and vermilion can be told
# apart by people who do not see red or green; red things have words beside them as well.
COLOURS = {
    "ink": "#1d2733",
    "line": "#8b95a1",
    "command": "#0072b2",
    "reaction": "#009e73",
    "other": "#9aa0a6",
    "bad": "#d1350f",
}
_SETTINGS: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "sistap",
    "font.size": 10,
    "figure.facecolor": "white",
    "axes.facecolor": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": COLOURS["ink"],
    "axes.labelcolor": COLOURS["ink"],
    "axes.edgecolor": COLOURS["line"],
    "axes.titlesize": 10,
    "xtick.color": COLOURS["line"],
    "ytick.color": COLOURS["line"],
    "xtick.labelcolor": COLOURS["ink"],
    "ytick.labelcolor": COLOURS["ink"],
    "legend.frameon": False,
}
_LANES = 12  # the busiest stations and services; more would not be readable
_LABELS = 24  # packet numbers in a window
_LABELLED = 0.97  # of its width: a number at the right edge would be cut
_CURVES, _CURVES_IN_A_ROW = 24, 3
_FEW = 40  # points, each of which is drawn
_FAR = 2.0  # times the span of the values: a limit farther away is not drawn
_JOINED = 5  # bins of a Distribution that make one bar
_WIDE_IN, _NARROW_IN = 10.0, 5.2


class Pen(NamedTuple):
    """What strokes are drawn with."""

    role: str  # of COLOURS
    width_pt: float


_RED = Pen("bad", 1.5)


class Drawing(NamedTuple):
    """A picture to be drawn into a figure of its own, or with others into one."""

    title: str
    width_in: float
    height_in: float
    draw: Callable[[SubFigure | Figure], None]

    @property
    def is_wide(self) -> bool:
        """Whether it needs the width of a page."""
        return self.width_in == _WIDE_IN


def overview(report: Report) -> Drawing | None:
    """The bus over the whole capture: load, what each station sent, where the faults are."""
    slices, moments = report.figures.slices, report.figures.moments
    busiest = sorted(report.figures.stations, key=lambda address: -sum(slices.counts[str(address)]))[:_LANES]
    stations = [(f"station {address}", slices.counts[str(address)]) for address in sorted(busiest)]
    faults = [(kind.short, slices.counts[kind.name]) for kind in KINDS if kind.is_fault and moments.counts[kind.name]]
    has_load = any(load is not None for load in slices.loads)
    if not stations and not faults:
        return None

    def draw(figure: SubFigure | Figure) -> None:
        lanes = len(stations) + len(faults)
        if has_load:
            upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2, 0.5 + lanes * 0.5])
            upper.fill_between(*_load(slices), color=COLOURS["other"])
            upper.set(ylim=(0, 100), ylabel="bus load\nin %")
        else:
            lower = figure.subplots()
        for lane, (_, counts) in enumerate(stations):
            most = max(counts) or 1
            _steps(lower, counts[: slices.used], slices.width_s, -lane, 0.8 / most)
        for lane, (_, counts) in enumerate(faults, len(stations)):
            times = [(number + 0.5) * slices.width_s for number, count in enumerate(counts) if count]
            _strokes(lower, times, -lane, 0.8, _RED)
        _name_lanes(lower, [name for name, _ in stations + faults])
        lower.set_xlim(0, slices.used * slices.width_s)
        lower.set_xlabel(f"seconds since the first packet; a step is {slices.width_s:g} s")

    return Drawing("The whole capture", _WIDE_IN, 1.0 + 1.3 * has_load + 0.33 * (len(stations) + len(faults)), draw)


def _load(slices: Slices) -> tuple[list[float], list[float]]:
    """Return times and percent of the load. It is that of the last second: a second after a telegram it is 0."""
    times: list[float] = []
    percents: list[float] = []
    for number, percent in enumerate(slices.loads):
        if percent is None:
            continue
        time_s = number * slices.width_s
        if times and time_s - times[-1] > 1 + slices.width_s:
            times += [times[-1] + 1, time_s]
            percents += [0.0, 0.0]
        times.append(time_s)
        percents.append(percent)
    return times, percents


def _steps(axes: Axes, values: Sequence[float], width: float, base: float, scale: float) -> None:
    """Fill the area under steps that begin at x = 0."""
    edges = [number * width for number in range(len(values) + 1)]
    axes.stairs([base + value * scale for value in values], edges, baseline=base, fill=True, color=COLOURS["command"])


def _strokes(axes: Axes, times: Iterable[float], base: float, height: float, pen: Pen) -> None:
    """Draw upright strokes, all as one path: there can be thousands."""
    points = [point for time in times for point in ((time, base), (time, base + height))]
    if points:
        codes = [Outline.MOVETO, Outline.LINETO] * (len(points) // 2)
        axes.add_patch(
            PathPatch(Outline(points, codes), edgecolor=COLOURS[pen.role], linewidth=pen.width_pt, fill=False)
        )


def _name_lanes(axes: Axes, names: Sequence[str]) -> None:
    """Give lanes at 0, -1, -2 ... their names and a ground line each."""
    axes.set_ylim(0.7 - len(names), 0.95)
    axes.spines.left.set_visible(False)
    axes.set_yticks([0.4 - lane for lane in range(len(names))], names)
    axes.tick_params(axis="y", length=0)
    for lane in range(len(names)):
        axes.axhline(-lane, color=COLOURS["line"], linewidth=0.5)


def intervals(report: Report) -> Drawing | None:
    """How often each interval between the characters of a telegram came, with TzA."""
    times, limits = report.figures.intervals, report.figures.limits["tza"].limits_s
    if not times.bins:
        return None

    def draw(figure: SubFigure | Figure) -> None:
        axes = figure.subplots()
        counts, edges = _bars(times)
        axes.stairs(counts, edges, fill=True, color=COLOURS["command"])
        axes.set(xscale="log", yscale="log", ylabel="intervals")
        axes.set_ylim(0.5, 5 * max(counts))
        _ms_axis(axes, [*edges, *limits], "ms from character to character in a telegram")
        for limit_s in limits:
            _limit(axes, limit_s, "TzA")

    return Drawing("Intervals between characters", _NARROW_IN, 3.2, draw)


def _bars(times: Distribution) -> tuple[list[int], list[float]]:
    """Join bins to bars without a gap; give their counts and edges in s."""
    first, last = min(times.bins) // _JOINED, max(times.bins) // _JOINED
    counts = [0] * (last - first + 1)
    for number, found in times.bins.items():
        counts[number // _JOINED - first] += found.count
    return counts, [times.edge_s(number * _JOINED) for number in range(first, last + 2)]


def _limit(axes: Axes, limit_s: float, name: str) -> None:
    axes.axvline(limit_s, color=COLOURS["bad"], linewidth=1.5, linestyle="--")
    axes.annotate(
        f"{name} {limit_s * 1e3:g} ms",
        (limit_s, 1.0),
        (3, -2),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        color=COLOURS["bad"],
        va="top",
    )


def _ms_axis(axes: Axes, shown_s: Sequence[float], label: str) -> None:
    """Make a logarithmic time axis that has at least a decade, so that it has numbers."""
    low, high = min(shown_s), max(shown_s)
    middle, half = math.sqrt(low * high), max(math.sqrt(high / low) * 1.3, 10**0.6)
    axes.set_xlim(middle / half, middle * half)
    axes.set_xlabel(label)
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if half < 30 else (1.0,)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda time_s, _: f"{time_s * 1e3:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def reactions(report: Report) -> Drawing | None:
    """Reaction times of each service, with TrS."""
    found = {number: service for number, service in report.figures.services.items() if service.times.bins}
    busiest = sorted(sorted(found, key=lambda number: -found[number].times.count)[:_LANES])
    if not busiest:
        return None

    def draw(figure: SubFigure | Figure) -> None:
        axes = figure.subplots()
        axes.set_xscale("log")
        shown: list[float] = []
        for lane, number in enumerate(busiest):
            service = found[number]
            counts, edges = _bars(service.times)
            heights = [0.5 * count / max(counts) - lane for count in counts]
            axes.stairs(heights, edges, baseline=-lane, fill=True, color=COLOURS["reaction"])
            axes.plot(service.times.within_s(0.5), -lane, "o", color=COLOURS["ink"], markersize=4)
            _strokes(axes, service.trs.limits_s, -lane, 0.5, _RED)
            shown += [*edges, *service.trs.limits_s]
            name = f"0x{number:02x} {service_name(number)}"
            axes.text(0, 0.55 - lane, name, transform=axes.get_yaxis_transform(), va="bottom", size=9)
        _name_lanes(axes, [""] * len(busiest))
        _ms_axis(axes, shown, "ms from command to reaction; dot: half of them, red: TrS")

    return Drawing("Reaction times by service", _NARROW_IN, max(1.2 + 0.55 * len(busiest), 2.0), draw)


def values(report: Report) -> Drawing | None:
    """The values that moved, a small picture each, with the limits of the parameter."""
    moved = report.figures.curves.moved()
    shown = [listed for listed in report.figures.parameters if listed.parameter in set(list(moved)[:_CURVES])]
    if not shown:
        return None
    lines = math.ceil(len(shown) / _CURVES_IN_A_ROW)

    def draw(figure: SubFigure | Figure) -> None:
        grid = figure.subplots(lines, _CURVES_IN_A_ROW, squeeze=False, sharex=True).flatten()
        for axes, listed in zip(grid, shown, strict=False):
            _draw_curve(axes, moved[listed.parameter], listed, report.figures.duration_s)
        for axes in grid[len(shown) :]:
            axes.set_axis_off()
        for axes in grid[max(len(shown) - _CURVES_IN_A_ROW, 0) : len(shown)]:
            axes.tick_params(labelbottom=True)
            axes.set_xlabel("seconds", size=8)

    rest = len(moved) - len(shown)
    title = "Values that moved" + (f" (and {rest} more)" if rest else "")
    return Drawing(title, _WIDE_IN, 0.5 + 1.7 * lines, draw)


def _draw_curve(axes: Axes, curve: Curve, listed: Listed, duration_s: float) -> None:
    """Draw a line where values came one after the other, with its least and greatest where they are joined."""
    for piece in curve.pieces(duration_s):
        points = [point for found in piece for point in _corners(found)]
        marker = "|" if len(points) <= _FEW else ""
        axes.plot(*zip(*points, strict=True), color=COLOURS["reaction"], linewidth=1.0, marker=marker, markersize=4)
    written = [(point.end_s, point.last) for point in curve.points if point.is_written]
    if written:
        axes.plot(*zip(*written, strict=True), "o", color=COLOURS["command"], markersize=3)
    _draw_value_limits(axes, curve, (listed.minimum, listed.maximum))
    axes.set_xlim(0, duration_s or None)
    axes.tick_params(labelsize=8)
    axes.set_title("\n".join(_curve_title(listed)), size=8, loc="left")


def _curve_title(listed: Listed) -> Iterator[str]:
    yield f"{listed.parameter.ident} {listed.name}{f' in {listed.unit}' if listed.unit else ''}"
    yield of_device(listed.parameter)
    limits = {"least": listed.minimum, "most": listed.maximum}
    yield ", ".join(f"at {name} {text}" for name, text in limits.items() if text)


def _corners(point: Point) -> list[tuple[float, float]]:
    if point.begin_s == point.end_s:
        return [(point.begin_s, point.last)]
    middle_s = (point.begin_s + point.end_s) / 2
    inside = [(middle_s, point.least), (middle_s, point.greatest)]
    return [(point.begin_s, point.first), *inside, (point.end_s, point.last)]


def _draw_value_limits(axes: Axes, curve: Curve, texts: Sequence[str]) -> None:
    """Draw minimum and maximum, but for those beside which the values would be a flat line."""
    least = min(point.least for point in curve.points)
    greatest = max(point.greatest for point in curve.points)
    far = _FAR * (greatest - least)
    for text in texts:
        found = re.match(r"-?\d+(\.\d+)?(e[-+]\d+)?(?![\dx])", text)
        if found and least - far <= float(found[0]) <= greatest + far:
            axes.axhline(float(found[0]), color=COLOURS["bad"], linewidth=1.0, linestyle="--")


def window(shown: Window) -> Drawing | None:
    """A stretch of the bus in full detail: every telegram a bar, every character a stroke."""
    lanes = sorted({_lane(packet) for packet in shown.packets})
    if not lanes:
        return None

    def draw(figure: SubFigure | Figure) -> None:
        axes = figure.subplots()
        for packet in shown.packets:
            _draw_packet(axes, packet, -lanes.index(_lane(packet)), shown)
        _name_lanes(axes, [_lane_name(lane) for lane in lanes])
        axes.set_xlim(0, (shown.end_s - shown.start_s) * 1e3)
        axes.xaxis.set_major_locator(MaxNLocator(8))
        axes.set_xlabel(f"ms after {shown.start_s:.6f} s")
        keys = {"command": "command", "reaction": "reaction", "other": "other characters", "bad": "exceeded or wrong"}
        handles = [Patch(color=COLOURS[role], label=name) for role, name in keys.items()]
        # Above the axes, in words that matplotlib 3.6 (Debian 12) has.
        axes.legend(
            handles=handles, loc="lower right", bbox_to_anchor=(1, 1), ncols=len(keys), fontsize=9, handlelength=1.2
        )

    return Drawing(shown.title, _WIDE_IN, 1.3 + 0.6 * len(lanes), draw)


_NO_STATION = 256  # the lane under those of all addresses


def _lane(packet: Packet) -> int:
    talker = packet.telegrams[0].talker if packet.telegrams else None
    return _NO_STATION if talker is None else talker


def _lane_name(lane: int) -> str:
    return "no station" if lane == _NO_STATION else f"station {lane}"


def _draw_packet(axes: Axes, packet: Packet, base: float, shown: Window) -> None:
    telegram = packet.telegrams[0] if packet.telegrams else None
    times = [(packet.time_s - shown.start_s) * 1e3]
    for interval_s in packet.intervals_s:
        times.append(times[-1] + interval_s * 1e3)
    role = "other" if telegram is None else "reaction" if telegram.is_reaction else "command"
    axes.broken_barh([(times[0], times[-1] - times[0])], (base, 0.6), facecolors=COLOURS[role], alpha=0.55)
    has_room = len(shown.packets) <= _LABELS
    _strokes(axes, times, base, 0.6, Pen("ink", 0.6 if has_room else 0.25))
    if has_room and 0 <= times[0] <= _LABELLED * (shown.end_s - shown.start_s) * 1e3:
        axes.text(times[0], base + 0.62, str(packet.number), size=8, va="bottom", clip_on=True)
    if telegram:
        _mark_exceeded(axes, packet, telegram, base, times)


def _mark_exceeded(axes: Axes, packet: Packet, telegram: Telegram, base: float, times: Sequence[float]) -> None:
    """Draw red what the dissector judged exceeded or wrong."""
    for index, time_s in _exceeded(packet, telegram).items():
        axes.broken_barh([(times[index - 1], times[index] - times[index - 1])], (base, 0.6), color=COLOURS["bad"])
        _say(axes, times[index - 1], base, ms(time_s))
    if telegram.reaction and telegram.reaction.verdict == EXCEEDED:
        begin = times[0] - telegram.reaction.time_s * 1e3
        axes.broken_barh([(begin, times[0] - begin)], (base + 0.2, 0.2), color=COLOURS["bad"])
        _say(axes, max(begin, 0.0), base, ms(telegram.reaction.time_s))
    words = {"no reaction": telegram.unanswered, "damaged": not telegram.good}
    said = ", ".join(word for word, applies in words.items() if applies)
    if said:
        axes.broken_barh(
            [(times[0], times[-1] - times[0])], (base, 0.6), facecolors="none", edgecolors=COLOURS["bad"], linewidth=2
        )
        axes.annotate(
            said, (times[-1], base + 0.3), (4, 0), textcoords="offset points", color=COLOURS["bad"], va="center"
        )


def _say(axes: Axes, at_ms: float, base: float, text: str) -> None:
    axes.text(at_ms, base - 0.02, text, size=8, va="top", color=COLOURS["bad"], clip_on=True)


def _exceeded(packet: Packet, telegram: Telegram) -> dict[int, float]:
    """Return the pauses that were too long, in s, by the character after them, counted from 0.

    The dissector names the longest. Others of the same telegram are certain only where each character has a read, and
    so a time, of its own.
    """
    pause = telegram.pause
    if pause is None or pause.limit_s is None or pause.verdict != EXCEEDED:
        return {}
    least_s = pause.limit_s + (packet.uncertainty_s or 0.0)
    found = {}
    if not packet.same_read:
        found = {index: time_s for index, time_s in enumerate(packet.intervals_s, 1) if time_s > least_s}
    if telegram.pause_position and 1 < telegram.pause_position <= len(packet.intervals_s) + 1:
        found[telegram.pause_position - 1] = pause.time_s
    return found


def drawings(report: Report) -> list[Drawing]:
    """Return all pictures that the capture has something for."""
    made = [overview(report), *map(window, report.windows), intervals(report), reactions(report), values(report)]
    return [drawing for drawing in made if drawing]


def svg_for_page(drawing: Drawing, name: str) -> str:
    """Draw one picture as an element of a page: its colours are variables of the page, its ids begin with `name`."""
    with matplotlib.rc_context(_SETTINGS | {"figure.facecolor": "none"}):
        figure = Figure(figsize=(drawing.width_in, drawing.height_in), layout="constrained")
        drawing.draw(figure)
        text = _saved(figure, "svg").decode()
    text = text[text.index("<svg") :]
    for role, colour in COLOURS.items():
        text = text.replace(colour, f"var(--{role})")
    text = re.sub(r' id="', f' id="{name}-', text)
    text = re.sub(r'(url\(#|href="#)', rf"\g<1>{name}-", text)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    return re.sub(r"<svg ", '<svg role="img" ', text, count=1)


def picture(report: Report, kind: str) -> bytes:
    """Draw everything into one PNG or SVG file, on white."""
    made = drawings(report)
    with matplotlib.rc_context(_SETTINGS):
        heights = [drawing.height_in + 0.4 for drawing in made]
        figure = Figure(figsize=(_WIDE_IN, sum(heights) + 0.6), layout="constrained", dpi=150)
        figure.suptitle(report.name)
        rows = figure.subfigures(max(len(made), 1), 1, height_ratios=heights or [1.0], squeeze=False)[:, 0]
        for row, drawing in zip(rows, made, strict=False):
            row.suptitle(drawing.title, x=0.01, ha="left", size=11)
            drawing.draw(row)
        return _saved(figure, kind)


def _saved(figure: Figure, kind: str) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind, metadata={"Date": None} if kind == "svg" else None)
    return buffer.getvalue()
