# SPDX-License-Identifier: GPL-2.0-or-later
"""Serial lines over networks: which packet has which telegrams and lines, counted by hand in the captures' texts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

import bad_input
from bad_input import Packet
from make import HERE, Scenario, tcp_segment
from sistap.dissected.wireshark.tshark import Tshark

TELEGRAM = bytes.fromhex("02 D7 03 03 00 03 10 03 04 07 00")
PASSES = pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])


def found(tshark: Tshark, capture: str, fields: Sequence[str], *options: str) -> dict[int, list[str]]:
    """Return the values of these fields in each packet that has some."""
    path = HERE / f"{capture}.txt"
    names = [word for name in ("frame.number", *fields) for word in ("-e", name)]
    command = ["-r", str(path.with_suffix(".pcapng")), *options, *Scenario(path).options, "-T", "fields", *names]
    rows = (line.split("\t") for line in tshark.output(*command).splitlines())
    return {int(number): values for number, *values in rows if any(values)}


# Kinds: 0 text, 1 open, 2 prompt, 3 read, 4 write, 5 element, 6 asks, 7 error, 8 echo, 9 answer, 10 end.
LINES = {
    1: ["1", "", "", "2"],
    2: ["8,2", "BCD:21", "1,1", ""],
    5: ["3", "", "", "9"],  # 3 and 4 have its beginning; 6 only the LF after its CR
    7: ["8", "S-0-0051,7,R", "5", ""],  # an echo is no answer
    9: ["9", "", "5", ""],  # 8 has its beginning
    10: ["2", "", "5", ""],
    11: ["4", "", "", "12"],
    12: ["8,6", "P-0-4006,7,W,>", "11,11", ""],
    13: ["5", "", "", "14"],
    14: ["8,6", "1.5", "13,13", ""],
    15: ["10", "", "", "16"],
    16: ["8,2", "<", "15,15", ""],
    17: ["4", "", "", "19"],
    18: ["0", "␀<80>", "", ""],
    19: ["7,2", "", "17,17", ""],  # 20 has no end
    22: ["1", "", "", "23"],  # 21 is no command
    23: ["2", "", "22", ""],
}


@PASSES
def test_lines_are_joined_and_told_apart(passes: tuple[str, ...], tshark: Tshark) -> None:
    """In the first pass a command does not know its answer yet."""
    fields = ("sisascii.kind", "sisascii.text", "sis.command_in", "sis.reaction_in")
    known = len(fields) if passes else len(fields) - 1
    lines = found(tshark, "ascii-tcp", fields[:known], *passes)
    assert lines == {number: values[:known] for number, values in LINES.items()}


def test_what_has_no_end_is_still_there(tshark: Tshark) -> None:
    left = found(tshark, "ascii-tcp", ["tcp.segment_data"])
    assert bytes.fromhex(left[20][0].replace(":", "")) == b"S-0-0040,7"


TELNET = {4: "0xd7", 5: "0xd4", 6: "0xcf", 8: "0xc7", 10: "0xd4", 11: "0x5d", 12: "0x6c", 13: "0xea", 17: "0xd4"}


@PASSES
def test_telnet_is_taken_out(passes: tuple[str, ...], tshark: Tshark) -> None:
    telegrams = found(tshark, "tcp-telnet", ("sis.checksum", "sis.checksum.status"), *passes)
    assert telegrams == {number: [checksum, "1"] for number, checksum in TELNET.items()}


# A checksum, or the kind of a line.
RECOGNIZED = {
    **{1: ["0xd7", ""], 2: ["0xcf", ""]},
    **{4: ["0xd7", ""], 5: ["0xd4", ""]},
    **{6: ["", "1"], 7: ["", "3"]},
    **{8: ["0xd7", ""], 10: ["0xcf", ""], 11: ["0x5d", ""]},  # 9 may become a negotiation
    **{12: ["", "1"], 13: ["", "8,2"]},
}


@PASSES
def test_the_segment_that_is_recognized_may_end_anywhere(passes: tuple[str, ...], tshark: Tshark) -> None:
    assert found(tshark, "tcp-recognized", ("sis.checksum", "sisascii.kind"), *passes) == RECOGNIZED


# Whole telegrams, the bytes that were captured, and the checksums of what is whole there.
CUT = (
    (bytes.fromhex("FF FB 2C"), 3, ""),  # from here on it is Telnet
    (TELEGRAM * 2, 18, "0xd7"),
    (TELEGRAM * 2, 11, "0xd7"),
    (TELEGRAM * 2, 7, ""),
    (TELEGRAM + bytes.fromhex("FF F1"), 12, "0xd7"),
    (bytes.fromhex("FF F1") + TELEGRAM, 2, ""),
    (TELEGRAM, 11, "0xd7"),
)


def test_over_telnet_what_the_capture_has_cut_is_not_damaged(tshark: Tshark, tmp_path: Path) -> None:
    packets = []
    sequence = 1
    for data, captured, _ in CUT:
        packets.append(Packet(tcp_segment(4200, True, sequence, 1, data)[: 40 + captured], 40 + len(data)))
        sequence += len(data)
    bad_input.write(tmp_path / "cut.pcapng", packets, "ip")
    fields = ("sis.checksum", "_ws.short", "sis.length.short", "sis.start.missing")
    names = [word for name in fields for word in ("-e", name)]
    command = ["-r", str(tmp_path / "cut.pcapng"), "-d", "tcp.port==4200,sis", "-T", "fields", *names]
    rows = [line.split("\t") for line in tshark.output(*command).splitlines()]
    expected = [(checksums, captured < len(data)) for data, captured, checksums in CUT]
    assert [(row[0], bool(row[1])) for row in rows] == expected
    assert all(row[2:] == ["", ""] for row in rows)


def test_line_that_the_capture_has_cut_is_text(tshark: Tshark, tmp_path: Path) -> None:
    """It may have said something else: another value, another drive."""
    lines = [(b"BCD:21\r", 7), (b"BCD:21\r", 5), (b"S-0-0051,7,R\r12.34\r", 16), (b"S-0-0044,7,W,12\r\n", 15)]
    packets = []
    sequence = 1
    for data, captured in lines:
        packets.append(Packet(tcp_segment(4001, True, sequence, 1, data)[: 40 + captured], 40 + len(data)))
        sequence += len(data)
    bad_input.write(tmp_path / "cut.pcapng", packets, "ip")
    command = ["-r", str(tmp_path / "cut.pcapng"), "-d", "tcp.port==4001,sisascii", "-T", "fields"]
    rows = tshark.output(*command, "-e", "sisascii.kind", "-e", "sisascii.text", "-e", "_ws.col.Info").splitlines()
    kinds, texts, infos = zip(*(row.split("\t") for row in rows), strict=True)
    assert kinds == ("1", "0", "3,0", "0")
    assert texts == ("", "BCD:2", "12.", "S-0-0044,7,W,12")
    assert ["Packet size limited" in info for info in infos] == [False, True, True, True]


def test_datagrams_are_not_joined(tshark: Tshark) -> None:
    telegrams = found(tshark, "udp", ("sis.checksum", "sis.length.short", "sis.start.missing"))
    assert {number: values[0] for number, values in telegrams.items()} == {
        **{1: "0xd7", 2: "0xc7", 3: "0xcf,0xe9"},
        **{4: "", 5: ""},
    }
    assert telegrams[4][1]
    assert telegrams[5][2]


@PASSES
def test_udp_is_recognized_only_if_asked(passes: tuple[str, ...], tshark: Tshark) -> None:
    """What follows on the same two ports is SIS, too: packet 4 begins no whole telegram."""
    capture = str(HERE / "udp.pcapng")
    assert tshark.output("-r", capture, *passes, "-Y", "sis") == ""
    asked = tshark.output("-r", capture, *passes, "-o", "sis.udp_heuristic:TRUE", "-Y", "sis")
    assert [line.split()[0] for line in asked.splitlines()] == ["1", "2", "3", "4", "5", "6"]
