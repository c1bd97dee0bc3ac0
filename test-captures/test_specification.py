# SPDX-License-Identifier: GPL-2.0-or-later
"""Every telegram that the specification prints, against tables read from its figures by hand."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from sistap.dissected.wireshark.tshark import Tshark
from tables import BOOLEANS

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
    body: dict[str, str]  # further fields, without their "sis."; several values with commas


# fmt: off
FIGURES = [
    Figure("2-10", 0xE1,  5, False, 0x03, 16,   3, "2,8", 16,   3, None,
           {"device": "240", "subservice": "0x01", "raw": "00", "reaction_in": "6"}),
    Figure("2-11", 0xF4,  4, False, 0x03,  3,   2, "8",    3,   2, None,
           {"device": "240", "subservice": "0x01", "raw": "00", "reaction_in": "5", "routed_from": "1"}),
    Figure("2-12", 0xFA,  3, False, 0x03,  2,   8, "",     2,   8, None,
           {"device": "240", "subservice": "0x01", "raw": "00", "reaction_in": "4", "routed_from": "2"}),
    Figure("2-13", 0xE9,  3, True,  0x03,  2,   8, "",     8,   2, 0x00,
           {"device": "1", "subservice": "0xf1", "command_in": "3"}),
    Figure("2-14", 0xE3,  4, True,  0x03,  3,   2, "8",    2,   3, 0x00,
           {"device": "1", "subservice": "0xf1", "command_in": "2", "routed_from": "4"}),
    Figure("2-15", 0xD0,  5, True,  0x03, 16,   3, "2,8",  3,  16, 0x00,
           {"device": "1", "subservice": "0xf1", "command_in": "1", "routed_from": "5"}),
    Figure("6-14", 0xD7,  3, False, 0x03, 16,   3, "",    16,   3, None,
           {"device": "4", "subservice": "0x07", "init.baud_mask": "0x00"}),
    Figure("6-15", 0xCF,  3, False, 0x03, 16,   3, "",    16,   3, None,
           {"device": "4", "subservice": "0x07", "init.baud_mask": "0x08"}),
    Figure("6-20", 0xE1,  5, False, 0x03, 16,   3, "",    16,   3, None,
           {"device": "0", "subservice": "0x08", "init.test_time": "0.500000000", "init.baud_mask": "0x00"}),
    Figure("6-21", 0xAB,  5, False, 0x03, 16,   3, "",    16,   3, None,
           {"device": "0", "subservice": "0x08", "init.test_time": "0.800000000", "init.baud_mask": "0x08"}),
    Figure("6-24", 0xE9,  2, False, 0x03, 16, 255, "",    16, 255, None,
           {"device": "0", "subservice": "0xff"}),
    Figure("7-1",  0x8E, 12, False, 0x04, 16,   3, "",    16,   3, None,
           {"service": "0x04,0x00,0x00,0x00", "device": "16,16,16", "subservice": "0x01,0x03,0x04",
            "reaction_in": "13"}),
    Figure("7-2",  0xF8, 35, True,  0x04, 16,   3, "",     3,  16, 0x00,
           {"service": "0x04,0x00,0x00,0x00", "status": "0x00,0x00,0x00,0x00", "device": "16,16,16",
            "subservice": "0x01,0x03,0x04", "version": "01V01", "type_key": "CLC-D02,3M-FW", "init.baud_mask": "0x0f",
            "command_in": "12"}),
    Figure("8-20", 0x6C,  0, False, 0x92,  0,   0, "",     0,   0, None, {"reaction_in": "15"}),
    Figure("8-21", 0x56,  2, True,  0x92,  0,   0, "",     0,   0, 0x00, {"phase": "2", "command_in": "14"}),
    Figure("8-23", 0x5B,  1, False, 0x9D,  0,   0, "",     0,   0, None, {"phase": "4", "reaction_in": "17"}),
    Figure("8-24", 0x4F,  1, True,  0x9D,  0,   0, "",     0,   0, 0x00, {"command_in": "16"}),
    Figure("8-25", 0x5D,  1, False, 0x9D,  0,   0, "",     0,   0, None, {"phase": "2"}),
]
# fmt: on

HEADER = (
    "start checksum checksum.status length length_repeat control.reaction service sender receiver "
    "control.subaddresses subaddress talker listener status"
).split()
BODY = (
    "device subservice init.baud_mask init.test_time init.time version type_key phase error raw command_in "
    "reaction_in repeat_of routed_from"
).split()


def expected(figure: Figure) -> dict[str, str]:
    """What tshark's fields must print for it."""
    count = len(figure.subaddresses.split(",")) if figure.subaddresses else 0
    header = [
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
    ]
    return dict.fromkeys(BODY, "") | dict(zip(HEADER, header, strict=True)) | figure.body


def test_every_field(tshark: Tshark) -> None:
    names = HEADER + BODY
    options = [option for name in names for option in ("-e", f"sis.{name}")]
    lines = tshark.output("-2", "-r", str(CAPTURE), "-T", "fields", *options).splitlines()
    assert len(lines) == len(FIGURES)
    for figure, line in zip(FIGURES, lines, strict=True):
        cells = [BOOLEANS.get(cell, cell) for cell in line.split("\t")]
        assert dict(zip(names, cells, strict=True)) == expected(figure), figure.number


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
