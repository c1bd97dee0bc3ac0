#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the poster for the wall, course/poster.svg: a telegram in colours, its checksum, filters, times, wiring.

    python3 poster.py          write poster.svg
    python3 poster.py --pdf    and poster-a3.pdf, poster-a4.pdf (needs rsvg-convert, and the font Liberation Sans)

The colours are those of `sistap annotate` and the pages of the course; filters are the buttons of Wireshark's profile.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from drawing import BLACK, WHITE, Column, Page, wrapped
from pages.profile import buttons
from sistap.commands.annotate.page import KINDS

SVG = Path(__file__).parent / "course" / "poster.svg"
SHEETS = {"a3": 1.0, "a4": 297 / 420}

SIZE = 4.6  # of most of the text, in mm
MARGIN = 12.0
BYTE = 26.4  # how wide a byte is drawn
CHARACTER = 5.0  # how long a character is in the time diagram

# Chapters 2.2 and 9: bytes, what they are, and of which kind.
Byte = tuple[str, str, str]
HEADER = ("Start", "Checksum", "Length", "Length again", "Control", "Service", "Sender", "Receiver")
HEADER_KINDS = ("frame", "frame", "frame", "frame", "control", "service", "address", "address")
OBJECT = ("Parameter control", "Device")
COMMAND = "02 6E 05 05 00 10 10 03 3C 03 00 24 00"
COMMAND_BODY = (*OBJECT, "Type: S or P", "Number, low byte", "Number, high byte")
COMMAND_KINDS = ("object",) * 5
REACTION = "02 D0 07 07 10 10 10 03 00 3C 03 80 96 98 00"
REACTION_BODY = ("Status: good", *OBJECT, "Data, low byte", "Data", "Data", "Data, high byte")
REACTION_KINDS = ("status", "object", "object", "data", "data", "data", "data")

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
    ("TwM", "wait of the master before it sends a command again."),
    ("Limits", "are set by service 03 and valid after its FF. There are no default values."),
    ("Character", "11 bits (8E1): 1.146 ms at 9600 Bd, 0.0955 ms at 115200 Bd."),
)


def tint(kind: str) -> str:
    """Return the colour of a kind as paper: a quarter of it in white."""
    colour = KINDS[kind][1]
    return "#" + "".join(f"{255 - (255 - int(colour[at : at + 2], 16)) // 4:02x}" for at in (1, 3, 5))


def row(pairs: str, body: Sequence[str], kinds: Sequence[str]) -> list[Byte]:
    """Return the bytes of a telegram with what they are."""
    return list(zip(pairs.split(), (*HEADER, *body), (*HEADER_KINDS, *kinds), strict=True))


def telegram(page: Page, y: float, words: str, bytes_: Sequence[Byte]) -> None:
    """Draw the bytes of a telegram from the left to the right."""
    page.text(MARGIN, y, words, 4.6, font_weight="bold")
    for number, (pair, name, kind) in enumerate(bytes_):
        left = MARGIN + BYTE * number
        page.area(left, y + 2, BYTE - 1, 12, tint(kind))
        page.line(left, y + 14, left + BYTE - 1, y + 14, stroke=KINDS[kind][1], stroke_width=1)
        page.text(left + BYTE / 2, y + 11.2, pair, 9, text_anchor="middle", font_weight="bold")
        for place, line in enumerate(wrapped(name, 3.6, BYTE - 1)):
            page.text(left + BYTE / 2, y + 19 + 4 * place, line, 3.6, text_anchor="middle")


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
        Column(page, MARGIN + (wide + gap) * place, (top, bottom), wide, SIZE) for place in range(3)
    )
    first.heading("The checksum of the command, with a pencil")
    first.rows(checksum_steps(COMMAND), 23)
    first.heading("Wiring")
    first.rows(WIRING, 23)
    second.heading("Five minutes at a dead bus")
    second.rows(DEAD_BUS, 7)
    third.heading("Buttons of the profile, and what to type instead")
    for word, expression, _ in buttons():
        begin, *more = expression.split(" || ")
        third.rows([(word, f"{begin} || ..." if more and len(expression) >= 60 else expression)], 31)
    third.heading("Filters to begin with")
    third.rows(
        [
            ("One drive", "sis.talker == 3"),
            ("Parameter", 'sis.parameter == "S-0-0036"'),
            ("Slow", "sis.reaction_time > 0.05"),
            ("Commands", "sis.control.reaction == 0"),
        ],
        31,
    )


def bus(page: Page, x: float, y: float) -> None:
    """Draw a bus: two wires, a resistor at both ends, stations, and the tap."""
    page.line(x + 6, y, x + 116, y, stroke=KINDS["address"][1], stroke_width=0.6)
    page.line(x + 6, y + 6, x + 116, y + 6, stroke=KINDS["service"][1], stroke_width=0.6)
    page.text(x, y + 1.2, "B", SIZE, font_weight="bold")
    page.text(x, y + 7.2, "A", SIZE, font_weight="bold")
    for left in (x + 8, x + 112):
        page.box(left, y, 2, 6)
    page.text(x + 12, y - 1.5, "120 ohms", 3.3)
    page.text(x + 110, y - 1.5, "120 ohms", 3.3, text_anchor="end")
    for number, words in enumerate(("master", "drive 3", "drive 4", "tap")):
        left = x + 18 + 24.5 * number
        page.line(left + 5, y, left + 5, y + 11, stroke=KINDS["address"][1], stroke_width=0.4)
        page.line(left + 12, y + 6, left + 12, y + 11, stroke=KINDS["service"][1], stroke_width=0.4)
        page.box(left, y + 11, 18, 7, tint("object") if words == "tap" else WHITE)
        page.text(left + 9, y + 15.8, words, SIZE, text_anchor="middle")


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
    telegram(page, 27, words, row(COMMAND, COMMAND_BODY, COMMAND_KINDS))
    telegram(
        page,
        57,
        "Reaction: drive 3 answers; the addresses are those of the command, bit 4 of the control tells it apart",
        row(REACTION, REACTION_BODY, REACTION_KINDS),
    )
    key(page, 88)
    columns(page, 93, 222)
    bus(page, 146, 190)
    timing(page, MARGIN, 230)
    Column(page, 284, (228, 294), 126, SIZE).rows(TIMES, 27)
    return page.svg()


def sized(svg: str, scale: float) -> str:
    """Return the same drawing for another size of paper."""
    return svg.replace('width="420mm" height="297mm"', f'width="{420 * scale:g}mm" height="{297 * scale:g}mm"', 1)


def digest(svg: str) -> str:
    """Return the last line of the PDF: which SVG it was made from. Readers of PDF pass it over."""
    return f"% poster.svg {hashlib.sha256(svg.encode()).hexdigest()}\n"


def main() -> None:
    """Write the poster."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pdf", action="store_true", help="also write the PDFs")
    arguments = parser.parse_args()
    svg = poster()
    SVG.write_text(svg)
    for name, scale in SHEETS.items() if arguments.pdf else ():
        try:
            command = ["rsvg-convert", "--format=pdf"]
            pdf = subprocess.run(command, check=True, input=sized(svg, scale).encode(), stdout=subprocess.PIPE).stdout
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"poster.py: {error}; rsvg-convert is in the package librsvg2-bin")
        SVG.with_name(f"poster-{name}.pdf").write_bytes(pdf + digest(svg).encode())


if __name__ == "__main__":
    main()
