# SPDX-License-Identifier: GPL-2.0-or-later
"""The header of every telegram that the specification prints, against a table read from its figures by hand."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from sistap.tshark import Tshark

CAPTURE = Path(__file__).parent / "specification.pcapng"


class Figure(NamedTuple):
    """What a figure shows; None: the field is not there."""

    number: str
    checksum: int
    length: int
    reaction: bool
    service: int
    sender: int
    receiver: int
    subaddresses: str
    talker: int
    listener: int
    status: int | None
    rest: str | None  # of the useful data, after the status


# fmt: off
FIGURES = [
    Figure("2-10", 0xE1,  5, False, 0x03, 16,   3, "2,8", 16,   3, None, "f00100"),
    Figure("2-11", 0xF4,  4, False, 0x03,  3,   2, "8",    3,   2, None, "f00100"),
    Figure("2-12", 0xFA,  3, False, 0x03,  2,   8, "",     2,   8, None, "f00100"),
    Figure("2-13", 0xE9,  3, True,  0x03,  2,   8, "",     8,   2, 0x00, "01f1"),
    Figure("2-14", 0xE3,  4, True,  0x03,  3,   2, "8",    2,   3, 0x00, "01f1"),
    Figure("2-15", 0xD0,  5, True,  0x03, 16,   3, "2,8",  3,  16, 0x00, "01f1"),
    Figure("6-14", 0xD7,  3, False, 0x03, 16,   3, "",    16,   3, None, "040700"),
    Figure("6-15", 0xCF,  3, False, 0x03, 16,   3, "",    16,   3, None, "040708"),
    Figure("6-20", 0xE1,  5, False, 0x03, 16,   3, "",    16,   3, None, "0008f40100"),
    Figure("6-21", 0xAB,  5, False, 0x03, 16,   3, "",    16,   3, None, "0008200308"),
    Figure("6-24", 0xE9,  2, False, 0x03, 16, 255, "",    16, 255, None, "00ff"),
    Figure("7-1",  0x8E, 12, False, 0x04, 16,   3, "",    16,   3, None, "030010010300100303001004"),
    Figure("7-2",  0xF8, 35, True,  0x04, 16,   3, "",     3,  16, 0x00,
           "0900001001303156303111000010034" "34c432d4430322c334d2d4657" "050000100" "40f"),
    Figure("8-20", 0x6C,  0, False, 0x92,  0,   0, "",     0,   0, None, None),
    Figure("8-21", 0x56,  2, True,  0x92,  0,   0, "",     0,   0, 0x00, "02"),
    Figure("8-23", 0x5B,  1, False, 0x9D,  0,   0, "",     0,   0, None, "04"),
    Figure("8-24", 0x4F,  1, True,  0x9D,  0,   0, "",     0,   0, 0x00, None),
    Figure("8-25", 0x5D,  1, False, 0x9D,  0,   0, "",     0,   0, None, "02"),
]
# fmt: on

FIELDS = (
    "sis.start sis.checksum sis.checksum.status sis.length sis.length_repeat sis.control.reaction sis.service "
    "sis.sender sis.receiver sis.control.subaddresses sis.subaddress sis.talker sis.listener sis.status sis.raw"
).split()

BOOLEANS = {"False": "0", "True": "1"}  # how Wireshark 4.2 and later write them


def expected(figure: Figure) -> list[str]:
    """What tshark's fields must print for it."""
    count = len(figure.subaddresses.split(",")) if figure.subaddresses else 0
    return [
        "0x02",
        f"0x{figure.checksum:02x}",
        "1",
        str(figure.length),
        str(figure.length),
        str(int(figure.reaction)),
        f"0x{figure.service:02x}",
        str(figure.sender),
        str(figure.receiver),
        str(count),
        figure.subaddresses,
        str(figure.talker),
        str(figure.listener),
        "" if figure.status is None else f"0x{figure.status:02x}",
        figure.rest or "",
    ]


def test_every_header(tshark: Tshark) -> None:
    options = [option for name in FIELDS for option in ("-e", name)]
    lines = tshark.output("-r", str(CAPTURE), "-T", "fields", *options).splitlines()
    assert len(lines) == len(FIGURES)
    for figure, line in zip(FIGURES, lines, strict=True):
        cells = [BOOLEANS.get(cell, cell) for cell in line.split("\t")]
        assert cells == expected(figure), figure.number


def test_stations_are_counted(tshark: Tshark) -> None:
    """Endpoints count talkers and listeners, not sender and receiver fields: 8 talks in 2-13, 2 in 2-14, 3 in 2-15."""
    table = tshark.output("-r", str(CAPTURE), "-q", "-z", "endpoints,sis")
    sent = {}
    for line in table.splitlines():
        cells = line.replace(" bytes", "").split()  # Wireshark 4.6 writes the unit
        if len(cells) == 7 and cells[0].isdigit():
            sent[int(cells[0])] = (
                int(cells[3]),
                int(cells[5]),
            )  # packets sent, received
    talkers = [figure.talker for figure in FIGURES]
    listeners = [figure.listener for figure in FIGURES]
    for station in (2, 3, 8, 16):
        assert sent[station] == (
            talkers.count(station),
            listeners.count(station),
        ), station
