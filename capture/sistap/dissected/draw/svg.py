# SPDX-License-Identifier: GPL-2.0-or-later
"""Draws pictures as SVG: their colours are variables, which a page or a style sets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from html import escape

from sistap.dissected.draw.panel import (
    COLOURS,
    Area,
    Axis,
    Bar,
    Dots,
    Drawing,
    Mark,
    Panel,
    Points,
    Polyline,
    Strokes,
    Text,
    Tick,
)

POINTS = 72.0  # in an inch
_GAP = 10.0
_WORD = 0.6  # width of a letter of size 1
_MIDDLE = ' text-anchor="middle"'
_END = ' text-anchor="end"'
_NEAR_THE_EDGE = 0.98  # of the width of an axis
_FONT = "DejaVu Sans, Verdana, Arial, sans-serif"


class _Box:
    """Where a panel's data are drawn, in points from the upper left."""

    def __init__(self, panel: Panel, left: float, top: float, width: float, height: float) -> None:
        self.panel, self.left, self.top, self.width, self.height = panel, left, top, width, height

    @property
    def right(self) -> float:
        return self.left + self.width

    @property
    def bottom(self) -> float:
        return self.top + self.height

    def x(self, value: float) -> float:
        return self.left + _near(self.panel.x.place(value)) * self.width

    def y(self, value: float) -> float:
        return self.bottom - _near(self.panel.y.place(value)) * self.height


def _near(place: float) -> float:
    """Keep what is far outside from making long numbers."""
    return min(max(place, -10.0), 10.0)


def svg(drawing: Drawing, name: str) -> str:
    """Draw a picture as an element; its ids begin with `name`."""
    width, height = drawing.width_in * POINTS, drawing.height_in * POINTS
    inside = "".join(_rows(drawing.draw(), name, width, height))
    return (
        f'<svg role="img" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}" height="{height:.0f}" '
        f'font-family="{_FONT}" xmlns="http://www.w3.org/2000/svg">{inside}</svg>'
    )


def stacked(title: str, drawings: Sequence[Drawing]) -> str:
    """Draw pictures below each other into a file, on white."""
    colours = "".join(f"--{role}: {colour}; " for role, colour in COLOURS.items())
    width = max((drawing.width_in for drawing in drawings), default=1.0) * POINTS
    parts = [_words((0, 18), title, 14)]
    top = 30.0
    for number, drawing in enumerate(drawings):
        parts += [_words((0, top + 12), drawing.title, 11), f'<g transform="translate(0 {top + 20:.0f})">']
        parts += [svg(drawing, f"picture{number}"), "</g>"]
        top += 28 + drawing.height_in * POINTS
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{top:.0f}" '
        f'viewBox="0 0 {width:.0f} {top:.0f}" style="{colours}background: white">'
    )
    return "\n".join(['<?xml version="1.0" encoding="utf-8"?>', head, *parts, "</svg>\n"])


def _rows(rows: Sequence[Sequence[Panel]], name: str, width: float, height: float) -> Iterator[str]:
    panels = [panel for row in rows for panel in row]
    left = max((_margin(panel) for panel in panels), default=0.0)
    total = sum(max((panel.height for panel in row), default=0.0) for row in rows)
    fixed = sum(_above(row) + _below(row) for row in rows)
    top = 0.0
    number = 0
    for row in rows:
        share = (height - fixed) * max(panel.height for panel in row) / total
        step = width / len(row)
        for place, panel in enumerate(row):
            box = _Box(panel, place * step + left, top + _above(row), step - left - _GAP, share)
            yield from _panel(box, f"{name}-{number}")
            number += 1
        top += _above(row) + share + _below(row)


def _margin(panel: Panel) -> float:
    """Return the room for the numbers, or names, at the left."""
    longest = max((len(tick.words) for tick in panel.y.ticks), default=0)
    label = panel.size_pt * 1.6 * (panel.y.label.count("\n") + 1) if panel.y.label else 0.0
    return longest * panel.size_pt * _WORD + label + 8


def _above(row: Sequence[Panel]) -> float:
    return max((len(panel.title) * 10.0 + (16.0 if panel.key else 0.0) + 4.0 for panel in row), default=4.0)


def _below(row: Sequence[Panel]) -> float:
    return max(
        ((panel.size_pt * 1.5 if panel.x.ticks else 0.0) + (panel.size_pt * 1.5 if panel.x.label else 0.0) + 4.0)
        for panel in row
    )


def _panel(box: _Box, name: str) -> Iterator[str]:
    panel = box.panel
    yield (
        f'<clipPath id="{name}"><rect x="{box.left:.1f}" y="{box.top - 2:.1f}" width="{box.width:.1f}" '
        f'height="{box.height + 4:.1f}"/></clipPath>'
    )
    for lane in range(panel.lanes):
        yield _path([(box.left, box.y(-lane)), (box.right, box.y(-lane))], "line", 0.5)
    yield f'<g clip-path="url(#{name})">'
    for mark in panel.marks:
        yield from _mark(box, mark)
    yield "</g>"
    for mark in panel.marks:
        if isinstance(mark, Text):
            yield from _text(box, mark)
    yield from _x_axis(box)
    yield from _y_axis(box)
    for line, words in enumerate(panel.title):
        yield _words((box.left, box.top - 4 - 10 * (len(panel.title) - 1 - line)), words, 8)
    yield from _key(box)


def _mark(box: _Box, mark: Mark) -> Iterator[str]:
    match mark:
        case Area(points, base, role):
            corners = [(points[0][0], base), *points, (points[-1][0], base)]
            yield f'<path d="{_d(box, corners)}z" fill="var(--{role})"/>'
        case Bar(begin, end, base, height, role, opacity, is_outline, link, tip):
            left, top = box.x(begin), box.y(base + height)
            width, tall = box.x(end) - left, box.y(base) - top
            paint = f'fill="none" stroke="var(--{role})" stroke-width="2"' if is_outline else f'fill="var(--{role})"'
            see = f' opacity="{opacity:g}"' if opacity < 1 else ""
            said = f"<title>{escape(tip)}</title>" if tip else ""
            shape = (
                f'<rect x="{left:.2f}" y="{top:.2f}" width="{width:.2f}" height="{tall:.2f}" {paint}{see}>{said}</rect>'
            )
            yield f'<a href="{escape(link)}">{shape}</a>' if link else shape
        case Strokes(at, base, height, role, width_pt):
            low, up = box.y(base), box.y(base + height) - box.y(base)
            d = "".join(f"M{box.x(value):.2f} {low:.2f}v{up:.2f}" for value in at)
            if d:
                yield f'<path d="{d}" fill="none" stroke="var(--{role})" stroke-width="{width_pt:g}"/>'
        case Polyline(points, role, width_pt, is_dashed, has_ticks):
            yield _path([(box.x(x), box.y(y)) for x, y in points], role, width_pt, is_dashed=is_dashed)
            if has_ticks:
                d = "".join(f"M{box.x(x):.2f} {box.y(y) - 2:.2f}v4" for x, y in points)
                yield f'<path d="{d}" fill="none" stroke="var(--{role})" stroke-width="1"/>'
        case Dots(points, role, size_pt) if points:
            d = "".join(f"M{box.x(x):.1f} {box.y(y):.1f}h0" for x, y in points)
            look = f'stroke-width="{size_pt:g}" stroke-linecap="round"'
            yield f'<path d="{d}" fill="none" stroke="var(--{role})" {look}/>'


def _text(box: _Box, text: Text) -> Iterator[str]:
    """Draw words whose place is inside; they may be longer."""
    if text.in_front or 0 <= box.panel.x.place(text.x) <= 1:
        left = box.left if text.in_front else box.x(text.x)
        yield _words((left + text.right, box.y(text.y) - text.up), text.words, text.size_pt, text.role)


def _d(box: _Box, points: Points) -> str:
    return "M" + "L".join(f"{box.x(x):.2f} {box.y(y):.2f}" for x, y in points)


def _path(points: Points, role: str, width_pt: float, *, is_dashed: bool = False) -> str:
    d = "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in points)
    dash = ' stroke-dasharray="5 3"' if is_dashed else ""
    return f'<path d="{d}" fill="none" stroke="var(--{role})" stroke-width="{width_pt:g}"{dash}/>'


def _words(at: tuple[float, float], words: str, size_pt: float, role: str = "ink", more: str = "") -> str:
    x, y = at
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size_pt:g}" fill="var(--{role})"{more}>{escape(words)}</text>'


def _x_axis(box: _Box) -> Iterator[str]:
    panel = box.panel
    size = panel.size_pt
    yield _path([(box.left, box.bottom), (box.right, box.bottom)], "line", 0.8)
    for tick in _inside(panel.x):
        at = box.x(tick.value)
        yield _path([(at, box.bottom), (at, box.bottom + 3)], "line", 0.8)
        more = _END if panel.x.place(tick.value) > _NEAR_THE_EDGE else _MIDDLE  # else the words would be cut
        yield _words((at, box.bottom + size * 1.3), tick.words, size, more=more)
    if panel.x.label:
        down = size * (1.3 + (1.5 if panel.x.ticks else 0.0))
        middle = (box.left + box.right) / 2
        yield _words((middle, box.bottom + down), panel.x.label, size, more=_MIDDLE)


def _y_axis(box: _Box) -> Iterator[str]:
    panel = box.panel
    size = panel.size_pt
    if not panel.lanes:
        yield _path([(box.left, box.top), (box.left, box.bottom)], "line", 0.8)
    for tick in _inside(panel.y):
        at = box.y(tick.value)
        if not panel.lanes:
            yield _path([(box.left - 3, at), (box.left, at)], "line", 0.8)
        yield _words((box.left - 5, at + size * 0.35), tick.words, size, more=_END)
    for number, line in enumerate(panel.y.label.split("\n") if panel.y.label else ()):
        x, y = box.left - _margin(panel) + size * (1 + 1.3 * number), (box.top + box.bottom) / 2
        yield _words((x, y), line, size, more=f'{_MIDDLE} transform="rotate(-90 {x:.1f} {y:.1f})"')


def _inside(axis: Axis) -> Iterator[Tick]:
    return (tick for tick in axis.ticks if -0.001 <= axis.place(tick.value) <= 1.001)


def _key(box: _Box) -> Iterator[str]:
    """Draw the key above the panel, from the right."""
    at = box.right
    for role, words in reversed(box.panel.key):
        at -= len(words) * 9 * _WORD
        yield _words((at, box.top - 6), words, 9)
        at -= 14
        yield f'<rect x="{at:.1f}" y="{box.top - 13:.1f}" width="11" height="7" fill="var(--{role})"/>'
        at -= 10
