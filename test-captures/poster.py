#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes two posters: course/poster.svg for the hand, with a telegram in colours, its checksum, filters, times, wiring,
and course/wall-chart.svg, a telegram and the wiring in letters that can be read from two metres.

    python3 poster.py          write both
    python3 poster.py --pdf    and poster-a3.pdf, poster-a4.pdf, wall-chart.pdf (printing.py says what that needs)

The colours are those of `sistap annotate` and the pages of the course; filters are the buttons of Wireshark's profile.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import wiring
from drawing import BLACK, Column, Page, wrapped
from pages.profile import buttons
from printing import digest, pdf
from sistap.commands.annotate.page import KINDS

SVG = Path(__file__).parent / "course" / "poster.svg"
CHART = SVG.with_name("wall-chart.svg")
SHEETS = {"a3": 1.0, "a4": 297 / 420}

SIZE = 4.6  # of most of the text, in mm
FILTER_SIZE = 3.9
MARGIN = 12.0
BYTE = 26.4  # how wide a byte is drawn
CHARACTER = 5.0  # how long a character is in the time diagram

# Chapters 2.2 and 9: bytes, what they are, and of which kind.
Byte = tuple[str, str, str]
HEADER = ("Start", "Checksum", "Length", "Length again", "Telegram control", "Service", "Sender", "Receiver")
HEADER_KINDS = ("frame", "frame", "frame", "frame", "control", "service", "address", "address")
OBJECT = ("Parameter control", "Device address")
COMMAND = "02 6E 05 05 00 10 10 03 3C 03 00 24 00"
COMMAND_BODY = (*OBJECT, "Type 0: drive", "Number, low byte", "Number, high byte")
COMMAND_KINDS = ("object",) * 5
REACTION = "02 D0 07 07 10 10 10 03 00 3C 03 80 96 98 00"
REACTION_BODY = ("Status: good", *OBJECT, "Data, low byte", "Data", "Data", "Data, high byte")
REACTION_KINDS = ("status", "object", "object", "data", "data", "data", "data")

# Chapter 2.3: the contents of a telegram are a useful data header and useful data.
PARTS = {"status": "useful data header", "object": "useful data header", "data": "useful data"}

DEAD_BUS = (
    ("1", "Is anything there? sistap ports names the adapters, sistap doctor says what is missing."),
    ("2", "sistap capture --baud auto -i PORT finds the rate. No character at all: look at the wires."),
    ("3", "Only errors, no telegram: wrong rate or format, or + and - are swapped."),
    ("4", "Commands, but no reactions: button Unanswered. One drive: its supply, address or rate. All: the cable."),
    ("5", "Reactions with errors: button Errors. The status and the code say why."),
    ("6", "Now and then: buttons Line, Damaged and Late. Note the packet, and who talks."),
)
WIRING = (
    ("RS485", "two wires, A (-) and B (+), from station to station. A resistor of 120 ohms at both ends only."),
    ("9-pin", "3 is B (+), 8 is A (-), 5 is ground, 1 is the shield."),
    ("15-pin", "4 is RS485 +, 5 is RS485 -, 7 and 10 are ground. RS232: 2 is TxD, 3 is RxD."),
    ("Tap", "+ to +, - to -, ground to ground: many adapters name + A. It only listens; no resistor of its own."),
)
TIMES = (
    ("TzA", "longest interval from character to character. A longer one does not end the telegram."),
    ("TrS", "from the last character of the command to the first of the reaction."),
    ("TwM", "how long the master waits before it sends a command again."),
    ("Limits", "TzA and TrS have no default values. Service 03 sets them; its FF makes them valid."),
    ("Rate", "9600 Bd after switching on. A character of 11 bits (8E1) takes 1.146 ms then."),
)
BESIDE = ("Type 1 and 2: parameters", "of a control. Bit 15 of the", "number: 0 is S, 1 is P.")
# Of the wall chart: plug, pins.
PLUGS = (("9-pin", "3 is B (+), 8 is A (-), 5 is ground"), ("15-pin", "4 is +, 5 is -, 7 and 10 are ground"))


def tint(kind: str) -> str:
    """Return the colour of a kind as paper: a quarter of it in white."""
    colour = KINDS[kind][1]
    return "#" + "".join(f"{255 - (255 - int(colour[at : at + 2], 16)) // 4:02x}" for at in (1, 3, 5))


def row(pairs: str, body: Sequence[str], kinds: Sequence[str]) -> list[Byte]:
    """Return the bytes of a telegram with what they are."""
    return list(zip(pairs.split(), (*HEADER, *body), (*HEADER_KINDS, *kinds), strict=True))


def telegram(page: Page, y: float, words: str, bytes_: Sequence[Byte], size: float = 3.6) -> None:
    """Draw the bytes of a telegram from the left to the right, and its parts below. The size is that of the names."""
    page.text(MARGIN, y, words, max(size, 4.6), font_weight="bold")
    for number, (pair, name, kind) in enumerate(bytes_):
        left = MARGIN + BYTE * number
        page.area(left, y + 2, BYTE - 1, 12, tint(kind))
        page.line(left, y + 14, left + BYTE - 1, y + 14, stroke=KINDS[kind][1], stroke_width=1)
        page.text(left + BYTE / 2, y + 11.2, pair, 9, text_anchor="middle", font_weight="bold")
        for place, line in enumerate(wrapped(name, size, BYTE - 1)):
            page.text(left + BYTE / 2, y + 15 + size * (1.1 + 1.1 * place), line, size, text_anchor="middle")
    left, below = MARGIN, y + 15 + 2.75 * size
    for part, group in groupby(PARTS.get(kind, "header") for _, _, kind in bytes_):
        right = left + BYTE * len(list(group))
        page.line(left, below, right - 1, below, stroke_width=0.5)
        page.text((left + right) / 2, below + 1.05 * size, part, size, text_anchor="middle")
        left = right


def key(page: Page, y: float) -> None:
    """Say what the colours mean."""
    for number, (kind, (words, colour, _)) in enumerate(KINDS.items()):
        left = MARGIN + 56.5 * number
        page.area(left, y - 4, 5, 5, tint(kind))
        page.line(left, y + 1, left + 5, y + 1, stroke=colour, stroke_width=0.8)
        page.text(left + 7, y, words, 3.6)


def checksum_steps(pairs: str) -> list[tuple[str, str]]:
    """Work out the checksum of a telegram as one does with a pencil."""
    numbers = [int(pair, 16) for pair in pairs.split()]
    others = [number for place, number in enumerate(numbers) if place != 1]
    total = sum(others)
    kept = total % 256
    return [
        ("Add", " + ".join(f"{number:02X}" for number in others)),
        ("Sum", f"{total:02X} in hexadecimal; keep the last two digits: {kept:02X}"),
        ("100 - " + f"{kept:02X}", f"= {(256 - kept) % 256:02X}: that is the checksum"),
        ("Check", f"with it, all bytes together end in 00 ({sum(numbers):X})"),
    ]


def columns(page: Page, top: float, bottom: float) -> None:
    """Write what stands in three columns."""
    wide, gap = 128.0, 6.0
    first, second, third = (
        Column(page, MARGIN + (wide + gap) * place, (top, bottom), wide, size)
        for place, size in enumerate((SIZE, SIZE, FILTER_SIZE))
    )
    first.heading("The checksum of the command, with a pencil")
    first.rows(checksum_steps(COMMAND), 23)
    first.heading("Wiring")
    first.rows(WIRING, 23)
    second.heading("Five minutes at a dead bus")
    second.rows(DEAD_BUS, 7)
    third.heading("Buttons of the profile, and what to type instead")
    third.rows([(word, expression) for word, expression, _ in buttons()], 27)
    third.heading("Filters to begin with")
    third.rows(
        [
            ("One drive", "sis.talker == 3"),
            ("Parameter", 'sis.parameter == "S-0-0036"'),
            ("Slow", "sis.reaction_time > 0.05"),
            ("Commands", "sis.control.reaction == 0"),
        ],
        27,
    )


def characters(page: Page, x: float, y: float, words: str, places: Sequence[int]) -> list[float]:
    """Draw characters at so many character times; return when each is over, that is when it has arrived."""
    kind = "status" if words == "reaction" else "service"
    for place in places:
        page.box(x + CHARACTER * place, y, CHARACTER, 6, tint(kind))
    page.text(x, y + 11, words, SIZE)
    return [x + CHARACTER * (place + 1) for place in places]


def timing(page: Page, x: float, y: float) -> None:
    """Draw the times on one line of the bus. A time begins and ends when a character has arrived."""
    page.text(x, y, "Times", 4.6, font_weight="bold")
    base = y + 12
    page.line(x, base + 6, x + 262, base + 6)
    command = characters(page, x + 26, base, "command", [0, 1, 2, 3, 7, 8, 9, 10])
    reaction = characters(page, command[-1] + 26, base, "reaction", range(5))
    again = characters(page, reaction[-1] + 15, base, "command", range(4))
    repeat = characters(page, again[-1] + 26, base, "the same again", range(4))
    for begin, end, words in (
        (x + 1, command[0], "silence"),
        (command[3], command[4], "TzA"),
        (command[-1], reaction[0], "TrS"),
        (again[-1], repeat[0], "no reaction: TwM"),
    ):
        page.span(begin, end, base - 2, words, SIZE)
    page.text(x, base + 18, "A character has arrived when its last bit is over: there the arrows begin and end.", SIZE)


def poster() -> str:
    """Make the whole page."""
    page = Page(420, 297, "A SIS telegram, and five minutes at a dead bus")
    page.area(0, 0, 420, 19, tint("service"))
    page.text(MARGIN, 13.5, "The SIS telegram", 10, font_weight="bold", fill=BLACK)
    words = "Bytes are hexadecimal, addresses decimal. Two bytes and more: low byte first."
    page.text(408, 13, words, SIZE, text_anchor="end")
    words = "Command: station 16 asks drive 3 for the value of S-0-0036"
    telegram(page, 26, words, row(COMMAND, COMMAND_BODY, COMMAND_KINDS))
    telegram(
        page,
        61.5,
        "Reaction: drive 3 answers; the addresses are those of the command, bit 4 of telegram control tells it apart",
        row(REACTION, REACTION_BODY, REACTION_KINDS),
    )
    for number, line in enumerate(BESIDE):
        page.text(MARGIN + BYTE * len(COMMAND.split()) + 2, 32 + 4.5 * number, line, 3.9)
    key(page, 97)
    columns(page, 100, 226)
    wiring.bus(page, 158, ("master", "drive 3", "drive 4", "tap"), y=185, pitch=27)
    timing(page, MARGIN, 238)
    Column(page, 284, (229, 295), 126, SIZE).rows(TIMES, 27)
    return page.svg()


def sized(svg: str, scale: float) -> str:
    """Return the same drawing for another size of paper."""
    return svg.replace('width="420mm" height="297mm"', f'width="{420 * scale:g}mm" height="{297 * scale:g}mm"', 1)


def wall_chart() -> str:
    """Make the chart, A1: a telegram, and the wiring with its ground."""
    telegrams = Page(420, 80, "")
    telegram(telegrams, 6, "Command: station 16 to drive 3", row(COMMAND, COMMAND_BODY, COMMAND_KINDS), 4.3)
    telegram(telegrams, 46.5, "Reaction of drive 3", row(REACTION, REACTION_BODY, REACTION_KINDS), 4.3)
    page = Page(841, 594, "The SIS telegram and the wiring of its bus")
    page.area(0, 0, 841, 60, tint("service"))
    page.text(24, 43, "The SIS telegram", 34, font_weight="bold")
    page.place(telegrams, 0, 66, 2)
    page.text(24, 256, "All bytes together end in 00. Lengths count the bytes after the eighth. Low byte first.", 16)
    page.area(0, 276, 841, 60, tint("address"))
    page.text(24, 319, "Two wires and ground", 34, font_weight="bold")
    page.place(wiring.rs485(), 0, 362, 2.8)
    for number, (plug, pins) in enumerate(PLUGS):
        page.text(486, 412 + 58 * number, plug, 20, font_weight="bold")
        page.text(486, 432 + 58 * number, pins, 16)
    words = "A resistor of 120 ohms at both ends, and nowhere else. A tap connects + to +, - to -, ground to ground."
    page.text(24, 560, words, 14)
    return page.svg()


def main() -> None:
    """Write the posters."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pdf", action="store_true", help="also write the PDFs")
    arguments = parser.parse_args()
    drawn = poster()
    papers = {CHART: wall_chart()}
    papers |= {SVG.with_name(f"poster-{name}.svg"): sized(drawn, scale) for name, scale in SHEETS.items()}
    SVG.write_text(drawn)
    CHART.write_text(papers[CHART])
    for path, svg in papers.items() if arguments.pdf else ():
        path.with_suffix(".pdf").write_bytes(pdf(svg) + digest(svg).encode())


if __name__ == "__main__":
    main()
