# SPDX-License-Identifier: GPL-2.0-or-later
"""The pictures of a report. What was counted in bins is drawn from bins."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from sistap.commands.report import curved
from sistap.commands.report.curves import Curve, CurvePoint
from sistap.commands.report.gather import Report
from sistap.commands.report.tables import ANCHOR, EPISODES_SHOWN, before, of_device
from sistap.commands.report.windows import ReportWindow
from sistap.dissected.accesses.listing import Listed
from sistap.dissected.draw.panel import (
    Area,
    Axis,
    Bar,
    Dots,
    Drawing,
    Mark,
    Panel,
    Polyline,
    Strokes,
    Text,
    Tick,
    linear,
    logarithmic,
    milliseconds,
    times_of_day,
)
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.packets.dissection import EXCEEDED, Packet, Telegram
from sistap.dissected.packets.distribution import Distribution, Slices
from sistap.tap.records.record import ms
from sistap.tap.sis.faults import FAULTS
from sistap.tap.sis.limits import limit_text
from sistap.tap.sis.telegram import service_name

_LANES = 12  # the busiest stations and services; more would not be readable
_LABELS = 24  # packet numbers in a window
_LABELLED = 0.97  # of its width: a number at the right edge would be cut
_FEW = 40  # points, each of which is drawn
_FAR = 2.0  # times the span of the values: a limit farther away is not drawn
_WIDE_IN, _NARROW_IN = 10.0, 5.2
_RED_PT = 1.5
_LANE_IN = 0.25  # of the timeline: with the answer it has to fit on the screen of a laptop
_THIN = 0.12  # a drift lasts as long as the capture: what is beside it has to be seen
_STANDING = {"stopped", "off"}  # behind all lanes
_PALE = 0.18
_LEAST_SHOWN = 0.003  # of the width: a shorter episode could not be seen


def timeline(report: Report) -> Drawing | None:
    """Every episode, in the lanes of its stations; a machine that stands, behind all of them."""
    if not report.episodes:
        return None
    begin_s = min(report.figures.first_epoch_s or 0.0, *(one.from_s for one in report.episodes))
    end_s = max(begin_s + report.figures.duration_s, *(one.to_s for one in report.episodes))
    stations = sorted({station for one in report.episodes for station in one.stations})
    lanes: list[int | None] = [None, *stations][: 2 * _LANES]

    def draw() -> list[list[Panel]]:
        panel = Panel(x=times_of_day(begin_s, end_s))
        least_s = (end_s - begin_s) * _LEAST_SHOWN
        shown = list(enumerate(report.episodes[:EPISODES_SHOWN]))
        for number, one in sorted(shown, key=lambda each: each[1].kind not in _STANDING):
            lasts = one.to_s - one.from_s > least_s
            role = "bad" if one.severity >= Severity.WARNING else "other"
            base, height, opacity = 0.0, _height(one), 0.5 if lasts else 1.0
            own: list[int | None] = [*one.stations] if one.stations else [None]
            of = [lanes.index(lane) for lane in own if lane in lanes]
            if one.kind in _STANDING:
                of, base, height, opacity = [len(lanes) - 1], -0.1, len(lanes) * 1.0, _PALE
            for lane in of:
                at = base - lane, height, role, opacity
                until_s, link = max(one.to_s, one.from_s + least_s), f"#{ANCHOR}{number}"
                panel.add(Bar(one.from_s, until_s, *at, link=link, tip=one.text))
        panel.name_lanes(["the bus" if lane is None else f"station {lane}" for lane in lanes])
        return [[panel]]

    return Drawing("What happened when", _WIDE_IN, 0.35 + _LANE_IN * len(lanes), draw)


def _height(episode: Episode) -> float:
    if episode.kind == "drift":
        return _THIN
    return 0.8 if episode.severity == Severity.ERROR else 0.45


def overview(report: Report) -> Drawing | None:
    """The bus over the whole capture: load, what each station sent, where the faults are."""
    slices, counts_of = report.figures.slices, report.figures.faults
    busiest = sorted(report.figures.stations, key=lambda address: -sum(slices.counts[str(address)]))[:_LANES]
    stations = [(f"station {address}", slices.counts[str(address)]) for address in sorted(busiest)]
    faults = [(fault.short, slices.counts[fault.name]) for fault in FAULTS if counts_of[fault.name]]
    has_load = any(load is not None for load in slices.loads)
    if not stations and not faults:
        return None

    def draw() -> list[list[Panel]]:
        end_s = slices.used * slices.width_s
        lower = Panel(x=linear(0, end_s, 8), height=0.5 + (len(stations) + len(faults)) * 0.5)
        lower.x.label = f"seconds since the first packet; a step is {slices.width_s:g} s"
        for lane, (_, counts) in enumerate(stations):
            most = max(counts) or 1
            lower.add(_steps(counts[: slices.used], slices.width_s, -lane, 0.8 / most))
        for lane, (_, counts) in enumerate(faults, len(stations)):
            times = [(number + 0.5) * slices.width_s for number, count in enumerate(counts) if count]
            lower.add(Strokes(times, -lane, 0.8, "bad", _RED_PT))
        lower.name_lanes([name for name, _ in stations + faults])
        if not has_load:
            return [[lower]]
        upper = Panel(x=Axis(0, end_s), y=linear(0, 100, 4, "bus load\nin %"), height=2.0)
        upper.add(Area(_load(slices), 0.0, "other"))
        return [[upper], [lower]]

    return Drawing("The whole capture", _WIDE_IN, 1.0 + 1.3 * has_load + 0.33 * (len(stations) + len(faults)), draw)


def _load(slices: Slices) -> list[tuple[float, float]]:
    """Return times and percent of the load. It is that of the last second: a second after a telegram it is 0."""
    points: list[tuple[float, float]] = []
    for number, percent in enumerate(slices.loads):
        if percent is None:
            continue
        time_s = number * slices.width_s
        if points and time_s - points[-1][0] > 1 + slices.width_s:
            points += [(points[-1][0] + 1, 0.0), (time_s, 0.0)]
        points.append((time_s, percent))
    return points


def _steps(values: Sequence[float], width: float, base: float, scale: float) -> Area:
    """Return the area under steps that begin at x = 0."""
    return Area(
        _corners_of([base + value * scale for value in values], [n * width for n in range(len(values) + 1)]),
        base,
        "command",
    )


def _corners_of(heights: Sequence[float], edges: Sequence[float]) -> list[tuple[float, float]]:
    """Return the upper corners of steps."""
    return [
        corner
        for height, begin, end in zip(heights, edges, edges[1:], strict=False)
        for corner in ((begin, height), (end, height))
    ]


def intervals(report: Report) -> Drawing | None:
    """How often each interval between the characters of a telegram came, with TzA."""
    times, limits = report.figures.pauses.intervals, report.figures.limits["tza"].limits_s
    if not times.bins:
        return None

    def draw() -> list[list[Panel]]:
        counts, edges = times.bars()
        x = milliseconds([*edges, *limits], "ms from character to character in a telegram")
        panel = Panel(x=x, y=logarithmic(0.5, 5 * max(counts), "intervals"))
        panel.add(Area(_corners_of([max(count, 0.5) for count in counts], edges), 0.5, "command"))
        for limit_s in limits:
            top = panel.y.high
            panel.add(Polyline([(limit_s, 0.5), (limit_s, top)], "bad", _RED_PT, is_dashed=True))
            panel.add(Text(limit_s, top, f"TzA {limit_text(limit_s)}", "bad", 10, up=-10, right=3))
        return [[panel]]

    return Drawing("Intervals between characters", _NARROW_IN, 3.2, draw, is_wide=False)


def reactions(report: Report) -> Drawing | None:
    """Reaction times of each service, with TrS."""
    found = {number: service for number, service in report.figures.services.items() if service.times.bins}
    busiest = sorted(sorted(found, key=lambda number: -found[number].times.count)[:_LANES])
    if not busiest:
        return None
    lanes = [
        _Lane(f"0x{number:02x} {service_name(number)}", found[number].times, found[number].trs.limits_s)
        for number in busiest
    ]
    return _histograms("Reaction times by service", "ms from command to reaction; dot: half of them, red: TrS", lanes)


def pauses_by_talker(report: Report) -> Drawing | None:
    """How often each longest interval of a telegram came, by talker and rate."""
    talkers = report.figures.pauses.talkers
    lanes = [
        _Lane(f"station {talker.station}{f', {talker.baud} Bd' if talker.baud else ''}", one.times, one.limits_s)
        for talker, one in sorted(talkers.items())
        if one.times.bins
    ]
    label = "ms, longest interval of each telegram; dot: half of them, red: TzA"
    return _histograms("Longest interval in a telegram, by talker", label, lanes[: 2 * _LANES])


def pauses_by_place(report: Report) -> Drawing | None:
    """How often each interval came before each character of a telegram."""
    limits_s = report.figures.limits["tza"].limits_s
    lanes = [
        _Lane(f"before character {before(place)}", times, limits_s)
        for place, times in report.figures.pauses.places.items()
        if times.bins
    ]
    return _histograms("Intervals by place in the telegram", "ms; dot: half of them, red: TzA", lanes)


class _Lane(NamedTuple):
    """Times with their limits."""

    name: str
    times: Distribution
    limits_s: Iterable[float]


def _histograms(title: str, label: str, lanes: Sequence[_Lane]) -> Drawing | None:
    """Draw how often each time came, a lane each."""
    if not lanes:
        return None

    def draw() -> list[list[Panel]]:
        panel = Panel()
        shown: list[float] = []
        for number, lane in enumerate(lanes):
            counts, edges = lane.times.bars()
            most = math.log1p(max(counts))  # logarithmic: one in a million is what somebody looks for
            heights = [0.5 * math.log1p(count) / most - number for count in counts]
            panel.add(Area(_corners_of(heights, edges), -number, "reaction"))
            panel.add(Dots([(lane.times.within_s(0.5), -number)], "ink", 4))
            panel.add(Strokes(list(lane.limits_s), -number, 0.5, "bad", _RED_PT))
            shown += [*edges, *lane.limits_s]
            panel.add(Text(0, 0.55 - number, lane.name, size_pt=9, in_front=True))
        panel.name_lanes([""] * len(lanes))
        panel.x = milliseconds(shown, label)
        return [[panel]]

    return Drawing(title, _NARROW_IN, max(1.2 + 0.55 * len(lanes), 2.0), draw, is_wide=False)


def values(report: Report) -> list[Drawing]:
    """The values that moved, a picture each, with the limits of the parameter and what happened to it."""
    return [_curve_of(report, listed) for listed in curved.parameters(report)]


def _curve_of(report: Report, listed: Listed) -> Drawing:
    def draw() -> list[list[Panel]]:
        curve = report.figures.curves.moved()[listed.parameter]
        panel = _curve(curve, listed, report.figures.duration_s)
        begin_s = report.figures.first_epoch_s or 0.0
        panel.x = times_of_day(begin_s, begin_s + report.figures.duration_s).since(begin_s)
        for number in curved.happened(report, listed.parameter):
            _mark_episode(panel, report.episodes[number], begin_s, f"#{ANCHOR}{number}")
        return [[panel]]

    return Drawing(f"{listed.parameter.ident} {listed.name}".strip(), _NARROW_IN, 2.2, draw, is_wide=False)


def _mark_episode(panel: Panel, episode: Episode, begin_s: float, link: str) -> None:
    """Shade the time of an episode, behind the curve."""
    from_s, to_s = episode.from_s - begin_s, episode.to_s - begin_s
    until_s = max(to_s, from_s + (panel.x.high - panel.x.low) * _LEAST_SHOWN)
    role, y = "bad" if episode.severity >= Severity.WARNING else "other", panel.y
    bar = Bar(from_s, until_s, y.low, y.high - y.low, role, 0.25, link=link, tip=episode.text)
    if episode.kind == "drift":
        bar = bar._replace(height=bar.height * _THIN)
    panel.marks.insert(0, bar)


def _curve(curve: Curve, listed: Listed, duration_s: float) -> Panel:
    """Return a line where values came one after the other, with its least and greatest where they are joined."""
    marks: list[Mark] = []
    for piece in curve.pieces(duration_s):
        points = [point for found in piece for point in _corners(found)]
        marks.append(Polyline(points, "reaction", has_ticks=len(points) <= _FEW))
    written = [(point.end_s, point.last) for point in curve.points if point.is_written]
    marks.append(Dots(written, "command", 3))
    limits = list(_value_limits(curve, (listed.minimum, listed.maximum)))
    marks += [Polyline([(0, limit), (duration_s, limit)], "bad", is_dashed=True) for limit in limits]
    found = [value for point in curve.points for value in (point.least, point.greatest)] + limits
    margin = (max(found) - min(found)) * 0.05
    y = linear(min(found) - margin, max(found) + margin, 4)
    if listed.last.startswith("0x"):
        y.ticks = _hexadecimal(found, (y.high - y.low) / 10)
    return Panel(y=y, marks=marks, title=list(_curve_title(listed)), size_pt=8)


def _hexadecimal(values: Sequence[float], apart: float) -> list[Tick]:
    """Return a number at each value: between two diagnoses there is nothing."""
    ticks: list[Tick] = []
    for value in sorted(set(values)):
        if not ticks or value - ticks[-1].value >= apart:
            ticks.append(Tick(value, f"{round(value):X}"))
    return ticks


def _curve_title(listed: Listed) -> Iterator[str]:
    yield f"{listed.parameter.ident} {listed.name}{f' in {listed.unit}' if listed.unit else ''}"
    yield of_device(listed.parameter)
    limits = {"least": listed.minimum, "most": listed.maximum}
    yield ", ".join(f"at {name} {text}" for name, text in limits.items() if text)


def _corners(point: CurvePoint) -> list[tuple[float, float]]:
    if point.begin_s == point.end_s:
        return [(point.begin_s, point.last)]
    middle_s = (point.begin_s + point.end_s) / 2
    inside = [(middle_s, point.least), (middle_s, point.greatest)]
    return [(point.begin_s, point.first), *inside, (point.end_s, point.last)]


def _value_limits(curve: Curve, texts: Sequence[str]) -> Iterator[float]:
    """Yield minimum and maximum, but for those beside which the values would be a flat line."""
    least = min(point.least for point in curve.points)
    greatest = max(point.greatest for point in curve.points)
    far = _FAR * (greatest - least)
    for text in texts:
        found = re.match(r"-?\d+(\.\d+)?(e[-+]\d+)?(?![\dx])", text)
        if found and least - far <= float(found[0]) <= greatest + far:
            yield float(found[0])


_KEY = (("command", "command"), ("reaction", "reaction"), ("other", "other characters"), ("bad", "exceeded or wrong"))


def window(shown: ReportWindow) -> Drawing | None:
    """A stretch of the bus in full detail: every telegram a bar, every character a stroke."""
    lanes = sorted({_lane(packet) for packet in shown.packets})
    if not lanes:
        return None

    def draw() -> list[list[Panel]]:
        x = linear(0, (shown.end_s - shown.start_s) * 1e3, 8, f"ms after {shown.start_s:.6f} s")
        panel = Panel(x=x, key=_KEY)
        for packet in shown.packets:
            _draw_packet(panel, packet, -lanes.index(_lane(packet)), shown)
        panel.name_lanes(["no station" if lane == _NO_STATION else f"station {lane}" for lane in lanes])
        return [[panel]]

    return Drawing(shown.title, _WIDE_IN, 1.3 + 0.6 * len(lanes), draw)


_NO_STATION = 256  # the lane under those of all addresses


def _lane(packet: Packet) -> int:
    talker = packet.telegrams[0].talker if packet.telegrams else None
    return _NO_STATION if talker is None else talker


def _draw_packet(panel: Panel, packet: Packet, base: float, shown: ReportWindow) -> None:
    telegram = packet.telegrams[0] if packet.telegrams else None
    times = [(packet.time_s - shown.start_s) * 1e3]
    for interval_s in packet.intervals_s:
        times.append(times[-1] + interval_s * 1e3)
    role = "other" if telegram is None else "reaction" if telegram.is_reaction else "command"
    has_room = len(shown.packets) <= _LABELS
    panel.add(Bar(times[0], times[-1], base, 0.6, role, 0.55))
    panel.add(Strokes(times, base, 0.6, "ink", 0.6 if has_room else 0.25))
    if has_room and 0 <= times[0] <= _LABELLED * (shown.end_s - shown.start_s) * 1e3:
        panel.add(Text(times[0], base + 0.6, str(packet.number), up=2))
    if telegram:
        _mark_exceeded(panel, packet, telegram, base, times)


def _mark_exceeded(panel: Panel, packet: Packet, telegram: Telegram, base: float, times: Sequence[float]) -> None:
    """Draw red what the dissector judged exceeded or wrong."""
    for index, time_s in _exceeded(packet, telegram).items():
        panel.add(Bar(times[index - 1], times[index], base, 0.6, "bad"))
        panel.add(_say(times[index - 1], base, ms(time_s)))
    if telegram.reaction and telegram.reaction.verdict == EXCEEDED:
        begin = times[0] - telegram.reaction.time_s * 1e3
        panel.add(Bar(begin, times[0], base + 0.2, 0.2, "bad"))
        panel.add(_say(max(begin, 0.0), base, ms(telegram.reaction.time_s)))
    words = {"no reaction": telegram.unanswered, "damaged": not telegram.good}
    said = ", ".join(word for word, applies in words.items() if applies)
    if said:
        panel.add(Bar(times[0], times[-1], base, 0.6, "bad", is_outline=True))
        panel.add(Text(times[-1], base + 0.3, said, "bad", 10, up=-3, right=4))


def _say(at_ms: float, base: float, text: str) -> Text:
    return Text(at_ms, base, text, "bad", up=-9)


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
    made = [
        timeline(report),
        overview(report),
        *map(window, report.windows),
        intervals(report),
        reactions(report),
        pauses_by_talker(report),
        pauses_by_place(report),
        *values(report),
    ]
    return [drawing for drawing in made if drawing]
