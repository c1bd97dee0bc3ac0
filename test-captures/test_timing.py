# SPDX-License-Identifier: GPL-2.0-or-later
"""Limits and verdicts, exactly those that the `fields` lines of the captures demand, and the load of the line."""

from __future__ import annotations

import math
from decimal import Decimal
from pathlib import Path
from xml.etree import ElementTree

import pytest

from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from tables import HERE, Table, check, shown

TZA = "tza.limit tza.set_in tza.verdict"
TRS = "trs.limit trs.set_in trs.verdict"
TIMES = {
    *("silence_before", "reaction_time", "tza.interval_max", "tza.limit", "trs.limit"),
    *("twm.wait", "tmas.cycle", "tmas.limit"),
}
EXPERTS = "tza.exceeded tza.unresolved trs.exceeded trs.unresolved tmas.exceeded tmas.unresolved"

# What the `fields` lines of each capture name, where it is there.
FIELDS = {
    "timing-limits": f"{TZA} {TRS}",
    "timing-rates": "bus.baud bus.baud.set_in",
    "timing-pauses": f"silence_before tza.interval_max tza.position {TZA}",
    "timing-readings": f"tza.interval_max tza.position {TZA} {TRS}",
    "timing-silences": "silence_before",
    "timing-reads": f"{TZA} {TRS}",
    "timing-reactions": f"reaction_time {TRS} twm.wait {TZA}",
    "timing-told": f"{TZA} {TRS}",
    "told-before": f"{TZA} {TRS} bus.baud bus.baud.set_in parameter.name parameter.maximum value.number",
    "timing-dead-bus": "tmas.cycle tmas.limit tmas.set_in tmas.verdict",
    "timing-cycle": "tmas.cycle tmas.limit tmas.set_in tmas.verdict",
}


def text(name: str, value: str) -> str:
    """Write a field as tshark does: times with nine decimals; an expert item is there or not."""
    return f"{name}={Decimal(value):.9f}" if name in TIMES else f"{name}={value}" if value else name


def table(scenario: Scenario) -> Table:
    """Return what the `fields` lines say."""
    return {
        number: "; ".join(text(*field) for field in item.expected.items())
        for number, item in enumerate(scenario.items, 1)
    }


@pytest.mark.parametrize("name", FIELDS)
def test_verdicts(name: str, tshark: Tshark) -> None:
    scenario = Scenario(HERE / f"{name}.txt")
    experts = f"{EXPERTS} command.unanswered twm.early" if name == "timing-reactions" else EXPERTS
    check(tshark, name, FIELDS[name], experts, table(scenario), *scenario.options)


def test_preferences_go_before_what_the_bus_said(tshark: Tshark) -> None:
    """TzA 8 ms and TrS 23 ms: one pause of 10 ms twice, all reactions after 25 ms, also those without a limit.

    That is more than a character time too long.
    """
    capture = HERE / "timing-limits.pcapng"
    options = ("-o", "sis.tza_ms:8", "-o", "sis.trs_ms:23")
    frames = shown(tshark, capture, f"{TZA} {TRS} reaction_time routed_from subaddress", *options)
    pauses = {number for number, item in enumerate(Scenario(capture.with_suffix(".txt")).items, 1) if item.pauses_ns}
    assert len(pauses) == 2
    for number, cells in frames.items():
        judged = {name: value for name, value in cells.items() if name.startswith(("tza", "trs"))}
        expected = {"tza.limit": "0.008000000", "tza.verdict": "1" if number in pauses else "0"}
        if "reaction_time" in cells and "subaddress" not in cells:
            expected |= {"trs.limit": "0.023000000", "trs.verdict": "1"}
        assert judged == expected, number


# Of timing-readings: the verdicts on TzA of frames 1 to 17 where somebody says what counts, and with a TzA of 1 ms,
# which is shorter than a character of 1.145833 ms.
READINGS = {
    ("end", 5): "00010 00212 12001 21",
    ("start", 5): "01110 21112 11111 11",
    ("unknown", 1): "11111 11111 11111 11",
    ("end", 1): "11111 11111 11111 11",
    ("start", 1): "11111 11111 11111 11",
}


@pytest.mark.parametrize(("counts_from", "limit_ms"), READINGS)
def test_where_an_interval_begins_to_count(counts_from: str, limit_ms: int, tshark: Tshark) -> None:
    options = ("-o", f"sis.tza_from:{counts_from}", "-o", f"sis.tza_ms:{limit_ms}")
    frames = shown(tshark, HERE / "timing-readings.pcapng", "tza.verdict", *options)
    found = "".join(frames[number]["tza.verdict"] for number in range(1, 18))
    assert found == READINGS[counts_from, limit_ms].replace(" ", "")
    # Telegrams without a pause: TzA is shorter than their characters, or they have no pause at all.
    rest = {"unknown": "2", "end": "0", "start": "1"}[counts_from] if limit_ms == 1 else "0"
    assert {frames[number]["tza.verdict"] for number in range(18, 26)} == {rest}


def test_why_a_verdict_depends_on_what_counts(tshark: Tshark) -> None:
    capture, options = HERE / "timing-readings.pcapng", ("-o", "sis.tza_ms:5", "-o", "sis.trs_ms:50")
    command = ("-r", str(capture), *options, "-T", "fields", "-e", "_ws.expert.message")
    messages = [line.split(",") for line in tshark.output(*command).splitlines()]
    why = {number: [text for text in texts if "perhaps" in text] for number, texts in enumerate(messages, 1)}
    tza = ["TzA perhaps exceeded: depends on where TzA begins to count"]
    trs = ["TrS perhaps exceeded: depends on whether the first character counts"]
    reasons = dict.fromkeys((2, 3, 6, 7, 8, 13, 14, 16), tza) | dict.fromkeys((21, 23), trs)
    reasons |= {10: ["TzA perhaps exceeded"], 12: ["TzA perhaps exceeded: an interval is not known"]}
    assert {number: texts for number, texts in why.items() if texts} == reasons


@pytest.mark.thorough
def test_an_interval_as_long_as_can_be_stored_may_be_any_longer(tshark: Tshark) -> None:
    scenario = Scenario(HERE / "timing-pauses.txt")
    saturated = next(number for number, item in enumerate(scenario.items, 1) if item.flags == {5: 0x40})
    for limit, verdict in ((4293, "1"), (4294, "2"), (4295, "2"), (60_000, "2")):  # 4293.821 ms without its character
        frames = shown(tshark, HERE / "timing-pauses.pcapng", "tza.verdict", "-o", f"sis.tza_ms:{limit}")
        assert frames[saturated] == {"tza.verdict": verdict}, limit


# The header's characters, by the names that the header itself has in the tree, in the telegram with all of them.
POSITIONS = {
    2: "Checksum",
    3: "Data length",
    4: "Data length repetition",
    5: "Telegram control",
    6: "Service",
    7: "Sender address",
    8: "Receiver address",
    9: "Subaddress 1",
    10: "Telegram number",
}


def test_the_intervals_of_a_telegram_in_one_read_are_from_its_second_character_on(tshark: Tshark) -> None:
    frames = shown(tshark, HERE / "timing-reads.pcapng", "tza.position", "-o", "sis.tza_ms:5")
    assert {frames[number]["tza.position"] for number in range(1, 7)} == {"2"}


def test_position_names_its_field(tshark: Tshark) -> None:
    scenario = Scenario(HERE / "timing-pauses.txt")
    command = ("-r", str(HERE / "timing-pauses.pcapng"), "-T", "pdml", *scenario.options)
    packets = ElementTree.fromstring(tshark.output(*command, "-Y", "sis.subaddress")).findall("packet")
    fields = [field for packet in packets for field in packet.iter("field")]
    shown_positions = [field.get("showname", "") for field in fields if field.get("name") == "sis.tza.position"]
    positions = [showname.partition(": ")[2] for showname in shown_positions]
    assert len(positions) == 14
    for number, position in enumerate(positions, 2):
        name = POSITIONS.get(number, "Useful data")
        assert position.lower().startswith(f"{number} ({name.lower()}"), position


def begins_telegram(characters: bytes) -> bool:
    """Tell what chapter 10.5 asks of an alternative start: the start character, and the length twice."""
    return characters[:1] == b"\x02" and len(characters) >= 4 and characters[2] == characters[3]


def test_what_a_receiver_makes_of_a_pause(tshark: Tshark) -> None:
    scenario = Scenario(HERE / "timing-pauses.txt")
    command = ("-r", str(HERE / "timing-pauses.pcapng"), *scenario.options, "-T", "fields", "-e", "_ws.expert.message")
    begun = []
    for message, item in zip(tshark.output(*command).splitlines(), scenario.items, strict=True):
        if "tza.exceeded" in item.expected:
            begun.append(begins_telegram(item.data[int(item.expected["tza.position"]) - 1 :]))
            assert ("begins anew" in message, "goes on" in message) == (begun[-1], not begun[-1]), message
    assert set(begun) == {False, True}


def test_exceeded_is_marked_in_the_packet_list(tshark: Tshark) -> None:
    scenario = Scenario(HERE / "timing-pauses.txt")
    columns = ("-T", "fields", "-e", "_ws.col.Info")
    infos = tshark.output("-r", str(HERE / "timing-pauses.pcapng"), *scenario.options, *columns).splitlines()
    for info, item in zip(infos, scenario.items, strict=True):
        assert ("[TzA exceeded]" in info) == ("tza.exceeded" in item.expected), info


def written(folder: Path, *lines: str) -> Path:
    """Make a capture of a few lines."""
    (folder / "few.txt").write_text("\n".join(lines))
    (folder / "few.pcapng").write_bytes(Scenario(folder / "few.txt").capture())
    return folder / "few.pcapng"


# Eight characters of 1.145833 ms, the last seven in one read 10 ms after the first; a sender may be 2 % too fast.
# The seventh-last came at least 6 * 1.122916 ms before the read, the first character at most 16 ms before its own.
MOST_BEFORE = (10_000_000 - 6 * 1_122_916 + 16_000_000) / 1e9


@pytest.mark.parametrize("limit", [0, 20, 60_000])
def test_without_a_limit_the_longest_is_as_with_one_that_nothing_exceeds(
    limit: int, tshark: Tshark, tmp_path: Path
) -> None:
    """Inside the read there are 10.385420 ms at most: less than before it."""
    block = "telegram 00 00 00 00 00 07 10 14"
    lines = ("silence 90", "uncertainty 16", "command 16>3 12", "reads 1 7", "pause 2 10")
    capture = written(tmp_path, *lines, "@framing 1", block, "reads 1 7", "pause 2 10")
    options = ("-o", f"sis.tza_ms:{limit}", "-o", f"3964r.zvz_ms:{limit}")
    columns = ("sis.tza.interval_max", "sis.tza.position", "3964r.zvz.interval_max", "3964r.zvz.position")
    words = [word for column in columns for word in ("-e", column)]
    rows = tshark.output("-r", str(capture), *options, "-T", "fields", *words).splitlines()
    longest = [f"{MOST_BEFORE:.9f}", "2"]
    assert [row.split() for row in rows] == [longest, longest]


def test_without_the_taps_times_there_is_no_verdict(tshark: Tshark, tmp_path: Path) -> None:
    """A packet's time is then any time: of pauses it says nothing, of reactions nothing certain."""
    capture = written(tmp_path, "@link sis", "silence 90", "command 16>3 12", "reaction 16>3 12 00 04")
    options = ("-o", "sis.tza_ms:5", "-o", "sis.trs_ms:50")
    fields = "silence_before tza.interval_max tza.position tza.verdict trs.verdict bus.load"
    for cells in shown(tshark, capture, fields, *options).values():
        assert cells in ({}, {"trs.verdict": "2"})


def test_a_command_in_the_record_of_a_reaction_ends_with_its_own_last_character(tshark: Tshark, tmp_path: Path) -> None:
    both = "telegram 02 C1 02 02 10 12 10 03 00 04 02 D8 00 00 00 12 10 04"  # of station 3, and to station 4
    capture = written(tmp_path, "silence 30", "command 16>3 12", both, "silence 40", "reaction 16>4 12 00 04")
    times = [cells.get("reaction_time") for cells in shown(tshark, capture, "reaction_time").values()]
    assert times == [None, "0.030000000", "0.040000000"]


# Telegrams with 8 characters of 1.145833 ms each; the silence after the last character before a first one includes
# the first one's own character time.
CHARACTER_MS = 1.145833
LOADS = [
    ("back to back", CHARACTER_MS, 100),
    ("every second telegram's time", 9 * CHARACTER_MS, 50),
    ("every fourth", 25 * CHARACTER_MS, 25),
    ("one in a second", 1000 - 7 * CHARACTER_MS, 0.92),
    ("one in three seconds", 3000, 0.92),
]


@pytest.mark.thorough
@pytest.mark.parametrize(("silence_ms", "percent"), [load[1:] for load in LOADS], ids=[load[0] for load in LOADS])
def test_load(silence_ms: float, percent: float, tshark: Tshark, tmp_path: Path) -> None:
    """At most one telegram (0.92 s/100) stands across the beginning of the second."""
    capture = written(tmp_path, f"silence {silence_ms:.6f}", *["command 16>3 12"] * 300)
    loads = [float(cells["bus.load"]) for cells in shown(tshark, capture, "bus.load").values()]
    assert len(loads) == 300
    assert max(loads) <= 100
    assert loads[150:] == pytest.approx([percent] * 150, abs=0.02 if percent < 1 else 1)
    assert loads[0] > 0


def test_load_after_the_clock_was_set_back(tshark: Tshark, tmp_path: Path) -> None:
    """By 5 s. For a second nobody knows it; then it is 25 % again."""
    commands = ["command 16>3 12"] * 300
    capture = written(tmp_path, f"silence {25 * CHARACTER_MS:.6f}", *commands, "clock -5000", *commands)
    loads = [float(cells.get("bus.load", "nan")) for cells in shown(tshark, capture, "bus.load").values()]
    after = [load for load in loads[300:] if not math.isnan(load)]
    assert 300 - len(after) == sum((32 * number + 8) * CHARACTER_MS < 1000 for number in range(300))
    assert loads[150:300] + after == pytest.approx([25] * (150 + len(after)), abs=1)


def test_a_clock_that_was_set_back_measures_nothing(tshark: Tshark, tmp_path: Path) -> None:
    """Nor does it prove that a reaction, which took 25 ms, or a cycle was short enough."""
    limits = [f"before command 16>255 03 00 {setting}" for setting in ("01 14 00", "03 64 00", "FF")]
    word = ("command 16>3 1F 3C 01 00 86 00 00 E0", "reaction 16>3 1F 00 3C 01")
    switch = ("command 16>3 1D 04", "reaction 16>3 1D 00", "command 16>3 12")
    capture = written(tmp_path, *limits, *word, *switch, "clock -5000", "reaction 16>3 12 00 04", *word)
    fields = "reaction_time trs.verdict phase.switch_in phase.switch_time tmas.before_in tmas.cycle tmas.verdict"
    frames = shown(tshark, capture, fields)
    assert frames[7] == {"reaction_time": "0.025000000", "trs.verdict": "1"}
    assert frames[9] == {"trs.verdict": "2", "phase.switch_in": "6"}
    assert frames[10] == {"tmas.before_in": "4", "tmas.verdict": "2"}
    tree = tshark.output("-r", str(capture), "-V", "-O", "sis")
    assert "Command in: 8, whose end has a later time: the reaction time is not known" in tree
    assert "phase 4 (operating mode), reached\n" in tree
    assert tree.count("the times do not decide (2), the clock was set back") == 2


def test_idle_time_at_an_unknown_rate(tshark: Tshark, tmp_path: Path) -> None:
    """Nobody knows how much of a silence the character after it took."""
    capture = written(tmp_path, "command 16>3 12", "line 0 8N1", "reaction 16>3 12 00 04", "pause 5 3")
    tree = tshark.output("-r", str(capture), "-V", "-O", "sis", "-Y", "frame.number == 2")
    assert "Silence before: 25.000 ms (idle time not known)" in tree
    assert "Longest interval: 3.000 ms (idle time not known, uncertain by 0.310 ms)" in tree
