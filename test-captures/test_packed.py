# SPDX-License-Identifier: GPL-2.0-or-later
"""Packets that hold more than one telegram, or bytes that belong to none."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import bad_input
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.sis.telegram import build

READ_PHASE = 0x12
COMMAND = build(READ_PHASE, 16, 3)
REACTION = build(READ_PHASE, 16, 3, b"\x00\x02", reaction=True)
ROUTED = build(READ_PHASE, 16, 3, subaddresses=b"\x02")  # to a station behind 3
NOISE = b"\xff\xee\xdd"
MOST_BYTES = 32_768  # of a packet of bare telegrams
DECODED = MOST_BYTES // len(COMMAND)


def written(folder: Path, *packets: bytes) -> Path:
    """Write packets of bare telegrams; return the capture."""
    bad_input.write(folder / "packed.pcapng", packets)
    return folder / "packed.pcapng"


@pytest.fixture
def noisy(tmp_path: Path) -> Path:
    return written(tmp_path, COMMAND + NOISE, REACTION + NOISE)


def test_conversations_count_telegrams_only(noisy: Path, tshark: Tshark) -> None:
    table = tshark.output("-q", "-r", str(noisy), "-z", "conv,sis", "-z", "endpoints,sis")
    row = next(line for line in table.splitlines() if "<->" in line)
    assert re.findall(r"(\d+) bytes", row) == [str(n) for n in (len(REACTION), len(COMMAND), len(COMMAND + REACTION))]
    stations = {
        cells[0]: cells[2] for line in table.splitlines() if (cells := line.split()) and cells[0] in ("3", "16")
    }
    assert stations["3"] == str(len(COMMAND + REACTION))


def streams(tshark: Tshark, capture: Path) -> list[str]:
    """Return the stream of each packet; "": none."""
    return tshark.output("-r", str(capture), "-T", "fields", "-e", "sis.stream").split("\n")[:-1]


def test_two_routes_in_a_packet_are_two_streams(tshark: Tshark, tmp_path: Path) -> None:
    assert streams(tshark, written(tmp_path, COMMAND + ROUTED, REACTION)) == ["0,1", "0"]


def test_streams(tshark: Tshark, tmp_path: Path) -> None:
    """16 and 3, 16 and 4, 16 and what is behind 3. Damaged telegrams and those without a command have none; a device
    may swap the addresses.
    """
    to_4, swapped = build(READ_PHASE, 16, 4), build(READ_PHASE, 3, 16, b"\x00\x02", reaction=True)
    damaged, unasked = COMMAND[:-1] + b"\5", build(READ_PHASE, 16, 9, b"\x00\x02", reaction=True)
    capture = written(tmp_path, COMMAND, REACTION, to_4, ROUTED, damaged, COMMAND, swapped, unasked)
    assert streams(tshark, capture) == ["0", "0", "1", "2", "", "0", "0", ""]


def test_a_reaction_without_a_command_is_no_stream(tshark: Tshark, tmp_path: Path) -> None:
    unasked = build(READ_PHASE, 16, 9, b"\x00\x02", reaction=True)
    capture = written(tmp_path, unasked, COMMAND, REACTION)
    assert streams(tshark, capture) == ["", "0", "0"]


@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one_pass", "two_passes"])
def test_each_telegram_of_a_packet_has_its_own_relations(
    passes: tuple[str, ...], tshark: Tshark, tmp_path: Path
) -> None:
    to = [build(READ_PHASE, 16, station) for station in (3, 4, 5)]
    back = [build(READ_PHASE, 16, station, b"\x00\x02", reaction=True) for station in (5, 3, 4)]
    capture = written(tmp_path, to[0] + to[1], to[2], b"".join(back))
    fields = ("-T", "fields", "-e", "sis.stream", "-e", "sis.command_in")
    shown = tshark.output("-r", str(capture), *passes, *fields).splitlines()
    assert shown == ["0,1\t", "2\t", "2,0,1\t2,1,1"]


def test_a_packet_that_is_too_long_ends_as_bytes(tshark: Tshark, tmp_path: Path) -> None:
    full, more = COMMAND * DECODED, COMMAND * (DECODED + 2)
    capture = written(tmp_path, full, more)
    count = "sis.sender", "sis.raw", "sis.telegrams.many"
    fields = [option for name in count for option in ("-e", name)]
    shown = [line.split("\t") for line in tshark.output("-r", str(capture), "-T", "fields", *fields).splitlines()]
    assert [(line[0].count(",") + 1, line[1], bool(line[2])) for line in shown] == [
        (DECODED, "", False),
        (DECODED, (2 * COMMAND).hex(), True),
    ]


@pytest.mark.attack("32,000 telegrams with six notes each in a packet", "the first 4,096 are decoded")
def test_wireshark_does_not_refuse_the_tree(tshark: Tshark, tmp_path: Path) -> None:
    """It stops a dissector that makes a million items."""
    noted = bad_input.with_checksum(bytes.fromhex("02 00 00 00 E0 60 80 F9"))
    capture = written(tmp_path, noted * 32_000)
    done = tshark.run(["-r", str(capture), "-V"])
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.count("Start character") == DECODED
    assert "issector bug" not in done.stdout


@pytest.mark.parametrize("lost", [1, 3])
def test_the_telegram_after_lost_characters_is_whole(lost: int, tshark: Tshark, tmp_path: Path) -> None:
    """The length of the damaged one counts the first characters of the next one."""
    damaged = build(READ_PHASE, 16, 3, b"\x00\x04", reaction=True)[:-lost]
    capture = written(tmp_path, damaged + COMMAND + REACTION)
    talkers = tshark.output("-r", str(capture), "-T", "fields", "-e", "sis.talker").strip()
    assert talkers.endswith("16,3")  # the damaged one, whose talker is not known, comes before
