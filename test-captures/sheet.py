#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the telegram on one page, course/sheet.svg, from the tables of plugin/protocol/codes.toml.

    python3 sheet.py          write sheet.svg
    python3 sheet.py --pdf    and sheet.pdf from it (printing.py says what that needs)

The texts of codes are those of the tables. Which of them stand here, and what is no table, is said below.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from drawing import PALE, WHITE, Column, Page
from printing import digest, pdf

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "plugin" / "protocol"))

from description import Code, Description  # noqa: E402

TABLES = Description().tables
SVG = HERE / "course" / "sheet.svg"

PRODUCTS = re.compile(r" \((ECODRIVE|SYNAX)\)$")
HALTS = re.compile(r"^(Shutdown|Reboot) ")

SIZE = 2.55  # of most texts, in mm
CHARACTER = 2.2  # width of a character in the timing diagram

# Chapter 2.2. The bytes above the line are always there.
HEADER = (
    ("1", "Start", "02"),
    ("2", "Checksum", "sum of all bytes is 00"),
    ("3", "Length", "bytes after the 8th"),
    ("4", "Length", "the same again"),
    ("5", "Control", "bits: see below"),
    ("6", "Service", "see below"),
    ("7", "Sender", "the master's address"),
    ("8", "Receiver", "the slave's address"),
)
ANNOUNCED = (
    ("", "Subaddresses", "as many as control bits 0-2 say"),
    ("", "Telegram no.", "if control bit 3 is set"),
    ("", "Contents", "useful data header, useful data"),
)
EXAMPLE = (
    "02 D9 00 00 00 12 10 03: station 16 asks station 3 for its phase.    "
    "02 C3 02 02 10 12 10 03 00 02: station 3 answers 16, status 00, phase 2."
)
READING = "02 6E 05 05 00 10 10 03 3C 03 00 24 00: station 16 reads the value of S-0-0036 in drive 3."

CONTROL = (
    ("0-2", "number of subaddresses, 0 to 7"),
    ("3", "a telegram number follows them"),
    ("4", "0 command, 1 reaction"),
    ("5", "reserved"),
    ("6, 7", "system warning, system error of the sender"),
)

# Fig. 2-9; decimal. The kinds are those of the table.
ADDRESSES = (
    ("0-126", "STATION"),
    ("127", "SERVICE_MASTER"),
    ("128", "POINT_TO_POINT"),
    ("129-199", "RESERVED"),
    ("200-253", "GROUP"),
    ("254", "LEVEL_BROADCAST"),
    ("255", "GLOBAL_BROADCAST"),
)

# Chapter 8.1 and 9.8 of IEC 61491, as far as SIS uses it.
PARAMETER = (
    ("Control", "bit 2: 1 last, 0 more follows. 3C operating data, last; 38 more follows"),
    ("Type", "0 S or P, 1 A, 2 C"),
    ("Number", "bits 0-11 number, 12-14 set, 15: 1 = P"),
)
ATTRIBUTE = (
    ("0-15", "factor"),
    ("16-18", "length: 1, 2, 3 = 2, 4, 8 bytes; 4-7 list of 1, 2, 4, 8 bytes each"),
    ("19", "procedure command"),
    ("20-22", "0 binary, 1 unsigned, 2 signed, 3 hexadecimal, 4 text, 5 ident number, 6 float"),
    ("24-27", "decimal places"),
    ("28-30", "write-protected in phase 2, 3, 4"),
)

# What the last digit of an error code of parameters means, from element 1 on; the others stand beside it.
DIGITS = {1: "not available", 2: "transmitted too short", 3: "transmitted too long", 4: "cannot be changed"}
DIGITS |= {5: "write-protected at present"}
RULED = re.compile("0x[1-7]00[1-5]")

TIMES = (
    "TzA: longest interval from character to character. A longer one does not end the telegram.",
    "TrS: time in which the reaction is expected, from the last character of the command.",
    "TwM: how long the master waits before it repeats, and after a command to many.",
    "Tmas: longest time between two master control words while the machine moves.",
    "TzA, TrS and Tmas have no default values. A bus begins with 9600 Bd after switching on.",
    "Service 03 sets times and rate; its subservice FF makes them valid.",
)
STARTS = "After a silence longer than TzA a receiver looks for a start. A slave never speaks first."


def table(name: str) -> Sequence[Code]:
    """Return a table of the description. KeyError if there is none of that name."""
    return TABLES[name].codes


def code(entry: Code) -> str:
    """Format a code for readers: without 0x."""
    return entry.key.replace("0x", "")


def rows(name: str) -> list[tuple[str, str]]:
    """Return the rows of a table."""
    return [(code(entry), entry.text) for entry in table(name)]


def merged(entries: Sequence[Code], beside: re.Pattern[str]) -> list[tuple[str, str]]:
    """Return rows, in one row those that have the same text without what is found in it."""
    like: dict[str, list[str]] = {}
    for entry in entries:
        like.setdefault(beside.sub("", entry.text), []).append(code(entry))
    return [(" ".join(codes), text) for text, codes in like.items()]


def services() -> list[tuple[str, str]]:
    """Return single services, those of the products beside the corresponding general ones, and then ranges."""
    ranges = [entry for entry in table("services") if entry.first != entry.last and entry.first >= 0xA0]
    return [
        *merged([entry for entry in table("services") if entry.first == entry.last], PRODUCTS),
        *((code(entry), entry.text) for entry in ranges),
    ]


def parameter_errors() -> list[tuple[str, str]]:
    """Return the codes that do not follow the rule of DIGITS."""
    return [(code(entry), entry.text) for entry in table("errors_parameter") if not RULED.fullmatch(entry.key)]


def statuses() -> list[tuple[str, str]]:
    """Return those that are specified."""
    return [(code(entry), entry.text) for entry in table("status") if "not specified" not in entry.text]


def addresses() -> list[tuple[str, str]]:
    """Return kinds of addresses with their meanings."""
    kinds = {entry.constant.removeprefix("SIS_"): entry.text for entry in table("address_kinds")}
    return [(numbers, kinds[kind]) for numbers, kind in ADDRESSES]


def joined(name: str) -> str:
    """Return a short table in one line."""
    return ", ".join(f"{code(entry)} {entry.text}" for entry in table(name))


def header(page: Page, x: float, y: float) -> None:
    """Draw the bytes of a telegram from the left to the right."""
    wide, high = 25.5, 13.5
    for number, (byte, name, meaning) in enumerate(HEADER + ANNOUNCED):
        left = x + wide * number
        page.box(left, y, wide, high, PALE if byte else WHITE)
        page.text(left + 1, y + 4, " ".join((byte, name)).strip(), 3.0, font_weight="bold")
        for place, line in enumerate(_two_lines(meaning)):
            page.text(left + 1, y + 8.5 + 3.4 * place, line, SIZE)


def _two_lines(text: str) -> list[str]:
    words = text.split()
    cuts = [(" ".join(words[:cut]), " ".join(words[cut:])) for cut in range(1, len(words) + 1)]
    return list(min(cuts, key=lambda lines: max(map(len, lines))))


def columns(page: Page, top: float, bottom: float) -> None:
    """Write the tables."""
    wide, gap = 67.25, 4.0
    first, second, third, fourth = (
        Column(page, 8 + (wide + gap) * place, (top, bottom), wide, SIZE) for place in range(4)
    )
    first.heading("Telegram control (byte 5)")
    first.rows(CONTROL, 9)
    first.heading("Addresses (decimal)")
    first.rows(addresses(), 14)
    first.words("A reaction keeps the addresses of its command. No reaction to 200 and above.")
    first.heading("Status, first byte of the contents")
    first.rows(statuses(), 9)
    first.words("F0 and above: telegram error, no code follows. F9 to FC: IndraDrive.")
    first.heading("12 and 1D: status 02, phase, and this code")
    first.rows(rows("errors_phase"), 11)
    first.heading("In the edition ECODRIVE03")
    first.words("Control bits 5-7: status. 127 is a station, 128 to 254 are groups, not answered.")

    second.heading("Services (byte 6)")
    second.rows(services(), 19)
    second.heading("Transmission channel (status 02)")
    second.rows(rows("errors_channel"), 11)
    second.heading("Error codes of flash (status 01)")
    second.rows(merged(table("errors_flash"), HALTS), 19)
    second.words("Here and in 03: subservice and error byte make the code.")

    third.heading("Subservices of 00: identification")
    third.rows(rows("subservices_identification"), 9)
    third.heading("Subservices of 02: flash")
    third.rows(rows("subservices_flash"), 9)
    third.heading("Subservices of 03: initialization")
    third.rows(rows("subservices_initialization"), 9)
    third.heading("Error codes of 03 (status 01)")
    third.rows(rows("errors_initialization"), 11)
    third.heading("Parameter: control, device, type, number")
    third.rows(PARAMETER, 15)
    third.words("Element, bits 3-5 of control: " + joined("elements"))
    third.words(READING)
    third.heading("Procedure command and its data status")
    third.words("Written: 3 set and enable, 1 interrupt, 0 clear. Writing element 1, control 0C, brings the status:")
    third.words(", ".join(f"{entry.first:X} {entry.text}" for entry in table("data_states")))

    fourth.heading("Attribute of a parameter (4 bytes)")
    fourth.rows(ATTRIBUTE, 11)
    fourth.heading("Phases, baud rate masks")
    fourth.words(joined("phases"))
    fourth.words(joined("baud_masks"))
    fourth.heading("Error codes of parameters (status 01)")
    ends = ", ".join(f"{digit} {words}" for digit, words in DIGITS.items())
    fourth.words(f"1001 to 7005: the first digit is the element, the last one says why. {ends}")
    fourth.rows(parameter_errors(), 11)


def telegram(page: Page, x: float, y: float, words: str, places: Sequence[int]) -> list[float]:
    """Draw the characters of a telegram at these character times; return where each begins and the last one ends."""
    edges = [x + CHARACTER * place for place in places]
    for edge in edges:
        page.box(edge, y, CHARACTER, 3.6, PALE)
    page.text(x, y + 7, words, SIZE)
    return [*edges, edges[-1] + CHARACTER]


def timing(page: Page, x: float, y: float) -> None:
    """Draw the times on one line of the bus, with explanations."""
    page.text(x, y + 2, "Timing", 3.0, font_weight="bold")
    base = y + 9
    page.line(x, base + 3.6, x + 148, base + 3.6)
    command = telegram(page, x + 14, base, "command", [0, 1, 2, 3, 7, 8, 9, 10])
    reaction = telegram(page, command[-1] + 17, base, "reaction", range(6))
    again = telegram(page, reaction[-1] + 13, base, "command", range(5))
    repeat = telegram(page, again[-1] + 25, base, "the same", range(5))
    # A character has arrived at its end.
    spans = (
        (x + 1, command[1], "silence"),
        (command[3] + CHARACTER, command[4] + CHARACTER, "TzA"),
        (command[-1], reaction[1], "TrS"),
        (again[-1], repeat[1], "no reaction: TwM"),
    )
    for begin, end, words in spans:
        page.span(begin, end, base - 1.5, words, SIZE)
    page.text(x, base + 12, STARTS, SIZE)
    page.text(x, base + 15.5, "Character: 11 bits (8E1), 1.146 ms at 9600 Bd, 0.0955 ms at 115200 Bd.", SIZE)
    for number, words in enumerate(TIMES):
        page.text(x + 155, y + 4 + 3.8 * number, words, SIZE)


def sheet() -> str:
    """Make the whole page."""
    page = Page(297, 210, "The SIS telegram on one page")
    page.text(8, 12, "The SIS telegram", 6, font_weight="bold")
    page.text(
        289,
        12,
        "Codes are hexadecimal. Two bytes and more: low byte first. 8 data bits, even parity, 1 stop bit. "
        "Edition IF02 of the SIS definition.",
        SIZE,
        text_anchor="end",
    )
    header(page, 8, 15)
    page.text(8, 32.5, EXAMPLE, SIZE)
    columns(page, 32.8, 180)
    timing(page, 8, 181.5)
    return page.svg()


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pdf", action="store_true", help="also write sheet.pdf")
    arguments = parser.parse_args()
    SVG.write_text(sheet())
    if arguments.pdf:
        SVG.with_suffix(".pdf").write_bytes(pdf(SVG.read_text()) + digest(SVG.read_text()).encode())


if __name__ == "__main__":
    main()
