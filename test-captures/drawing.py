# SPDX-License-Identifier: GPL-2.0-or-later
"""A page in SVG: text, boxes and arrows at positions in millimetres, and columns of text that grow downwards."""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree

FONT = "Liberation Sans, Arial, Helvetica, sans-serif"  # of equal widths, and one of them is on every computer
BLACK, PALE, WHITE = "#000000", "#e6e6e6", "#ffffff"

# Widths of these fonts relative to the font size, rounded up; other characters are as wide as most small letters.
_NARROW_TO_WIDE = {
    "ijl'|": 0.23,
    "ft.,:;/!I() -[]": 0.34,
    "ckrsvxyz": 0.5,
    "ABEFKLPSTVXYZ": 0.68,
    "CDGHNOQRUw<>=+": 0.78,
    "mMW": 0.95,
}
_WIDTHS = {character: width for characters, width in _NARROW_TO_WIDE.items() for character in characters}


def width(text: str, size: float) -> float:
    """Return the largest width of the text, in the unit of the size."""
    return size * sum(_WIDTHS.get(character, 0.56) for character in text)


def wrapped(text: str, size: float, room: float) -> list[str]:
    """Break the text between words into lines that fit the room. A number stays with its word."""
    lines = [""]
    for word in re.findall(r"(?:[0-9A-F]{1,2} )?\S+", text):
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and width(longer, size) > room:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


class Page:
    """A page of so many millimetres."""

    def __init__(self, page_width: float, page_height: float, title: str) -> None:
        """Begin with white paper; programs show the title."""
        self.width, self.height = page_width, page_height
        self._root = ElementTree.Element(
            "svg",
            {
                "xmlns": "http://www.w3.org/2000/svg",
                "width": f"{page_width:g}mm",
                "height": f"{page_height:g}mm",
                "viewBox": f"0 0 {page_width:g} {page_height:g}",
                "font-family": FONT,
            },
        )
        ElementTree.SubElement(self._root, "title").text = title
        self.area(0, 0, page_width, page_height, WHITE)

    def _add(self, name: str, **attributes: object) -> ElementTree.Element:
        given = {key.replace("_", "-"): _written(value) for key, value in attributes.items()}
        return ElementTree.SubElement(self._root, name, given)

    def text(self, x: float, y: float, words: str, size: float, **attributes: object) -> None:
        """Write words with their baseline at y. ValueError if they may leave the page."""
        anchor = attributes.get("text_anchor", "start")
        left = x - width(words, size) * {"start": 0, "middle": 0.5, "end": 1}[str(anchor)]
        if left < 0 or left + width(words, size) > self.width or not size <= y <= self.height:
            raise ValueError(f"outside the page: {words}")
        self._add("text", **{"x": x, "y": y, "font_size": size, "fill": BLACK, **attributes}).text = words

    def place(self, other: Page, x: float, y: float, scale: float) -> None:
        """Draw another page on this one, larger or smaller. ValueError if it leaves this one."""
        if x + other.width * scale > self.width or y + other.height * scale > self.height:
            raise ValueError("outside the page: another page")
        group = self._add("g", transform=f"translate({x:g} {y:g}) scale({scale:g})")
        group.extend(list(other._root)[1:])

    def area(self, x: float, y: float, wide: float, high: float, fill: str) -> None:
        """Fill a rectangle."""
        self._add("rect", x=x, y=y, width=wide, height=high, fill=fill)

    def box(self, x: float, y: float, wide: float, high: float, fill: str = WHITE) -> None:
        """Draw a rectangle with its outline."""
        self._add("rect", x=x, y=y, width=wide, height=high, fill=fill, stroke=BLACK, stroke_width=0.25)

    def line(self, x1: float, y1: float, x2: float, y2: float, **attributes: object) -> None:
        """Draw a line."""
        stroke = {"stroke": BLACK, "stroke_width": 0.25, **attributes}
        self._add("line", x1=x1, y1=y1, x2=x2, y2=y2, **stroke)

    def span(self, x1: float, x2: float, y: float, words: str, size: float) -> None:
        """Draw a double arrow from x1 to x2 with words over its middle."""
        self.line(x1, y, x2, y)
        for x, inwards in ((x1, 1), (x2, -1)):
            self._add("path", d=f"M{x:g} {y:g}l{1.5 * inwards:g} -0.6v1.2z", fill=BLACK)
        self.text((x1 + x2) / 2, y - 0.8, words, size, text_anchor="middle")

    def svg(self) -> str:
        """Return the page as a file."""
        ElementTree.indent(self._root)
        return ElementTree.tostring(self._root, encoding="unicode") + "\n"


class Column:
    """Headings and rows, one below the other; a row has a code at the left and a text that may need several lines."""

    def __init__(self, page: Page, x: float, extent: tuple[float, float], wide: float, size: float) -> None:
        """Begin at the top of the extent; nothing may go below its bottom. The size is that of the text."""
        self._page, self._x, self._wide, self._size = page, x, wide, size
        self._y, self._bottom = extent

    def heading(self, words: str) -> None:
        """Begin a new heading."""
        self._advance(self._size * 1.9)
        self._page.area(self._x, self._y - self._size * 1.15, self._wide, self._size * 1.5, PALE)
        self._page.text(self._x + 0.8, self._y, words, self._size * 1.1, font_weight="bold")
        self._y += self._size * 0.25

    def rows(self, entries: Sequence[tuple[str, str]], indent: float) -> None:
        """Write rows; the texts begin at the indent."""
        for code, text in entries:
            for number, line in enumerate(wrapped(text, self._size, self._wide - indent)):
                self._advance(self._size * 1.23)
                if number == 0:
                    self._page.text(self._x + 0.8, self._y, code, self._size, font_weight="bold")
                self._page.text(self._x + indent, self._y, line, self._size)

    def words(self, text: str) -> None:
        """Write text over the whole width."""
        self.rows([("", text)], 0.8)

    def _advance(self, high: float) -> None:
        self._y += high
        if self._y > self._bottom:
            raise ValueError("the column is too short for what stands in it")


def _written(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
