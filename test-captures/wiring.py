# SPDX-License-Identifier: GPL-2.0-or-later
"""Draws a tap on RS485, RS422 and RS232, and knows the pins (chapter 11). capture/docs/generate.py writes the files."""

from __future__ import annotations

from collections.abc import Callable

from drawing import WHITE, Page

PLUS, MINUS, GROUND, TAP = "#c0392b", "#2455a4", "#555555", "#fdf3d0"

# Figures 11-2 and 11-5 of the SIS definition; RxD and TxD are those of the device.
PINS = (
    ("RS485 +", "3 (named B)", "4"),
    ("RS485 -", "8 (named A)", "5"),
    ("RS422 RxD+, RxD-", "", "4, 5"),
    ("RS422 TxD+, TxD-", "", "9, 11"),
    ("RS232 TxD, RxD", "", "2, 3"),
    ("Ground", "5", "7, 10"),
    ("Shield", "1", "1"),
)


def device(page: Page, x: float, y: float, words: str, *, tap: bool = False) -> None:
    """Draw a device as a box."""
    page.box(x, y, 26, 11, TAP if tap else WHITE)
    page.text(x + 13, y + 7, words, 4, text_anchor="middle")


def wire(page: Page, words: str, y: float, colour: str, ends: tuple[float, float]) -> None:
    """Draw a wire from the left to the right, with its name before it."""
    page.line(ends[0], y, ends[1], y, stroke=colour, stroke_width=0.7)
    page.text(ends[0] - 1.5, y + 1.3, words, 3.6, text_anchor="end", fill=colour)


def drop(page: Page, x: float, y: float, to: float, colour: str) -> None:
    """Connect a wire with what is below it."""
    page.line(x, y, x, to, stroke=colour, stroke_width=0.5)
    page.area(x - 0.7, y - 0.7, 1.4, 1.4, colour)


def bus(page: Page, x: float, names: tuple[str, ...], *, y: float = 0, pitch: float = 34) -> None:
    """Draw a two-wire bus with a resistor at both ends, and what is connected to it; the last one is the tap."""
    right = x + 9 + pitch * len(names)
    wires = ((y + 8, PLUS), (y + 15, MINUS), (y + 22, GROUND))
    for words, (high, colour) in zip(("+", "-", "ground"), wires, strict=True):
        wire(page, words, high, colour, (x, right))
    for left in (x + 2, right - 4):
        page.box(left, y + 8, 2, 7)
    page.text(x + 2, y + 6, "120 ohms", 3.2)
    page.text(right - 2, y + 6, "120 ohms", 3.2, text_anchor="end")
    for number, words in enumerate(names):
        left = x + 10 + pitch * number
        for place, (high, colour) in enumerate(wires):
            drop(page, left + 5 + 8 * place, high, y + 30, colour)
        device(page, left, y + 30, words, tap=words == "tap")


def rs485() -> Page:
    """Draw a tap on two-wire RS485."""
    page = Page(168, 48, "A tap on two-wire RS485")
    bus(page, 18, ("master", "drive 3", "drive 4", "tap"))
    page.text(133, 46, "no resistor of its own", 3.4, text_anchor="middle")
    return page


def converter() -> Page:
    """Draw a PC that reaches the bus through a converter."""
    page = Page(168, 62, "A PC with a converter from RS232 to RS485, and a tap at the bus")
    bus(page, 18, ("converter", "drive 3", "drive 4", "tap"))
    for place in range(3):
        page.line(33 + 8 * place, 41, 33 + 8 * place, 50, stroke=GROUND, stroke_width=0.5)
    device(page, 28, 50, "PC (RS232)")
    page.text(64, 57, "Not here: this is RS232, with a wire for each direction.", 3.6)
    return page


def pair_of_taps(title: str, wires: tuple[tuple[str, float, str], ...], taps: tuple[tuple[int, ...], ...]) -> Page:
    """Draw a master, a drive, the wires between them, and two taps that each hear some of the wires."""
    high = wires[-1][1] + 30
    page = Page(168, high, title)
    bottom = wires[-1][1] + 10
    for left, words in ((2, "master"), (140, "drive")):
        page.box(left, 3, 26, wires[-1][1] + 3)
        page.text(left + 13, wires[-1][1] / 2 + 6, words, 4, text_anchor="middle")
    for words, y, colour in wires:
        page.line(28, y, 140, y, stroke=colour, stroke_width=0.7)
        page.text(30, y - 1, words, 3.2, fill=colour)
    for number, heard in enumerate(taps):
        left = 70 + 36 * number
        for place, index in enumerate(heard):
            _, y, colour = wires[index]
            drop(page, left + 5 + 8 * place, y, bottom, colour)
        device(page, left, bottom, f"tap, line {number + 1}", tap=True)
    page.text(83, high - 3, "only receivers are connected", 3.4)
    return page


def rs422() -> Page:
    """Draw two taps on RS422."""
    wires = (
        ("master sends +", 8, PLUS),
        ("master sends -", 15, MINUS),
        ("drive sends +", 22, PLUS),
        ("drive sends -", 29, MINUS),
        ("ground", 36, GROUND),
    )
    return pair_of_taps("Two taps on RS422", wires, ((0, 1, 4), (2, 3, 4)))


def rs232() -> Page:
    """Draw two taps on RS232."""
    wires = (("master sends (TxD)", 8, PLUS), ("drive sends (TxD)", 15, MINUS), ("ground", 22, GROUND))
    return pair_of_taps("Two taps on RS232", wires, ((0, 2), (1, 2)))


DRAWINGS: dict[str, Callable[[], Page]] = {"rs485": rs485, "converter": converter, "rs422": rs422, "rs232": rs232}
