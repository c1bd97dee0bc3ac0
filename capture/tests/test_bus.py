# SPDX-License-Identifier: GPL-2.0-or-later
"""The virtual bus: bytes compared with the specification's figures, times, faults, and what listeners receive."""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import random
import re
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
from commands import run
from hypothesis import given, settings
from hypothesis import strategies as st
from portable import WINDOWS, posix, signals, sockets, terminals

from sisbus.playing.characters import NO_FAULTS, Faults, Played, SentCharacter, hear, reads, uncertainty
from sisbus.playing.player import Times
from sisbus.scenarios.demo import commands, read_parameter
from sisbus.scenarios.scenario import DEFAULT, Playing, load
from sisbus.wires import taps as wires
from sisbus.wires.taps import Taps
from sisbus.wires.wire import Pace
from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.sis.telegram import build, checksum_good, parse
from sistap.tap.wire import protocol

if sys.platform != "win32":
    from sisbus.wires import pseudo_terminal
    from sisbus.wires.pseudo_terminal import PseudoTerminal

BUS = [sys.executable, "-m", "sistap", "bus"]
TIMEOUT_S = 60
listening_only_if_asked = posix("a bus listens by itself")
LINE = LineSettings()  # 9600 8E1

MANY_FAULTS = Faults(parity=0.02, break_=0.02, loss=0.02, checksum=0.1, pause=0.02)
MANY_FAULTS_TEXT = "parity=0.02,break=0.02,loss=0.02,checksum=0.1,pause=0.02"


def octets(figure: str) -> bytes:
    return bytes.fromhex(figure)


# -- What is said ---------------------------------------------------------------------------------------------------


def bus(
    line: LineSettings, seed: int = 1, cycles: int = 0, faults: Faults = NO_FAULTS, rates: Sequence[int] = ()
) -> Iterator[Played]:
    """Make the demo: yield everything that is sent on its bus, in order."""
    return load(DEFAULT).play(line, Playing(seed, cycles, faults, rates))


def telegrams(line: LineSettings = LINE, seed: int = 1, cycles: int = 1) -> list[bytes]:
    return [played.sent for played in bus(line, seed, cycles) if "ascii" not in played.marks]


def test_every_telegram_has_zero_checksum_and_equal_right_lengths() -> None:
    for telegram in telegrams(cycles=6):
        assert sum(telegram) % 256 == 0
        assert telegram[0] == 0x02
        assert telegram[2] == telegram[3] == len(telegram) - 8


def test_every_command_is_answered_with_its_addresses_but_the_broadcast() -> None:
    said = telegrams(cycles=3)
    place = 0
    while place < len(said):
        command = parse(said[place])
        assert not command.reaction
        place += 1
        if command.receiver == 255:
            continue
        reaction = parse(said[place])
        place += 1
        assert reaction.control == command.control | 0x10
        assert reaction[1:6] == command[1:6]  # service, addresses, subaddresses, telegram number


@pytest.mark.parametrize(
    ("baud", "figure"),
    [
        # fig. 6-14 and 6-15 with the device address 03 instead of 04, so a checksum greater by 1
        (9600, "02 D8 03 03 00 03 10 03 03 07 00"),
        (115200, "02 D0 03 03 00 03 10 03 03 07 08"),
        # masks of fig. 6-11: D8 less the mask
        (19200, "02 D7 03 03 00 03 10 03 03 07 01"),
        (38400, "02 D6 03 03 00 03 10 03 03 07 02"),
        (57600, "02 D4 03 03 00 03 10 03 03 07 04"),
    ],
)
def test_initialization_sets_the_rate_of_the_line(baud: int, figure: str) -> None:
    assert octets(figure) in telegrams(LINE._replace(baud=baud))


def test_a_rate_without_a_mask_is_not_set() -> None:
    initialized = [telegram for telegram in telegrams(LINE._replace(baud=250000)) if telegram[5] == 0x03]
    assert initialized
    assert all(parse(telegram).body[1] != 0x07 for telegram in initialized)


def test_the_initialization_of_a_drive() -> None:
    said = telegrams()
    begin = said.index(octets("02 D8 03 03 00 03 10 03 03 07 00"))
    # checksums by hand: the sum of all bytes is 0 modulo 256
    assert said[begin + 1] == octets("02 C8 03 03 10 03 10 03 00 03 07")
    assert said[begin + 2] == octets("02 AA 04 04 00 03 10 03 03 01 32 00")  # TrS 50 ms
    assert said[begin + 4] == octets("02 D6 04 04 00 03 10 03 03 02 05 00")  # TzA 5 ms
    assert said[begin + 6] == octets("02 E5 04 04 00 03 10 03 03 03 F4 01")  # Tmas 500 ms
    accepted = said.index(octets("02 E9 02 02 00 03 10 FF 00 FF"))  # fig. 6-24
    assert not parse(said[accepted + 1]).reaction


def test_a_slow_line_gets_times_it_can_keep() -> None:
    assert Times.for_line(LINE) == (50, 5, 500)
    slow = LINE._replace(baud=300)  # a character takes 36.7 ms, four 146.7
    assert Times.for_line(slow) == (1470, 147, 14700)
    assert Times.for_line(LineSettings.parse(75, "8E2")) == (6400, 640, 64000)  # the slowest that --baud allows


def test_both_drives_are_identified() -> None:
    identified = {
        (header.receiver, header.body[1]) for header in map(parse, telegrams()) if header[1] == 0 and header[0] == 0
    }
    assert identified == {(drive, subservice) for drive in (3, 4) for subservice in (1, 3, 4)}


def test_what_the_loop_says() -> None:
    said = telegrams()
    # S-0-0044 (00 2C 00) at drive 3: name, attribute, unit, operating data (elements 2, 3, 4, 7 in bits 3 to 5)
    for control in (0x14, 0x1C, 0x24, 0x3C):
        assert build(0x10, 16, 3, bytes([control, 3, 0, 0x2C, 0x00])) in said
    # fig. 9.8 of the facts: length 1 (two bytes), binary, protected in phases 3 and 4 (bits 29, 30), factor 1
    assert build(0x10, 16, 3, octets("00 1C 03 01 00 01 60"), reaction=True) in said
    name = octets("00 14 03 1A 00 1A 00") + b"Velocity data scaling type"
    assert build(0x10, 16, 3, name, reaction=True) in said
    # 0x4001: it has no unit; 0x1001: P-0-0999 (bit 15 set: 83E7) is not there (fig. 8-48)
    assert build(0x10, 16, 3, octets("01 24 03 01 40"), reaction=True) in said
    missing = said.index(build(0x10, 16, 3, octets("3C 03 00 E7 83")))
    assert parse(said[missing + 1]).body == octets("01 3C 03 01 10")
    # phase 4
    assert build(0x12, 16, 4, octets("00 04"), reaction=True) in said
    # routed via 3 and 2 to 8: two subaddresses, control 02 and 12 (fig. 2-10, 2-15)
    routed = said.index(octets("02 CE 04 04 02 00 10 03 02 08 08 01"))
    assert said[routed + 1] == octets("02 9A 0A 0A 12 00 10 03 02 08 00 08 01 30 31 56 30 31")
    # a numbered write of 1000.0000 rpm to S-0-0036: control 08, number 01 before the body
    assert octets("02 9E 0A 0A 08 1F 10 03 01 3C 03 00 24 00 80 96 98 00") in said


def test_values_change_from_cycle_to_cycle() -> None:
    written = [parse(telegram) for telegram in telegrams(cycles=4) if telegram[4:8] == octets("08 1F 10 03")]
    assert [header.number for header in written] == [1, 2, 3, 4]
    assert len({header.body for header in written}) == 4


# -- When it is said ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("baud", [300, 9600, 115200])
def test_times_are_possible_and_keep_what_the_master_set(baud: int) -> None:
    line = LINE._replace(baud=baud)
    character_ns = line.character_ns
    limits = Times.for_line(line)
    end = 0
    for played in bus(line, 1, 1):
        times = [character.time_ns for character in played.characters]
        intervals = [later - earlier for earlier, later in zip(times, times[1:], strict=False)]
        assert min(intervals) >= character_ns
        assert max(intervals) < limits.tza * 1_000_000
        silence = times[0] - character_ns - end
        if end:
            assert silence > limits.tza * 1_000_000  # else no station would recognise the start
        if "ascii" not in played.marks and parse(played.sent).reaction:
            assert silence < limits.trs * 1_000_000
        assert played.time_ns == times[0]
        end = times[-1]


def test_same_seed_same_bus_other_seed_another() -> None:
    first = list(bus(LINE, 5, 2, MANY_FAULTS))
    assert list(bus(LINE, 5, 2, MANY_FAULTS)) == first
    other = list(bus(LINE, 6, 2))
    undisturbed = list(bus(LINE, 5, 2))
    assert [played.sent for played in other] != [played.sent for played in undisturbed]
    assert [played.time_ns for played in other] != [played.time_ns for played in undisturbed]


def test_without_cycles_it_does_not_end() -> None:
    endless = bus(LINE, 1, 0)
    assert sum(1 for _ in zip(range(2000), endless, strict=False)) == 2000


# -- Faults ---------------------------------------------------------------------------------------------------------

Arrived = tuple[int, int]  # value and flags


def arrived(sent: bytes, marks: Sequence[str], lost_before: bool) -> tuple[list[Arrived], bool]:
    """Work out what a tap must receive from a line of the log; also whether a loss precedes the next character."""
    faults: dict[int, list[tuple[str, str]]] = {}
    for mark in marks:
        match = re.fullmatch(r"(parity|break|loss|pause|checksum)@(\d+)(?:=([0-9A-F]{2}))?", mark)
        if match:
            faults.setdefault(int(match[2]), []).append((match[1], match[3]))
        else:
            assert mark == "ascii"
    characters = []
    for index, value in enumerate(sent):
        kinds = dict(faults.get(index, []))
        if "loss" in kinds:
            lost_before = True
            continue
        flags = Flag.LOST_BEFORE if lost_before else Flag(0)
        lost_before = False
        if "break" in kinds:
            value, flags = 0, flags | Flag.BREAK  # noqa: PLW2901
        elif "parity" in kinds:
            value, flags = int(kinds["parity"], 16), flags | Flag.CHARACTER_ERROR  # noqa: PLW2901
        characters.append((value, int(flags)))
    return characters, lost_before


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_faults_are_where_the_marks_say(seed: int) -> None:
    lost = False
    for played in bus(LINE, seed, 1, MANY_FAULTS):
        expected, lost = arrived(played.sent, played.marks, lost)
        assert [(character.value, character.flags) for character in played.characters] == expected
        wrong = "checksum@1" in played.marks
        if "ascii" not in played.marks:
            assert checksum_good(played.sent) is not wrong
        for mark in played.marks:
            if mark.startswith("parity"):
                place, value = re.fullmatch(r"parity@(\d+)=(..)", mark).groups()  # type: ignore[union-attr]
                assert (played.sent[int(place)] ^ int(value, 16)).bit_count() == 1


def test_pauses_exceed_tza_where_the_marks_say_and_nowhere_else() -> None:
    pauses = 0
    for played in bus(LINE, 3, 2, Faults(pause=0.02)):
        times = [character.time_ns for character in played.characters]
        for index in range(1, len(times)):
            paused = f"pause@{index}" in played.marks
            assert (times[index] - times[index - 1] > 5_000_000) is paused
            pauses += paused
    assert pauses > 10


def test_faults_change_nothing_but_what_they_disturb() -> None:
    undisturbed = list(bus(LINE, 4, 1))
    for faults in (Faults(parity=0.1), Faults(break_=0.1), Faults(loss=0.1)):
        disturbed = list(bus(LINE, 4, 1, faults))
        assert [(played.time_ns, played.sent) for played in disturbed] == [
            (played.time_ns, played.sent) for played in undisturbed
        ]
    checksum = list(bus(LINE, 4, 1, Faults(checksum=1)))[1:]  # the first is ASCII
    assert [played.sent[2:] for played in checksum] == [played.sent[2:] for played in undisturbed[1:]]
    assert not any(checksum_good(played.sent) for played in checksum)


def test_fault_options() -> None:
    assert Faults.parse("parity=0.5,break=1,loss=0") == (0.5, 1.0, 0.0, 0.0, 0.0)
    for wrong in ("parity", "rain=1", "parity=much", "loss=1.5", "loss=-1", "loss=nan", ""):
        with pytest.raises(ValueError, match="PROBABILITY|from 0 to 1"):
            Faults.parse(wrong)


# -- Reads of a coarse adapter --------------------------------------------------------------------------------------


def test_reads_and_their_uncertainty() -> None:
    # 1000 ns a character; five back to back but for a gap of 300 before the third; then a silence, then two
    times = [1000, 2000, 3300, 4300, 5300, 20000, 21000]
    characters = [SentCharacter(time, 0x30 + index, 0) for index, time in enumerate(times)]
    grouped = [[character.time_ns for character in read] for read in reads(characters, 4, 1000)]
    assert grouped == [[1000, 2000, 3300, 4300], [5300], [20000, 21000]]
    # the first of four came 3300 before the read
    assert uncertainty(characters[:4]) == 3300
    assert uncertainty(characters[:1]) == 0
    assert [len(read) for read in reads(characters, 1, 1000)] == [1] * 7


# -- At a socket ----------------------------------------------------------------------------------------------------


@contextmanager
def running(*options: str, **popen: object) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run the command until the block ends; yield it and the name that it printed."""
    process = subprocess.Popen([*BUS, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **popen)  # type: ignore[call-overload]
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


def finish(process: subprocess.Popen[str]) -> tuple[int, str]:
    _, errors = process.communicate(timeout=TIMEOUT_S)
    return process.returncode, errors


def connect(name: str, tap: LineSettings | None = LINE) -> socket.socket:
    assert name.startswith("bus://")
    where = name.removeprefix("bus://")
    if where.startswith("/"):
        connection = socket.socket(socket.AF_UNIX)
        connection.settimeout(TIMEOUT_S)
        connection.connect(where)
    else:
        host, _, port = where.rpartition(":")
        connection = socket.create_connection((host, int(port)), timeout=TIMEOUT_S)
    if tap:
        connection.sendall(protocol.pack_settings(tap))
    return connection


def listen(connection: socket.socket) -> list[Read]:
    """Yield reads until the bus ends."""
    decoder, heard = protocol.Decoder(), []
    while data := connection.recv(65536):
        heard += [message for message in decoder.feed(data) if isinstance(message, Read)]
    connection.close()
    return heard


def logged(path: Path) -> list[Played]:
    """Read a log back, without the characters."""
    entries = []
    for entry in path.read_text().splitlines():
        if not entry.startswith("#"):
            seconds, sent, *marks = entry.split()
            entries.append(Played(int(seconds.replace(".", "")), bytes.fromhex(sent), [], marks))
    return entries


def expected_of(log: list[Played]) -> list[Arrived]:
    characters, lost = [], False
    for played in log:
        more, lost = arrived(played.sent, played.marks, lost)
        characters += more
    return characters


def joined(heard: list[Read]) -> list[Arrived]:
    return [pair for read in heard for pair in zip(read.data, read.flags, strict=True)]


@pytest.mark.parametrize("most", [1, 10])
def test_the_log_equals_what_arrives_at_a_socket(tmp_path: Path, most: int) -> None:
    log = tmp_path / "log"
    options = ["--fast", "--cycles", "3", "--reads", str(most), "--faults", MANY_FAULTS_TEXT, "--log", str(log)]
    with running("--listen", "127.0.0.1:0", *options) as (process, name):
        heard = listen(connect(name))
        assert finish(process) == (0, "")
    entries = logged(log)
    assert len({mark.split("@")[0] for played in entries for mark in played.marks}) == 6  # all kinds and ascii
    assert joined(heard) == expected_of(entries)
    assert max(len(read.data) for read in heard) == most
    assert [(played.time_ns, played.sent, played.marks) for played in entries] == [
        (played.time_ns, played.sent, played.marks) for played in bus(LINE, 1, 3, MANY_FAULTS)
    ]


@pytest.mark.parametrize("most", [1, 16])
def test_times_at_a_socket_hold_what_a_read_promises(most: int) -> None:
    with running("--listen", "127.0.0.1:0", "--fast", "--cycles", "1", "--reads", str(most)) as (_, name):
        heard = listen(connect(name))
    true = [character.time_ns for played in bus(LINE, 1, 1) for character in played.characters]
    started = heard[-1].time_ns - true[-1]
    place = 0
    for read in heard:
        count = len(read.data)
        for index in range(count):
            latest = read.time_ns - started - (count - 1 - index) * LINE.character_ns
            assert latest - read.uncertainty_ns <= true[place] <= latest
            place += 1
    assert place == len(true)


@sockets
def test_in_real_time_at_a_unix_socket(tmp_path: Path) -> None:
    path = tmp_path / "bus"
    options = ["--baud", "115200", "--cycles", "1", "--seed", "9"]
    with running("--listen", str(path), *options) as (process, name):
        assert name == f"bus://{path}"
        heard = listen(connect(name, LINE._replace(baud=115200)))
        assert finish(process) == (0, "")
    sent = b"".join(played.sent for played in bus(LINE._replace(baud=115200), 9, 1))
    assert b"".join(read.data for read in heard) == sent
    assert not path.exists()


def test_a_tap_that_comes_later_hears_the_bus_from_then_on() -> None:
    taps = Taps(Pace(simulated=True), "127.0.0.1:0", 1, 1)
    first = connect(taps.name)
    taps.wait_for_listener()
    played = list(bus(LINE, 1, 1))
    taps.deliver(played[0])
    second = connect(taps.name)
    taps.deliver(played[1])  # lets it in
    taps.deliver(played[2])  # hears its settings, so it hears this
    taps.deliver(played[3])
    for connection in (first, second):
        connection.shutdown(socket.SHUT_WR)  # or the bus waits for them to leave
    taps.close()
    assert bytes(value for value, _ in joined(listen(first))) == b"".join(one.sent for one in played[:4])
    assert bytes(value for value, _ in joined(listen(second))) == b"".join(one.sent for one in played[2:4])


# What a UART makes of a character, by hand: start bit 0, data from the lowest bit on, parity, stop bit 1.
@pytest.mark.parametrize(
    ("line", "tap", "value", "heard", "flags"),
    [
        # The parity bit is taken for the stop bit: 02 has one 1, so parity 1; 03 has two, so parity 0.
        ("8E1", "8N1", 0x02, 0x02, 0),
        ("8E1", "8N1", 0x03, 0x03, Flag.CHARACTER_ERROR),
        ("8E1", "8N1", 0x00, 0x00, Flag.BREAK),  # 0 to the end of the stop bit
        # The stop bit is taken for the parity bit: right where even parity would be 1. After it the line is at rest.
        ("8N1", "8E1", 0x02, 0x02, 0),
        ("8N1", "8E1", 0x03, 0x03, Flag.CHARACTER_ERROR),
        ("8E1", "8O1", 0x55, 0x55, Flag.CHARACTER_ERROR),
        # The eighth data bit is taken for the parity bit, and the parity bit for the stop bit.
        ("8E1", "7E1", 0x81, 0x01, Flag.CHARACTER_ERROR),
        ("8E1", "7E1", 0x83, 0x03, Flag.CHARACTER_ERROR),
        ("8E1", "7E1", 0x13, 0x13, Flag.CHARACTER_ERROR),
        # 7N1 is 0, 1000000, 1 and rest: 1 with the stop bit as its highest bit.
        ("7N1", "8N1", 0x01, 0x81, 0),
    ],
)
def test_other_formats(line: str, tap: str, value: int, heard: int, flags: int) -> None:
    sent, received = LineSettings.parse(9600, line), LineSettings.parse(9600, tap)
    assert hear(value, sent, received, random.Random(1)) == (heard, flags)


@pytest.mark.parametrize(
    ("baud", "value", "heard", "flags"),
    [
        # Each bit is seen twice: 0 0 | b0 b0 b1 b1 b2 b2 b3 | b3 as parity, b4 as stop bit.
        (19200, 0x00, 0x00, Flag.BREAK),
        (19200, 0x55, 0b01100110, 0),  # 0 11 00 11 0, even parity 0 = b3, and b4 = 1
        (19200, 0x45, 0b01100110, Flag.CHARACTER_ERROR),  # b4 = 0
        # Twelve looks at the start bit.
        (115200, 0xFF, 0x00, Flag.BREAK),
    ],
)
def test_a_receiver_that_is_too_fast(baud: int, value: int, heard: int, flags: int) -> None:
    assert hear(value, LINE, LINE._replace(baud=baud), random.Random(1)) == (heard, flags)


def test_a_receiver_that_is_too_slow_hears_what_follows() -> None:
    fast = LINE._replace(baud=115200)
    noise = random.Random(1)
    heard = [hear(0x02, fast, LINE, noise) for _ in range(200)]
    assert len({value for value, _ in heard}) > 50
    assert 50 < sum(bool(flags) for _, flags in heard) < 200


def test_a_tap_with_the_wrong_parity_gets_errors_where_it_must() -> None:
    with running("--listen", "127.0.0.1:0", "--fast", "--cycles", "1") as (_, name):
        heard = joined(listen(connect(name, LINE._replace(parity="N"))))
    right = [character.value for played in bus(LINE, 1, 1) for character in played.characters]
    assert [value for value, _ in heard] == right
    for value, flags in heard:
        parity = value.bit_count() % 2
        assert flags == (0 if parity else Flag.CHARACTER_ERROR if value else Flag.BREAK)


def test_same_seed_same_noise_at_a_wrong_rate() -> None:
    def once() -> list[Arrived]:
        with running("--listen", "127.0.0.1:0", "--fast", "--cycles", "1", "--baud", "38400") as (_, name):
            return joined(listen(connect(name)))

    assert once() == once()


def test_a_tap_that_changes_its_settings_hears_better_and_is_told_from_where_on() -> None:
    wrong = LINE._replace(parity="N")
    with running("--listen", "127.0.0.1:0", "--fast") as (_, name):
        connection = connect(name, wrong)
        decoder = protocol.Decoder()
        heard: list[protocol.Message] = []
        while not any(isinstance(message, Read) for message in heard):
            heard += decoder.feed(connection.recv(65536))
        connection.sendall(protocol.pack_settings(LINE))
        while LINE not in heard[:-100]:
            heard += decoder.feed(connection.recv(65536))  # the socket's time-out fails the test
        connection.close()
    place = heard.index(LINE)
    assert isinstance(heard[0], protocol.Hello)
    assert heard[1] == wrong
    assert any(any(message.flags) for message in heard[:place] if isinstance(message, Read))
    assert not any(any(message.flags) for message in heard[place:] if isinstance(message, Read))


def test_simulated_time_waits_for_a_tap_that_asks_for_it() -> None:
    """So a change that a tap makes after hearing a telegram applies from the next telegram on."""
    played = list(bus(LINE, 1, 1))
    with running("--listen", "127.0.0.1:0", "--fast", "--cycles", "1") as (process, name):
        connection = connect(name, None)
        connection.sendall(protocol.pack_time(0) + protocol.pack_settings(LINE))  # with the settings the bus begins
        decoder, count, pieces = protocol.Decoder(), 0, [b""]
        times: list[int] = []
        while data := connection.recv(65536):
            for message in decoder.feed(data):
                if isinstance(message, Read):
                    pieces[-1] += message.data
                    times.append(message.time_ns)
                elif isinstance(message, protocol.Time):
                    assert not times or message.time_ns >= times[-1]
                    times.append(message.time_ns)
                    pieces += [b""] if pieces[-1] else []
                    count += 1
                    connection.sendall(protocol.pack_settings(LINE) + protocol.pack_time(message.time_ns))
        connection.close()
        assert finish(process) == (0, "")
    assert [piece for piece in pieces if piece] == [one.sent for one in played]
    assert count >= len(played)


def test_the_master_tests_a_rate_and_tells_it() -> None:
    played = list(bus(LINE, 1, 2, rates=[38400, 19200]))
    said = [(one.settings.baud, one.sent.hex(" ").upper()) for one in played]
    # checksums by hand; 0x1F4 is 500 ms, mask 02 is 38400 Bd (fig. 6-11, 6-18)
    asked = said.index((9600, "02 DC 05 05 00 03 10 03 03 08 F4 01 02"))
    assert said[asked + 1] == (9600, "02 C7 03 03 10 03 10 03 00 03 08")
    test = [one for one in played[asked + 2 :] if one.settings.baud != 9600][:4]
    end_ns = played[asked + 1].characters[-1].time_ns + 500_000_000
    assert {one.settings.baud for one in test} == {38400}
    assert test == played[asked + 2 : asked + 6]
    assert test[-1].characters[-1].time_ns < end_ns < played[asked + 6].time_ns
    assert played[asked + 6].settings.baud == 9600
    told = said.index((9600, "02 DD 03 03 00 03 10 FF 00 07 02"))
    assert said[told + 1] == (9600, "02 E9 02 02 00 03 10 FF 00 FF")
    assert {baud for baud, _ in said[told + 2 :]} == {38400, 19200}  # the next test begins at the new rate
    assert said[-1] == (38400, "02 E9 02 02 00 03 10 FF 00 FF")
    ends = 0
    for one in played:
        assert one.time_ns - one.settings.character_ns >= ends
        ends = one.characters[-1].time_ns


def test_what_is_no_tap_is_sent_away() -> None:
    with running("--listen", "127.0.0.1:0", "--fast", "--cycles", "1") as (process, name):
        stranger = connect(name, None)
        stranger.sendall(b"GET / HTTP/1.1\r\n\r\n")
        with contextlib.suppress(ConnectionResetError):  # it did not read all that the stranger said
            while stranger.recv(4096):  # what the bus says of itself
                pass
        stranger.close()
        assert listen(connect(name))
        code, errors = finish(process)
    assert code == 0
    assert errors.count("\n") == 1
    assert "closed a connection" in errors


def test_simulated_time_ends_with_the_last_tap() -> None:
    with running("--listen", "127.0.0.1:0", "--fast") as (process, name):
        connection, decoder = connect(name), protocol.Decoder()
        while LINE not in decoder.feed(connection.recv(100)):  # until then it is no tap
            pass
        connection.close()
        assert finish(process) == (0, "")


@pytest.mark.attack(
    "a client of `sistap bus --listen` that never reads", "disconnected; the other clients receive everything"
)
def test_a_silent_tap_is_let_go_and_the_others_hear_everything(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(wires, "PATIENCE_S", 0.2)
    taps = Taps(Pace(simulated=True), "127.0.0.1:0", 1, 1)
    silent = connect(taps.name, None)
    silent.sendall(protocol.pack_time(0) + protocol.pack_settings(LINE))  # and it never says a time again
    other = connect(taps.name)
    taps.wait_for_listener()
    while sum(bool(tap.settings) for tap in taps._peers) < 2:
        taps._attend(TIMEOUT_S)
    played = list(bus(LINE, 1, 1))
    for one in played:
        taps.deliver(one)
    other.shutdown(socket.SHUT_WR)
    taps.close()
    assert joined(listen(other)) == [(character.value, 0) for one in played for character in one.characters]
    silent.close()
    assert capsys.readouterr().err == "sistap bus: closed a connection: a tap has not read for 0.2 s\n"


@sockets
def test_a_tap_that_does_not_read_is_let_go(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(wires, "PATIENCE_S", 0.2)
    monkeypatch.setattr(wires, "_ROOM", 1000)
    taps = Taps(Pace(simulated=True), str(tmp_path / "bus"), 1, 1)
    stalled = connect(taps.name)
    taps.wait_for_listener()
    for one in bus(LINE, 1, 50):
        taps.deliver(one)
        if taps.deserted:
            break
    assert taps.deserted
    taps.close()
    stalled.close()
    assert capsys.readouterr().err == "sistap bus: closed a connection: a tap has not read for 0.2 s\n"


def test_who_says_nothing_makes_room(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(wires, "INTRODUCTION_S", 0)
    taps = Taps(Pace(simulated=True), "127.0.0.1:0", 1, 1)
    with connect(taps.name, None) as stranger:
        while not capsys.readouterr().err:
            taps._attend(TIMEOUT_S)
        while stranger.recv(4096):
            pass
    taps.close()


def test_more_connections_than_it_takes(capsys: pytest.CaptureFixture[str]) -> None:
    taps = Taps(Pace(simulated=True), "127.0.0.1:0", 1, 1)
    with contextlib.ExitStack() as opened:
        some = [opened.enter_context(connect(taps.name)) for _ in range(40)]
        for _ in some:
            taps._attend(0)
        assert len(list(taps._peers)) == 32
        for one in itertools.islice(bus(LINE, 1, 1), 3):
            taps.deliver(one)
        for connection in some:
            with contextlib.suppress(OSError):  # it was turned away
                connection.shutdown(socket.SHUT_WR)
        taps.close()
    assert capsys.readouterr().err == "sistap bus: refused a connection: 32 are connected already\n"


# -- At a pseudo terminal -------------------------------------------------------------------------------------------


def drain(terminal: int) -> bytes:
    """Read until the other side is gone."""
    heard = b""
    while True:
        try:
            data = os.read(terminal, 4096)
        except OSError as error:
            assert error.errno == errno.EIO
            return heard
        if not data:
            return heard
        heard += data


@pytest.mark.thorough
@terminals
def test_a_pty_that_nobody_configured_delivers_every_byte(tmp_path: Path) -> None:
    log = tmp_path / "log"
    # S-0-0099 is written as 03 00, velocities are any bytes: an unconfigured terminal would eat and echo some
    with running("--baud", "115200", "--cycles", "1", "--seed", "2", "--log", str(log)) as (process, name):
        terminal = os.open(name, os.O_RDWR | os.O_NOCTTY)
        heard = drain(terminal)
        os.close(terminal)
        assert finish(process) == (0, "")
    assert heard == b"".join(played.sent for played in logged(log))
    assert {mark for played in logged(log) for mark in played.marks} == {"ascii"}


def read_exactly(terminal: int, count: int) -> bytes:
    """Read that many bytes, which may arrive in any pieces."""
    heard = b""
    while len(heard) < count:
        assert select.select([terminal], [], [], TIMEOUT_S)[0]
        heard += os.read(terminal, count - len(heard))
    return heard


def character_run(values: bytes) -> Played:
    return Played(0, values, [SentCharacter(0, value, 0) for value in values], [])


@terminals
def test_without_a_listener_characters_are_gone_and_nobody_gets_old_ones() -> None:
    terminal = PseudoTerminal(Pace(simulated=True), 9600)
    assert terminal.deliver(character_run(b"nobody")) == ["unheard=6"]
    first = os.open(terminal.name, os.O_RDONLY | os.O_NOCTTY)
    assert terminal.deliver(character_run(b"heard, not read")) == []
    os.close(first)
    assert terminal.deliver(character_run(b"nobody")) == ["unheard=6"]
    second = os.open(terminal.name, os.O_RDONLY | os.O_NOCTTY)
    assert terminal.deliver(character_run(b"new\x03\x04\r\n\x11\x13\xff\x00")) == []
    assert read_exactly(second, 11) == b"new\x03\x04\r\n\x11\x13\xff\x00"
    os.close(second)
    terminal.close()


@pytest.mark.thorough
@terminals
def test_a_listener_who_does_not_read_holds_up_nothing() -> None:
    terminal = PseudoTerminal(Pace(simulated=True), 9600)
    listener = os.open(terminal.name, os.O_RDONLY | os.O_NOCTTY)
    (mark,) = terminal.deliver(character_run(bytes(100_000)))
    os.close(listener)
    terminal.close()
    kept = 100_000 - int(mark.removeprefix("overrun="))
    assert 0 < kept < 100_000


@terminals
def test_before_it_closes_a_listener_has_time_to_read(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = PseudoTerminal(Pace(simulated=True), 9600)
    listener = os.open(terminal.name, os.O_RDONLY | os.O_NOCTTY)
    terminal.deliver(character_run(b"last words"))
    heard: list[bytes] = []
    while_waiting = SimpleNamespace(sleep=lambda _: heard.append(read_exactly(listener, 10)))
    monkeypatch.setattr(pseudo_terminal, "time", while_waiting)
    terminal.close()
    assert heard == [b"last words"]
    os.close(listener)


# -- The command ----------------------------------------------------------------------------------------------------


@pytest.mark.thorough
@signals
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("options", [["--pty"], ["--listen", "127.0.0.1:0"]])
def test_a_signal_ends_it_while_it_waits_even_if_ignored_before(number: signal.Signals, options: list[str]) -> None:
    ignore = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.SIG_IGN)}  # as a script's & does
    with running(*options, **ignore) as (process, name):
        assert name
        process.send_signal(number)
        assert finish(process) == (0, "")


@signals
def test_a_signal_ends_it_while_it_plays_and_the_log_has_whole_lines(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with running("--listen", "127.0.0.1:0", "--fast", "--log", str(log)) as (process, name):
        connection = connect(name)
        while log.read_text().count("\n") < 2:  # the comment, and one that was played
            connection.recv(10_000)
        process.send_signal(signal.SIGTERM)
        while connection.recv(65536):
            pass
        connection.close()
        assert finish(process) == (0, "")
    assert log.read_text().endswith("\n")
    assert [played.sent for played in logged(log)] == [
        played.sent for played, _ in zip(bus(LINE), logged(log), strict=False)
    ]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("options", "cure"),
    [
        (["--format", "8X1"], "such as 8E1"),
        (["--format", "7E1"], "8 data bits"),
        (["--baud", "0"], "for example 9600"),
        (["--cycles", "-1"], "0 plays until stopped"),
        (["-w", ""], "-w and --log take the name of a file"),
        (["--log", "-"], "-w and --log take the name of a file"),
        (["--reads", "0", "--listen", "127.0.0.1:0"], "from 1"),
        pytest.param(["--fast"], "needs --listen", marks=listening_only_if_asked),
        pytest.param(["--reads", "5"], "needs --listen", marks=listening_only_if_asked),
        pytest.param(["--faults", "parity=0.1"], "use --listen", marks=listening_only_if_asked),
        (["--faults", "rain=0.1"], "NAME one of parity, break, loss, checksum, pause"),
        (["--rates", "9600,4800"], "'4800' is not one of 9600, 19200, 38400, 57600, 115200"),
        (["--listen", "nowhere"], "for example 127.0.0.1:0"),
        (["--listen", "127.0.0.1:70000"], "for example 127.0.0.1:0"),
        (["--log", "/nowhere/log"], "another file with --log"),
    ],
)
def test_wrong_options_get_one_line_with_the_cure(tmp_path: Path, options: list[str], cure: str) -> None:
    result = run(tmp_path, "bus", *options)
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert cure in result.stderr


@pytest.mark.thorough
def test_an_address_in_use(tmp_path: Path) -> None:
    path = tmp_path / "bus"
    for address in ["127.0.0.1:0", *([] if WINDOWS else [str(path)])]:
        with running("--listen", address) as (_, name):
            again = [*BUS, "--listen", name.removeprefix("bus://")]
            result = subprocess.run(again, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
            assert result.returncode == 3
            assert result.stderr.count("\n") == 1
            assert "choose another" in result.stderr


@sockets
def test_a_path_that_is_too_long(tmp_path: Path) -> None:
    command = [*BUS, "--listen", str(tmp_path / ("x" * 150))]
    result = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert result.returncode == 3
    assert result.stderr.endswith(": AF_UNIX path too long; choose another port (0: any free one) or PATH\n")


def test_nobody_reads_its_name() -> None:
    read, write = os.pipe()
    os.close(read)
    result = subprocess.run(BUS, stdout=write, stderr=subprocess.PIPE, text=True, timeout=TIMEOUT_S, check=False)
    os.close(write)
    assert result.returncode == 1
    assert re.fullmatch(
        r"sistap bus: the bus stopped: (Broken pipe|Invalid argument)\n", result.stderr
    )  # as Windows has it


@pytest.mark.thorough
@sockets
def test_a_socket_that_a_killed_bus_left_is_replaced_but_no_file(tmp_path: Path) -> None:
    path = tmp_path / "bus"
    with running("--listen", str(path)):
        pass  # killed
    assert path.is_socket()
    with running("--listen", str(path)) as (_, name):
        assert name == f"bus://{path}"
    path.unlink()
    path.write_text("precious")
    with running("--listen", str(path)) as (process, _):
        assert finish(process)[0] == 3
    assert path.read_text() == "precious"


@pytest.mark.thorough
@signals
def test_a_tap_that_goes_on_talking_does_not_hold_up_the_end() -> None:
    with running("--listen", "127.0.0.1:0") as (process, name), connect(name) as connection:
        assert connection.recv(1)
        process.terminate()
        until = time.monotonic() + TIMEOUT_S
        with contextlib.suppress(OSError):  # until the bus has gone
            while process.poll() is None:
                connection.sendall(protocol.pack_settings(LINE))
                assert time.monotonic() < until
        assert finish(process) == (0, "")


def test_a_full_disk_is_said(full: Path) -> None:
    with running("--listen", "127.0.0.1:0", "--fast", "--log", str(full)) as (process, name):
        listen(connect(name))
        code, errors = finish(process)
    assert code == 1
    assert errors.count("\n") == 1


def test_no_faults_is_the_default() -> None:
    assert NO_FAULTS == (0, 0, 0, 0, 0)
    assert all(not played.marks or played.marks == ["ascii"] for played in bus(LINE, 1, 1))


def test_every_script_starts_the_same_whatever_its_length() -> None:
    short, long = list(commands(LINE, 1, 1)), list(commands(LINE, 1, 2))
    assert long[: len(short)] == short
    assert read_parameter(3, "S-0-0040") in short
