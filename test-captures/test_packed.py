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


def followed(tshark: Tshark, capture: Path, stream: int) -> list[str]:
    """Return the telegrams of a stream."""
    text = tshark.output("-q", "-r", str(capture), "-z", f"follow,sis,raw,{stream}")
    return re.findall(r"^\t?([0-9a-f]+)$", text, re.MULTILINE)


@pytest.fixture
def noisy(tmp_path: Path) -> Path:
    return written(tmp_path, COMMAND + NOISE, REACTION + NOISE)


def test_follow_leaves_out_what_follows_a_telegram(noisy: Path, tshark: Tshark) -> None:
    assert followed(tshark, noisy, 0) == [COMMAND.hex(), REACTION.hex()]


def test_conversations_count_telegrams_only(noisy: Path, tshark: Tshark) -> None:
    table = tshark.output("-q", "-r", str(noisy), "-z", "conv,sis", "-z", "endpoints,sis")
    row = next(line for line in table.splitlines() if "<->" in line)
    assert re.findall(r"(\d+) bytes", row) == [str(n) for n in (len(REACTION), len(COMMAND), len(COMMAND + REACTION))]
    stations = {
        cells[0]: cells[2] for line in table.splitlines() if (cells := line.split()) and cells[0] in ("3", "16")
    }
    assert stations["3"] == str(len(COMMAND + REACTION))


def test_stations_said_their_telegrams_only(noisy: Path, tshark: Tshark) -> None:
    """The row of all stations counts every character of the line."""
    text = tshark.output("-q", "-r", str(noisy), "-z", "sis,bus")
    rows = {cells[0]: cells[8] for line in text.splitlines() if len(cells := [c.strip() for c in line.split("|")]) > 8}
    counted = {"16": len(COMMAND), "3": len(REACTION), "All": len(COMMAND + REACTION + 2 * NOISE)}
    assert {station: rows[station] for station in counted} == {name: str(n) for name, n in counted.items()}


def test_follow_keeps_two_routes_in_a_packet_apart(tshark: Tshark, tmp_path: Path) -> None:
    capture = written(tmp_path, COMMAND + ROUTED, REACTION)
    assert followed(tshark, capture, 0) == [COMMAND.hex(), REACTION.hex()]
    assert followed(tshark, capture, 1) == [ROUTED.hex()]


def test_a_reaction_without_a_command_is_no_stream(tshark: Tshark, tmp_path: Path) -> None:
    """Otherwise Follow would offer a stream without a telegram."""
    unasked = build(READ_PHASE, 16, 9, b"\x00\x02", reaction=True)
    capture = written(tmp_path, unasked, COMMAND, REACTION)
    assert tshark.output("-r", str(capture), "-T", "fields", "-e", "sis.stream").split() == ["0", "0"]


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
