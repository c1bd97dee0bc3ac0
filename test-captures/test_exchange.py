# SPDX-License-Identifier: GPL-2.0-or-later
"""Commands, reactions, repeats and routed telegrams: their relations, worked out by hand from the facts."""

from __future__ import annotations

from pathlib import Path

import pytest

from bad_input import write
from make import Scenario, tcp_segment
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.sis.telegram import build
from tables import HERE, Table, check, shown

FIELDS = "reaction_in command_in reaction_time repeat_of routed_from"
EXPERTS = "command.unanswered command.repeat reaction.unasked reaction.again"

EXCHANGES: Table = {
    # Command and reaction; its time is the silence between them
    1: "reaction_in=2",
    2: "command_in=1; reaction_time=0.012500000",
    # A poll again is no repeat, the first was answered; this device swaps the addresses
    3: "reaction_in=4",
    4: "command_in=3; reaction_time=0.020000000",
    # Two slaves: 3 is silent, 4 answers
    5: "command.unanswered",
    6: "reaction_in=7",
    7: "command_in=6; reaction_time=0.025000000",
    # Two masters with the same slave
    8: "reaction_in=11",
    9: "reaction_in=10",
    10: "command_in=9; reaction_time=0.025000000",
    11: "command_in=8; reaction_time=0.093333328",
    # Another service
    12: "reaction_in=14",
    13: "reaction.unasked",
    14: "command_in=12; reaction_time=0.066041662",
    # Another element
    15: "reaction_in=17",
    16: "reaction.unasked",
    17: "command_in=15; reaction_time=0.066041662",
    # Another device
    18: "reaction_in=20",
    19: "reaction.unasked",
    20: "command_in=18; reaction_time=0.066041662",
    # Another telegram number, or none
    21: "reaction_in=23",
    22: "reaction.unasked",
    23: "command_in=21; reaction_time=0.061458330",
    24: "reaction_in=26",
    25: "reaction.unasked",
    26: "command_in=24; reaction_time=0.060312497",
    # The right telegram number, addresses swapped
    27: "reaction_in=28",
    28: "command_in=27; reaction_time=0.025000000",
    # Repeats: the reaction belongs to the last of them
    29: "command.unanswered",
    30: "repeat_of=29; command.repeat; command.unanswered",
    31: "repeat_of=29; command.repeat; reaction_in=32",
    32: "command_in=31; reaction_time=0.025000000",
    33: "command_in=31; reaction.again",
    # A late reaction of device 5 is none of the command to device 6
    34: "command.unanswered",
    35: "reaction_in=37",
    36: "reaction.unasked",
    37: "command_in=35; reaction_time=0.066041662",
    # Groups and broadcasts are not answered; point-to-point is
    42: "reaction_in=43",
    43: "command_in=42; reaction_time=0.025000000",
    # A damaged reaction, then the repeat
    44: "command.unanswered",
    46: "repeat_of=44; command.repeat; reaction_in=47",
    47: "command_in=46; reaction_time=0.025000000",
    # A damaged command, then a good one
    49: "reaction_in=50",
    50: "command_in=49; reaction_time=0.025000000",
    # A reaction without a command
    51: "reaction.unasked",
    # Refused, with nothing but the status
    52: "reaction_in=53",
    53: "command_in=52; reaction_time=0.025000000",
    # Masters that ask each other
    54: "reaction_in=56",
    55: "reaction_in=57",
    56: "command_in=54; reaction_time=0.058020831",
    57: "command_in=55; reaction_time=0.060312497",
    # A pause inside the command, and another rate: from its last character
    58: "reaction_in=59",
    59: "command_in=58; reaction_time=0.030000000",
    60: "reaction_in=61",
    61: "command_in=60; reaction_time=0.001500000",
    # Two directions, each on its own line of the tap
    62: "reaction_in=63",
    63: "command_in=62; reaction_time=0.001500000",
    # Nothing after it says that it stays unanswered
    # A damaged command: its reaction is not that of the command before, which was answered
    65: "reaction_in=66",
    66: "command_in=65; reaction_time=0.001500000",
    68: "reaction.unasked",
    # A token, to and fro
    # Behind two routers, the last address says whether it is answered
    74: "reaction_in=75",
    75: "command_in=74; reaction_time=0.001500000",
    # The master went on without a reaction; what comes after a damaged command is none of the one before
    76: "command.unanswered",
    79: "reaction.unasked",
}

REPEATS: Table = {
    # Unanswered
    1: "command.unanswered",
    2: "repeat_of=1; command.repeat; reaction_in=3",
    3: "command_in=2",
    # A cyclic poll: answered each time
    4: "reaction_in=5",
    5: "command_in=4",
    # The steps of a long reading
    6: "reaction_in=7",
    7: "command_in=6",
    8: "reaction_in=9",
    9: "command_in=8",
    10: "reaction_in=11",
    11: "command_in=10",
    # The same telegram number: the slave sends the reaction that it has kept
    12: "reaction_in=13",
    13: "command_in=12",
    14: "repeat_of=12; command.repeat; reaction_in=15",
    15: "command_in=14",
    # Number 0 is always processed
    16: "reaction_in=17",
    17: "command_in=16",
    18: "reaction_in=19",
    19: "command_in=18",
    # Number 0 unanswered
    20: "command.unanswered",
    21: "repeat_of=20; command.repeat; reaction_in=22",
    22: "command_in=21",
    # The same number with another static header
    23: "reaction_in=24",
    24: "command_in=23",
    25: "reaction_in=26",
    26: "command_in=25",
    # A number between: only the last reaction is kept
    27: "reaction_in=28",
    28: "command_in=27",
    29: "reaction_in=30",
    30: "command_in=29",
    31: "reaction_in=32",
    32: "command_in=31",
    # Another station between
    33: "command.unanswered",
    34: "reaction_in=35",
    35: "command_in=34",
    36: "repeat_of=33; command.repeat; reaction_in=37",
    37: "command_in=36",
    # Another master is no repeat
    38: "command.unanswered",
    39: "reaction_in=40",
    40: "command_in=39",
    # Another command between, then it again: no repeat of the one before it
    41: "command.unanswered",
    42: "reaction_in=43",
    43: "command_in=42",
    # Three times, each names the first
    44: "command.unanswered",
    45: "repeat_of=44; command.repeat; command.unanswered",
    46: "repeat_of=44; command.repeat; reaction_in=47",
    47: "command_in=46",
    # One that was answered with an error was answered
    48: "reaction_in=49",
    49: "command_in=48",
    50: "reaction_in=51",
    51: "command_in=50",
}

ROUTES: Table = {
    # Two drives behind one router, one after the other
    1: "reaction_in=4",
    2: "reaction_in=3; routed_from=1",
    3: "command_in=2; reaction_time=0.025000000",
    4: "command_in=1; routed_from=3; reaction_time=0.093333328",
    5: "reaction_in=8",
    6: "reaction_in=7; routed_from=5",
    7: "command_in=6; reaction_time=0.025000000",
    8: "command_in=5; routed_from=7; reaction_time=0.093333328",
    # What router 3 asks by itself comes from nowhere
    9: "reaction_in=10",
    10: "command_in=9; reaction_time=0.025000000",
    # Two masters, their commands interleaved, with the same useful data
    11: "reaction_in=15",
    12: "reaction_in=18",
    13: "reaction_in=14; routed_from=11",
    14: "command_in=13; reaction_time=0.025000000",
    15: "command_in=11; routed_from=14; reaction_time=0.127499992",
    16: "reaction_in=17; routed_from=12",
    17: "command_in=16; reaction_time=0.025000000",
    18: "command_in=12; routed_from=17; reaction_time=0.198124986",
    # Another service, another drive, another telegram number: not what the router sent on
    19: "command.unanswered",
    20: "command.unanswered",
    21: "command.unanswered",
    22: "command.unanswered",
    23: "reaction_in=24; routed_from=19",
    24: "command_in=23; reaction_time=0.025000000",
    # Read through the router: the same parameter on both levels
    25: "reaction_in=28",
    26: "reaction_in=27; routed_from=25",
    27: "command_in=26; reaction_time=0.025000000",
    28: "command_in=25; routed_from=27; reaction_time=0.104791658",
    # A reaction on the other level, with the same addresses: none of this command
    29: "reaction_in=31",
    30: "reaction.unasked",
    31: "command_in=29; reaction_time=0.060312497",
}

ROUTES_INTERLEAVED: Table = {
    1: "reaction_in=6",
    2: "reaction_in=5; routed_from=1",
    3: "reaction_in=8",
    4: "reaction_in=7; routed_from=3",
    5: "command_in=2",
    6: "command_in=1; routed_from=5",
    7: "command_in=4",
    8: "command_in=3; routed_from=7",
    10: "reaction_in=12",
    12: "command_in=10",
    13: "reaction_in=14; routed_from=9",
    14: "command_in=13",
    15: "routed_from=11",
    16: "reaction_in=18",
    18: "command_in=16",
    19: "routed_from=17",
    # 20 is lost, and sent again
    21: "reaction_in=24",
    22: "reaction_in=23; routed_from=21",
    23: "command_in=22",
    24: "command_in=21; routed_from=23",
}

EXCHANGES_SWAPPED: Table = {
    1: "reaction_in=3",
    2: "reaction.unasked",
    3: "command_in=1",
}

TOKENS: Table = {
    # Right after it, and once more
    1: "reaction_in=2",
    2: "command_in=1; reaction_time=0.025000000; trs.verdict=0",
    3: "command_in=1; reaction.again",
    4: "reaction_in=5",
    5: "command_in=4; reaction_time=0.025000000; trs.verdict=0",
    # Of tokens that nobody heard
    6: "reaction.unasked",
    7: "reaction_in=8",
    8: "command_in=7; reaction_time=0.025000000; trs.verdict=0",
    9: "reaction.unasked",
    # Too late
    10: "reaction_in=11",
    11: "command_in=10; reaction_time=0.060000000; trs.verdict=1",
    # Not answered: no fault. 25 + 8 x 1.145833 + 25 ms
    13: "reaction_in=15",
    14: "reaction.unasked",
    15: "command_in=13; reaction_time=0.059166664; trs.verdict=1",
}

# Two interfaces, the directions of one bus: silence is that of a line, all else of the bus. Between two telegrams of a
# line there are two silences of 25 ms and, less one, the characters (1.145833 ms) of the telegram of the other line
DUPLEX: Table = {
    1: "reaction_in=2",
    2: "command_in=1; reaction_time=0.025000000",
    3: "reaction_in=4; silence_before=0.061458330",
    4: "command_in=3; reaction_time=0.025000000; silence_before=0.060312497; tza.set_in=1; tza.verdict=0",
    5: "reaction_in=6; silence_before=0.061458330; tza.set_in=1; tza.verdict=1; tza.exceeded",
    6: "command_in=5; reaction_time=0.025000000; silence_before=0.068874998; tza.set_in=1; tza.verdict=0",
}

# What the first section told and asked is unknown in the second
SECTIONS: Table = {
    1: "stream=0; reaction_in=2; parameter.name=Velocity data scaling type",
    2: "stream=0; command_in=1; parameter.name=Velocity data scaling type",
    3: "stream=0; reaction_in=4; parameter.name=Speed",
    4: "stream=0; command_in=3; parameter.name=Speed",
    5: "stream=1",
    6: "stream=1",
    7: "stream=0; tza.set_in=5; command.unanswered",
    8: "stream=2; tza.set_in=5; unanswered_before=7",
    9: "reaction.unasked",
    10: "stream=3",
    11: "stream=4; reaction_in=12; parameter.name=Velocity data scaling type",
    12: "stream=4; command_in=11; parameter.name=Velocity data scaling type",
    13: "stream=5; reaction_in=14",
    14: "stream=5; command_in=13",
}


# Chapter 2.4 (a damaged command, point to point) and fig. 2-9 (address 128).
POINT_TO_POINT: Table = {
    # A wrong checksum, and the answer to it
    2: "command_in=1; reaction.to_damaged",
    3: "reaction_in=4",
    4: "command_in=3",
    # Lengths that differ: to which command is not certain
    6: "reaction.to_damaged",
    # Nothing damaged before it
    7: "reaction.unasked",
    # A good command came after the damaged one; that is without a reaction before frame 13
    9: "command.unanswered",
    10: "reaction.unasked",
    # Other addresses
    12: "reaction.to_damaged",
    # Not answered, then damaged when it came again, then the same again
    13: "command.unanswered",
    15: "command_in=14; reaction.to_damaged",
    16: "reaction_in=17; repeat_of=13; command.repeat",
    17: "command_in=16",
    # Long data: no piece is missing
    18: "reaction_in=19",
    19: "command_in=18; sequence.whole_in=25",
    21: "command_in=20; reaction.to_damaged",
    23: "command_in=22; reaction.to_damaged",
    24: "reaction_in=25",
    25: "command_in=24; sequence.length=4",
    # The number of the station
    27: "command_in=26; reaction.to_damaged",
    # A status that no document gives for damage
    29: "reaction.unasked",
    # Answered with the station's own number
    31: "reaction.unasked",
}


def test_exchanges(tshark: Tshark) -> None:
    check(tshark, "exchanges", FIELDS, EXPERTS, EXCHANGES)


def test_repeats(tshark: Tshark) -> None:
    check(tshark, "repeats", "reaction_in command_in repeat_of", EXPERTS, REPEATS)


def test_routes(tshark: Tshark) -> None:
    check(tshark, "routes", FIELDS, EXPERTS, ROUTES)


def test_routes_interleaved(tshark: Tshark) -> None:
    check(tshark, "routes-interleaved", "reaction_in command_in routed_from", "reaction.unasked", ROUTES_INTERLEAVED)


def test_exchanges_swapped(tshark: Tshark) -> None:
    check(tshark, "exchanges-swapped", "reaction_in command_in", "reaction.unasked", EXCHANGES_SWAPPED)


def test_a_reaction_to_a_token_comes_before_the_next_command(tshark: Tshark) -> None:
    check(tshark, "tokens", f"{FIELDS} trs.verdict", EXPERTS, TOKENS, "-o", "sis.trs_ms:50")


def test_two_directions_are_one_bus(tshark: Tshark) -> None:
    fields = "reaction_in command_in reaction_time silence_before tza.set_in tza.verdict"
    check(tshark, "duplex", fields, "tza.exceeded command.unanswered reaction.unasked", DUPLEX)


def test_sections_are_buses_of_their_own(tshark: Tshark) -> None:
    fields = "stream reaction_in command_in routed_from unanswered_before tza.set_in parameter.name"
    check(tshark, "sections", fields, "command.unanswered reaction.unasked", SECTIONS)


def check_many_routes(tshark: Tshark, count: int, capture: Path) -> None:
    """Make commands wait for their routers; the first and the last of them are routed on, once each."""
    routes = [bytes(1 + number // 120**place % 120 for place in range(3)) for number in range(count)]
    waiting = [build(0x12, 16, 3, subaddresses=route) for route in routes]
    passed_on = [build(0x12, 3, route[0], subaddresses=route[1:]) for route in (routes[0], routes[-1])]
    write(capture, [*waiting, *passed_on, *passed_on])
    frames = shown(tshark, capture, "routed_from")
    found = {number: cells["routed_from"] for number, cells in frames.items() if cells}
    assert found == {count + 1: "1", count + 2: str(count)}


@pytest.mark.attack("commands through thousands of routers, in the plugin", "each costs the same")
@pytest.mark.thorough
@pytest.mark.timeout(120)
def test_many_commands_wait_for_their_routers(tshark: Tshark, tmp_path: Path) -> None:
    """Searching all of them for every command would take minutes."""
    check_many_routes(tshark, 100_000, tmp_path / "many.pcapng")


def check_many_connections(tshark: Tshark, most_kilobytes: float, folder: Path) -> None:
    """Compare the memory of few and of many connections; each tells its own bus a limit, and accepts it."""
    few, many = 2_000, 22_000
    told = build(0x03, 16, 255, b"\xff\x01\x28\x00") + build(0x03, 16, 255, b"\xff")
    used = []
    for count in (few, many):
        capture = folder / f"{count}.pcapng"
        segments = (tcp_segment(1024 + number, True, 1000, 0, told) for number in range(count))
        capture.write_bytes(
            pcapng.section_header("", "")
            + pcapng.interface_description(pcapng.Interface(228, "tcp"))
            + b"".join(pcapng.enhanced_packet(0, 10**18 + 10**6 * at, data) for at, data in enumerate(segments))
        )
        used.append(tshark.usage(["-r", str(capture)]).kilobytes)
    assert (used[1] - used[0]) / (many - few) < most_kilobytes


@pytest.mark.attack("160,000 TCP connections, each a bus", "each costs a few kilobytes")
@pytest.mark.thorough
def test_a_connection_costs_little(tshark: Tshark, tmp_path: Path) -> None:
    """Of 3.5 kB, 1.9 are Wireshark's own."""
    check_many_connections(tshark, 5, tmp_path)


def test_over_tcp_a_master_need_not_wait(tshark: Tshark, tmp_path: Path) -> None:
    """Its next command, to another station, does not give up the one before; a reaction that never comes does."""
    asked = [(3, False), (4, False), (3, True), (5, False)]
    segments = [
        tcp_segment(
            1024,
            not is_reaction,
            1000 + 10 * number,
            1000,
            build(0x12, 16, station, b"\0\2" * is_reaction, reaction=is_reaction),
        )
        for number, (station, is_reaction) in enumerate(asked)
    ]
    capture = tmp_path / "tcp.pcapng"
    capture.write_bytes(
        pcapng.section_header("", "")
        + pcapng.interface_description(pcapng.Interface(228, "tcp"))
        + b"".join(pcapng.enhanced_packet(0, 10**18 + 10**6 * at, data) for at, data in enumerate(segments))
    )
    found = shown(tshark, capture, "reaction_in command.unanswered", "-2", "-d", "tcp.port==1024,sis")
    assert [*found[1]] == ["reaction_in"]
    assert [*found[2]] == ["command.unanswered"]


def test_point_to_point(tshark: Tshark) -> None:
    fields = "reaction_in command_in repeat_of sequence.whole_in sequence.length"
    experts = f"{EXPERTS} reaction.to_damaged sequence.piece_missing"
    check(tshark, "point-to-point", fields, experts, POINT_TO_POINT)
    own_number = tshark.output("-r", str(HERE / "point-to-point.pcapng"), "-V", "-Y", "frame.number == 31")
    assert "A command to 128 is answered with 128, not with the station's own number" in own_number


def test_lengths_that_differ_are_answered_point_to_point(tshark: Tshark, tmp_path: Path) -> None:
    """Without the tap, such a command is a telegram, so its answer is certain (0xF2, chapters 2.3 and 2.4)."""
    lines = ["@link sis", "telegram 02 5C 00 01 00 12 10 80", "reaction 16>128 12 F2"]
    (tmp_path / "bare.txt").write_text("\n".join(lines))
    (tmp_path / "bare.pcapng").write_bytes(Scenario(tmp_path / "bare.txt").capture())
    frames = shown(tshark, tmp_path / "bare.pcapng", "command_in reaction.to_damaged reaction.unasked")
    assert frames[2].keys() == {"command_in", "reaction.to_damaged"}
    assert frames[2]["command_in"] == "1"
