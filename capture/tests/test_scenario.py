# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenarios: the contents of a file, what is played, and the effect of faults on stations and in Wireshark."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from commands import run
from portable import WINDOWS, signals, terminals
from sharkd import Sharkd
from test_bus import BUS, TIMEOUT_S, connect, finish, joined, listen, octets, running

from sisbus.playing.characters import Played
from sisbus.scenarios import scenario
from sisbus.scenarios.faults import _KINDS
from sisbus.scenarios.scenario import Playing, Scenario, load
from sisbus.scenarios.steps import _STEPS
from sistap.dissected.captures.reading import records
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import Event, Type
from sistap.tap.sis.telegram import parse

MS = 1_000_000
ONCE = Playing(cycles=1)
README = Path(scenario.__file__).parent / "README.md"
BUILT_IN = [name for name in scenario.names() if load(name).is_complete]

# The limits are told, so that a listener knows them; then six values are read.
BUS_OF_ONE = """
title = "a test"
line = { trs_ms = 50, tza_ms = 5, twm_ms = 60 }

[[station]]
address = 3

[[master]]
address = 16
script = [
    { set = "TrS", ms = 50, station = 3 },
    { set = "TzA", ms = 5, station = 3 },
    { set = "accept", station = 255, device = 0 },
    { repeat = [{ read = "S-0-0051", station = 3 }], times = 6 },
]
"""
READ = octets("02 5F 05 05 00 10 10 03 3C 03 00 33 00")  # checksum by hand


def read(text: str, folder: Path) -> Scenario:
    file = folder / "x.toml"
    file.write_text(text)
    return load(str(file))


def play(text: str, folder: Path) -> list[Played]:
    played = read(text, folder)
    return list(played.play(played.settings, ONCE))


def record(name: str, file: Path, *options: str) -> None:
    result = subprocess.run([*BUS, name, "-w", str(file), *options], capture_output=True, text=True, check=False)
    assert result.returncode == 0
    assert result.stderr.startswith("sistap bus: ")
    assert result.stderr.endswith(f"written to {file}; open it with: wireshark -C SIS {file}\n")


def commands(all_played: list[Played], service: int = 0x10) -> list[Played]:
    return [one for one in all_played if is_command(one) and one.sent[5] == service]


def is_command(played: Played) -> bool:
    return "ascii" not in played.marks and not parse(played.sent).reaction


# -- What comes with it ---------------------------------------------------------------------------------------------


def test_the_list_names_them_all() -> None:
    result = subprocess.run([*BUS, "--list"], capture_output=True, text=True, check=True)
    listed = dict(line.split(None, 1) for line in result.stdout.splitlines())
    files = {file.stem for file in README.parent.glob("*.toml")}
    assert set(listed) == files
    assert listed["drives"].startswith("two drives and a control")


@pytest.mark.thorough
@pytest.mark.parametrize("name", BUILT_IN)
def test_same_seed_same_bytes_at_the_same_times(name: str) -> None:
    one = load(name)
    first, again = (list(one.play(one.settings, ONCE)) for _ in range(2))
    other = list(one.play(one.settings, Playing(seed=2, cycles=1)))
    assert first == again
    assert [played.time_ns for played in first] != [played.time_ns for played in other]


@pytest.mark.parametrize("name", [name for name in BUILT_IN if not load(name).procedure])
def test_nobody_speaks_before_the_line_was_silent(name: str) -> None:
    one = load(name)
    tza_ns = one.times_for(one.settings).tza * MS
    end_ns = -tza_ns
    for played in one.play(one.settings, ONCE):
        assert played.time_ns - played.settings.character_ns - end_ns >= tza_ns
        end_ns = played.characters[-1].time_ns


def test_a_scenario_ends_after_its_duration(tmp_path: Path) -> None:
    record("silent-station", tmp_path / "x", "--duration", "3")
    times = [one.time_ns for one in records(tmp_path / "x")]
    # Of the last exchange the beginning is before: a command, asked again twice at most.
    assert 2_500 * MS < times[-1] - times[0] < 3_500 * MS


def test_the_same_file_twice(tmp_path: Path) -> None:
    for name in ("a", "b"):
        record("noise", tmp_path / name, "--seed", "3", "--reads", "5")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize("options", [[], ["--reads", "8"]])
def test_a_file_has_what_a_tap_hears(tmp_path: Path, options: list[str]) -> None:
    record("noise", tmp_path / "x", *options)
    with running("noise", "--listen", "127.0.0.1:0", "--fast", "--cycles", "1", *options) as (_, name):
        heard = listen(connect(name))
    found = [one for one in records(tmp_path / "x") if one.type != Type.EVENT]
    pairs = [(value, flag & Flag.FROM_READER) for one in found for value, flag in zip(one.data, one.flags, strict=True)]
    assert pairs == joined(heard)
    last_ns = found[-1].time_ns + sum(found[-1].intervals[1:])
    assert last_ns - found[0].time_ns == heard[-1].time_ns - heard[0].time_ns


def test_what_breaks_off_at_the_end_is_in_the_file(tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text(BUS_OF_ONE.replace("times = 6 },", 'times = 6 },\n    { raw = "02 05 05" },'))
    record(str(tmp_path / "x.toml"), tmp_path / "x")
    last = list(records(tmp_path / "x"))[-1]
    assert (last.type, last.data) == (Type.OTHER, octets("02 05 05"))


def test_a_file_follows_the_rate(tmp_path: Path) -> None:
    record("wrong-baud", tmp_path / "x")
    found = list(records(tmp_path / "x"))
    changes = [one.settings.baud for one in found if one.event == Event.SETTINGS_CHANGED]
    assert changes == [38400, 9600, 38400]  # a test, its end, accepted by all
    assert all(one.type == Type.FRAME for one in found[2:] if one.type != Type.EVENT)


# -- What a file may say ---------------------------------------------------------------------------------------------


def test_the_example_of_the_readme(tmp_path: Path) -> None:
    match = re.search(r"```toml\n(.*?)```", README.read_text(), re.DOTALL)
    assert match
    marks = {mark.split("@")[0] for one in play(match[1], tmp_path) for mark in one.marks}
    assert {"ascii", "late", "pause", "parity"} <= marks


def test_the_readme_names_every_step_and_fault() -> None:
    named = set(re.findall(r"`([a-z_]+)`", README.read_text()))
    assert set(_STEPS) | set(_KINDS) <= named


STEPS = [
    # figures of the specification, with other addresses where it has others
    ('{ identify = "version", station = 3, device = 3 }', "02 E3 02 02 00 00 10 03 03 01"),
    ('{ set = "rate", rate = 115200, station = 3, device = 4 }', "02 CF 03 03 00 03 10 03 04 07 08"),  # 6-15
    ("{ test_rate = 115200, ms = 800, station = 3, device = 0, steps = [] }", "02 AB 05 05 00 03 10 03 00 08 20 03 08"),
    ('{ set = "accept", station = 255, device = 0 }', "02 E9 02 02 00 03 10 FF 00 FF"),  # 6-24
    (
        '{ list = [{ identify = "version", device = 16 }, { identify = "type", device = 16 }, '
        '{ identify = "rates", device = 16 }], station = 3 }',
        "02 8E 0C 0C 00 04 10 03 03 00 10 01 03 00 10 03 03 00 10 04",  # 7-1
    ),
    # by hand, from fig. 8-1, 8-3 and chapters 2, 3, 5, 8
    ('{ phase = "read", station = 3 }', "02 D9 00 00 00 12 10 03"),
    ("{ switch = 2, station = 3 }", "02 CA 01 01 00 1D 10 03 02"),
    ('{ read = "P-0-0012", element = "unit", station = 3 }', "02 1E 05 05 00 10 10 03 24 03 00 0C 80"),
    ('{ write = "S-0-0036", word = -2, station = 3 }', "02 5E 07 07 00 1F 10 03 3C 03 00 24 00 FE FF"),
    ('{ write = "S-0-0036", value = 1, station = 3 }', "02 56 09 09 00 1F 10 03 3C 03 00 24 00 01 00 00 00"),
    ('{ write = "S-0-0142", text = "AB", station = 3 }', "02 62 0B 0B 00 1F 10 03 3C 03 00 8E 00 02 00 02 00 41 42"),
    (
        '{ read_list = "S-0-0017", offset = 40, length = 4, station = 3 }',
        "02 4C 09 09 00 11 10 03 3C 03 00 11 00 28 00 04 00",
    ),
    ('{ flash = "read", address = 0x1000, length = 16, station = 3 }', "02 26 07 07 00 02 10 03 03 92 00 10 00 00 10"),
    ("{ cancel = 0x1F, station = 3 }", "02 C4 02 02 00 01 10 03 03 1F"),
    ('{ service = 0x05, data = "AA", station = 3 }', "02 3A 01 01 00 05 10 03 AA"),
    # fig. 2-10: through two routers, a telegram number behind the subaddresses
    ('{ identify = "version", station = 3, route = [2, 8] }', "02 CE 04 04 02 00 10 03 02 08 08 01"),
    ('{ phase = "read", station = 3, number = 7 }', "02 C8 01 01 08 12 10 03 07"),
    ('{ raw = "02 00 01" }', "02 00 01"),
]


@pytest.mark.parametrize(("step", "telegram"), STEPS)
def test_a_step_is_this_telegram(step: str, telegram: str, tmp_path: Path) -> None:
    text = f'title = ""\nstation = [{{ address = 3 }}]\n[[master]]\naddress = 16\nrepeats = 0\nscript = [{step}]'
    played = play(text, tmp_path)
    assert played[0].sent == octets(telegram)
    assert "ascii" in played[0].marks or sum(played[0].sent) % 256 == 0


def test_the_number_next_is_another_each_time_and_never_0(tmp_path: Path) -> None:
    steps = '{ repeat = [{ phase = "read", station = 3, number = "next" }], times = 256 }'
    played = play(f'title = ""\nstation = [{{ address = 3 }}]\n[[master]]\naddress = 16\nscript = [{steps}]', tmp_path)
    assert [parse(one.sent).number for one in commands(played, 0x12)] == [*range(1, 256), 1]


def test_times_of_steps(tmp_path: Path) -> None:
    """at_ms and every_ms are kept; nothing else is sent before."""
    steps = '{ at_ms = 2000 }, { repeat = [{ phase = "read", station = 3 }], times = 3, every_ms = 250 }, { at_ms = 1 }'
    played = play(f'title = ""\nstation = [{{ address = 3 }}]\n[[master]]\naddress = 16\nscript = [{steps}]', tmp_path)
    sent = [one.time_ns // MS for one in commands(played, 0x12)]
    assert sent == [2001, 2251, 2501]  # the first character is there after 1.1 ms


def test_a_transfer_goes_on_until_the_last_piece(tmp_path: Path) -> None:
    """Chapter 8.4: while reactions say 38, the same command asks for more; the last says 3C."""
    one = load("long-lists")
    said = [parse(played.sent) for played in one.play(one.settings, ONCE)]
    cam = octets("3C 03 00 48 80")  # P-0-0072, operating data
    places = [place for place, header in enumerate(said) if header.service == 0x10 and header.body == cam]
    pieces = [said[place + 1].body for place in places]
    assert [piece[:3] for piece in pieces] == [octets("00 38 03"), octets("00 3C 03")]
    assert sum(len(piece) - 3 for piece in pieces) == 404  # two lengths and a hundred numbers


WRONG = [
    ("title = rain", r"x.toml: Invalid value \(at line 1, column 9\)"),
    ("", "title is missing"),
    ('title = ""', r"nobody is on the bus: add \[\[station\]\] or \[\[master\]\]"),
    ('title = ""\nrain = 1', "unknown key rain; the keys are line, title, ascii_first, master, station, fault"),
    ('title = ""\n"a\\nb" = 1', r"unknown key a\\nb; the keys are"),
    ("x = " + "[" * 3000, "use fewer levels"),
    (
        'title = ""\nascii_first = "x"\nstation = [{ address = 3 }]',
        r"sistap does not disturb a real bus: \[\[fault\]\] and ascii_first need \[\[master\]\] and \[\[station\]\]",
    ),
    ("title = 5\nstation = [{ address = 3 }]", "title = 5: use a text in quotes"),
    ('title = ""\nline = 9600', r"\[line\] is not a table: write \{ key = value \}"),
    ('title = ""\n[line]\nbaud = "fast"', r'\[line\]: baud = "fast": use a whole number from 75 to 4000000'),
    ('title = ""\n[line]\nformat = "7E1"', r'\[line\]: format = "7E1": SIS needs 8 data bits'),
    ('title = ""\n[line]\nformat = "8X1"', r'\[line\]: format = "8X1": .* such as 8E1'),
    ('title = ""\n[line]\ntrs = 50', r"\[line\]: unknown key trs; the keys are .*trs_ms"),
    ('title = ""\nstation = [{ address = 300 }]', "address = 300: use a whole number from 0 to 126"),
    ('title = ""\nstation = [{ adress = 3 }]', "address is missing"),
    ('title = ""\nmaster = [{ address = 16 }]', r"\[\[master\]\] 1: script is missing"),
    ('title = ""\nmaster = [{ address = 16, script = 5 }]', r"script = 5: use a list of tables"),
    ('title = ""\nmaster = [{ script = [] }]', r"\[\[master\]\] 1: address is missing"),
    (
        'title = ""\n[[master]]\naddress = 16\nscript = []\n[[master]]\naddress = 16\nscript = []',
        r"two \[\[master\]\] have one address: give each another",
    ),
    ("{}", r"\[\[master\]\] 1, step 1: a key is missing; give one of .*identify"),
    ('{ phase = "read", switch = 2 }', "switch and phase do not go together|phase and switch do not go together"),
    ('{ phase = "read" }', "step 1: station is missing"),
    ('{ phase = "read", station = 3, route = 200 }', "route = 200: use a whole number from 0 to 126"),
    ('{ phase = "read", station = 3, rout = 2 }', "unknown key rout; the keys are"),
    ('{ identify = "name", station = 3 }', 'identify = "name": use one of version, firmware, type, rates'),
    ('{ read = "S-0-44", station = 3 }', "read = \"S-0-44\": 'S-0-44' is not a parameter such as S-0-0044"),
    ('{ read = "S-0-0044", element = "x", station = 3 }', 'element = "x": use one of .*name'),
    ('{ write = "S-0-0044", station = 3 }', "give one of data, word, value, text"),
    ('{ write = "S-0-0044", word = 70000, station = 3 }', "word = 70000: use a whole number from -32768 to 65535"),
    ('{ write = "S-0-0044", data = "0G", station = 3 }', 'data = "0G": use bytes in hexadecimal'),
    ('{ set = "rate", rate = 4800, station = 3 }', "rate = 4800: use one of 9600, 19200, 38400, 57600, 115200"),
    ("{ loop = [] }", "loop sends nothing; give it a step that does"),
    ("{ loop = [{ repeat = [{ wait_ms = 0 }], times = 2 }] }", "repeat sends nothing"),
    ('{ repeat = [{ phase = "read", station = 3 }] }', "times is missing"),
    ("{ repeat = [{ wait_ms = -5 }], times = 2 }", r"step 1, repeat step 1: wait_ms = -5: use a number from 0"),
    ("{ list = [{ wait_ms = 5 }], station = 3 }", r"step 1, list item 1: a key is missing"),
    ("{ token = 17 }", "token = 17: there is no such master"),
    (
        'title = ""\nstation = [{ address = 3, parameters = { S-0-0036 = { token = [[]] } } }]',
        "S-0-0036: unknown key token",
    ),
]


@pytest.mark.parametrize(("text", "line"), WRONG)
def test_what_is_wrong_is_one_line_with_table_key_and_cure(text: str, line: str, tmp_path: Path) -> None:
    if text.startswith("{"):
        text = f'title = ""\nstation = [{{ address = 3 }}]\n[[master]]\naddress = 16\nscript = [{text}]'
    with pytest.raises(ValueError, match=line) as error:
        read(text, tmp_path)
    assert str(error.value).startswith(str(tmp_path / "x.toml"))
    assert "\n" not in str(error.value)


def test_a_file_may_begin_with_the_mark_of_windows_editors(tmp_path: Path) -> None:
    assert read("\ufefftitle = 'marked'\nstation = [{ address = 3 }]", tmp_path).title == "marked"


def test_a_file_without_end_is_refused() -> None:
    if WINDOWS or not Path("/dev/zero").exists():
        pytest.skip("this system has no /dev/zero")
    with pytest.raises(ValueError, match="/dev/zero is longer than .* name another FILE.toml"):
        load("/dev/zero")


WRONG_FAULTS = [
    ('kind = "rain"', r'\[\[fault\]\] 1: kind = "rain": use one of checksum, lost'),
    ('kind = "late"', "ms is missing"),
    ('kind = "late"\nof = "command"\nms = 5', 'of = "command": use one of reaction'),
    ('kind = "silent"\nwhich = 0', "which = 0: use a whole number from 1"),
    ('kind = "silent"\nprobability = 2', "probability = 2: use a number from 0 to 1"),
    ('kind = "silent"\ncharacter = 2', "unknown key character"),
    ('kind = "collision"', r"needs a second \[\[master\]\]"),
]


@pytest.mark.parametrize(("fault", "line"), WRONG_FAULTS)
def test_what_is_wrong_with_a_fault(fault: str, line: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=line):
        read(f"{BUS_OF_ONE}\n[[fault]]\n{fault}", tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("options", "cure"),
    [
        (["nothing"], "nothing is neither FILE.toml nor a built-in scenario: "),
        (["two\nlines"], "two\\nlines is neither FILE.toml nor a built-in scenario: "),
        (["/nowhere/x.toml"], "cannot read /nowhere/x.toml: No such file or directory; `sistap bus --list`"),
        (["drives", "-w", "x"], "drives has no master, it waits for a real one"),
        (["drives", "--listen", "127.0.0.1:0"], "drives has no master"),
        (["drives", "--duration", "3"], "leave out --duration"),
        (["drives", "--faults", "pause=0.1"], "--faults disturbs what a tap hears"),
        (["master"], "add --port PORT --transmit"),
        (["noise", "--rates", "9600"], "--rates is for the scenario demo"),
        (["noise", "--duration", "0"], "for example 60"),
        (["noise", "--duration", "nan"], "for example 60"),
        (["noise", "--duration", "inf", "-w", "x"], "for example 60"),
        (["--baud", "74", "-w", "x"], "--baud 74 is no rate (for example 9600): use a whole number from 75"),
        (["--baud", "1000000000000000000000", "-w", "x"], "is no rate (for example 9600): use a whole number from 75"),
        (["noise", "-w", "/nowhere/x"], "choose another file with -w"),
        (["--port", "/dev/null"], "add --transmit if that is what you want"),
        (["drives", "--port", "/dev/null"], "add --transmit if that is what you want"),
        (["--transmit"], "name it with --port"),
    ],
)
def test_wrong_options_get_one_line_with_the_cure(tmp_path: Path, options: list[str], cure: str) -> None:
    result = run(tmp_path, "bus", *options)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.count("\n") == 1
    assert cure in result.stderr


def test_a_file_that_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_bytes(b'title = "\xff"')
    with pytest.raises(ValueError, match="save the file as UTF-8"):
        load(str(tmp_path / "x.toml"))


# -- What goes wrong --------------------------------------------------------------------------------------------------

# A fault, how often which display filter then matches. Six commands and reactions of service 0x10, and what is sent
# again: by chapter 2.4 nobody answers what is damaged, and by 10.5 the master asks again.
FAULTS = [
    ("", {"sis.service == 0x10": 12, "sis.repeat_of": 0, "sertap.type == 1": 0, "sis.checksum.status == 0": 0}),
    (
        'kind = "checksum"\nof = "command"\nservice = 0x10\nwhich = 2',
        {"sis.service == 0x10": 13, "sis.checksum.status == 0": 1},
    ),
    (
        'kind = "checksum"\nof = "reaction"\nservice = 0x10\nwhich = 2',
        {"sis.service == 0x10": 14, "sis.checksum.status == 0": 1, "sis.repeat_of": 1},
    ),
    (
        'kind = "lost"\nof = "command"\nservice = 0x10\nwhich = 2\ncharacter = 8',
        {"sis.service == 0x10": 12, "sertap.type == 1": 1},
    ),
    (
        'kind = "extra"\nof = "reaction"\nservice = 0x10\nwhich = 2\ncharacter = 2\ncharacters = "FF"',
        {"sis.service == 0x10": 13, "sertap.type == 1": 1, "sis.repeat_of": 1},
    ),
    # 3 ms more than 1.15 are less than TzA, 8 ms are more; understood all the same
    ('kind = "pause"\nservice = 0x10\nwhich = 4\ncharacter = 6\nms = 3', {"sis.tza.verdict == 1": 0}),
    (
        'kind = "pause"\nservice = 0x10\nwhich = 4\ncharacter = 6\nms = 8',
        {"sis.service == 0x10": 12, "sis.tza.verdict == 1": 1, "sis.repeat_of": 0},
    ),
    (
        'kind = "late"\nservice = 0x10\nwhich = 2\nms = 55',
        {"sis.service == 0x10": 14, "sis.trs.verdict == 1": 1},
    ),
    # not by how much it is late counts, but when it begins: TzA and 47 ms are more than TrS
    (
        'kind = "late"\nservice = 0x10\nwhich = 2\nms = 47',
        {"sis.service == 0x10": 14, "sis.trs.verdict == 1": 1},
    ),
    ('kind = "late"\nservice = 0x10\nwhich = 2\nms = 20', {"sis.service == 0x10": 12, "sis.trs.verdict == 1": 0}),
    (
        'kind = "silent"\nservice = 0x10\nwhich = 2',
        {"sis.service == 0x10": 13, "sis.repeat_of": 1, "sis.twm.wait": 2},  # also after the broadcast
    ),
    (
        'kind = "parity"\nof = "command"\nservice = 0x10\nwhich = 2\ncharacter = 9',
        {"sis.service == 0x10": 13, "sertap.error.character": 1, "sis.checksum.status == 0": 1},
    ),
    (
        'kind = "break"\nof = "command"\nservice = 0x10\nwhich = 2\ncharacter = 9',
        {"sis.service == 0x10": 13, "sertap.error.break": 1, "sis.checksum.status == 0": 1},
    ),
    (
        'kind = "noise"\nof = "command"\nservice = 0x10\nwhich = [2, 3]',
        {"sis.service == 0x10": 12, "sertap.type == 1": 2},
    ),
    (
        'kind = "ascii"\nof = "command"\nservice = 0x10\nwhich = 2\ntext = "DKC02.3"',
        {"sis.service == 0x10": 12, 'sertap.type == 1 && frame contains "DKC02.3"': 1},
    ),
    (
        'kind = "baud"\nof = "command"\nservice = 0x10\nwhich = 2\nbaud = 19200',
        {"sis.service == 0x10": 12, "sertap.type == 1": 1},
    ),
    ('kind = "silent"\nfrom_s = 0\nto_s = 0.2', {"sis.repeat_of": 2}),  # after TrS and TwM, 110 ms, and once more
]


@pytest.mark.thorough
@pytest.mark.parametrize(("fault", "matches"), FAULTS)
def test_wireshark_sees_what_goes_wrong(fault: str, matches: dict[str, int], tmp_path: Path, sharkd: Sharkd) -> None:
    (tmp_path / "x.toml").write_text(BUS_OF_ONE + (f"\n[[fault]]\n{fault}\n" if fault else ""))
    file = tmp_path / "x.pcapng"
    record(str(tmp_path / "x.toml"), file)
    assert {name: len(sharkd.frames(file, name)) for name in matches} == matches


def test_a_command_that_was_not_answered_is_sent_again_after_trs_and_twm(tmp_path: Path) -> None:
    played = play(f'{BUS_OF_ONE}\n[[fault]]\nkind = "silent"\nservice = 0x10\nwhich = [1, 2, 3]', tmp_path)
    sent = commands(played)
    assert [one.sent for one in sent] == [READ] * (6 + 2)  # asked again twice, then given up
    for before, after in ((sent[0], sent[1]), (sent[1], sent[2])):
        wait_ns = after.time_ns - before.characters[-1].time_ns
        assert wait_ns >= (50 + 60) * MS
    reactions = [one for one in played if not is_command(one) and one.sent[5] == 0x10]
    assert len(reactions) == 5


@pytest.mark.parametrize(("form", "flags"), [("8E1", Flag.CHARACTER_ERROR), ("8O1", Flag.CHARACTER_ERROR), ("8N1", 0)])
def test_a_wrong_bit_is_told_by_the_parity_if_there_is_one(form: str, flags: int, tmp_path: Path) -> None:
    text = BUS_OF_ONE.replace("line = {", f'line = {{ format = "{form}",')
    played = play(f'{text}\n[[fault]]\nkind = "parity"\nservice = 0x10\nwhich = 1\ncharacter = 9', tmp_path)
    (disturbed,) = (one for one in played if one.marks)
    assert (disturbed.characters[9].value ^ disturbed.sent[9]).bit_count() == 1
    assert [character.flags for character in disturbed.characters] == [0] * 9 + [flags] + [0] * 3


def test_nobody_else_is_disturbed(tmp_path: Path) -> None:
    two = BUS_OF_ONE.replace("address = 3\n", "address = 3\n[[station]]\naddress = 4\n").replace(
        '{ read = "S-0-0051", station = 3 }', '{ read = "S-0-0051", station = 3 }, { read = "S-0-0051", station = 4 }'
    )
    played = play(f'{two}\n[[fault]]\nkind = "checksum"\nof = "reaction"\nstation = 4\nservice = 0x10', tmp_path)
    marked = [parse(one.sent).receiver for one in played if "checksum@1" in one.marks]
    assert marked == [4] * 6 * 3  # each, and what was asked for again


def test_a_probability_of_a_fault(tmp_path: Path) -> None:
    text = BUS_OF_ONE.replace("times = 6", "times = 1000")
    played = play(
        f'{text}\n[[fault]]\nkind = "pause"\nof = "command"\nservice = 0x10\nms = 1\nprobability = 0.3', tmp_path
    )
    paused = sum(bool(one.marks) for one in commands(played))
    assert 230 < paused < 370  # five standard deviations


# -- Several masters --------------------------------------------------------------------------------------------------


def test_the_token_goes_round() -> None:
    one = load("token")
    played = list(one.play(one.settings, Playing(cycles=2)))
    said = [(one.sent[6], one.sent[5]) for one in played if is_command(one)]
    assert said == [(16, 0x10), (16, 0x10), (16, 0x0F), (17, 0x10), (17, 0x0F)] * 2
    passing = [one.sent for one in played if one.sent[5] == 0x0F]
    assert passing[0] == octets("02 CE 00 00 00 0F 10 11")  # checksum by hand


def test_a_master_whose_script_is_over_hands_on(tmp_path: Path) -> None:
    ask = '{ phase = "read", station = 3 }'
    text = f"""title = ""
    station = [{{ address = 3 }}]
    [[master]]
    address = 16
    script = [{ask}]
    [[master]]
    address = 17
    script = [{ask}, {{ token = 16 }}, {ask}]"""
    said = [(one.sent[6], one.sent[5]) for one in play(text, tmp_path) if is_command(one)]
    assert said == [(16, 0x12), (17, 0x12), (17, 0x0F), (17, 0x12)]


def test_two_masters_at_once_are_mixed_and_both_ask_again() -> None:
    one = load("collision")
    played = list(one.play(one.settings, ONCE))
    (collided,) = (one for one in played if any(mark.startswith("collision") for mark in one.marks))
    place, other = re.fullmatch(r"collision@(\d+)=([0-9A-F]+)", collided.marks[0]).groups()  # type: ignore[union-attr]
    start, rival = int(place), bytes.fromhex(other)
    values = bytes(character.value for character in collided.characters)
    both = min(len(collided.sent) - start, len(rival))
    assert values[:start] == collided.sent[:start]
    assert values[start + both :] == rival[both:]
    for ours, theirs, heard in zip(collided.sent[start:], rival, values[start:], strict=False):
        assert heard & ~(ours ^ theirs) == ours & theirs  # on what they agree is heard
    overlap = slice(start, start + both)
    assert values[overlap] not in (collided.sent[overlap], rival[:both])  # of both something
    after = played[played.index(collided) + 1 :]
    said = [one.sent for one in after if is_command(one)]
    assert said[0] == collided.sent
    assert rival in said
    assert played[played.index(collided) + 1].sent == collided.sent  # nobody answered


def test_of_two_that_collided_neither_was_answered(tmp_path: Path) -> None:
    text = """title = ""
    station = [{ address = 3 }, { address = 4 }]
    [[master]]
    address = 16
    repeats = 0
    script = [{ read = "S-0-0051", station = 3 }, { phase = "read", station = 3 }, { token = 17 }]
    [[master]]
    address = 17
    repeats = 0
    script = [{ read = "S-0-0051", station = 4 }, { phase = "read", station = 4 }]
    [[fault]]
    kind = "collision"
    which = 1"""
    said = [(one.sent[6], one.sent[7], one.sent[5]) for one in play(text, tmp_path)]
    # A reaction keeps the addresses of its command. The reading of 17 was its part of the collision.
    assert said == [(16, 3, 0x10), *[(16, 3, 0x12)] * 2, (16, 17, 0x0F), *[(17, 4, 0x12)] * 2]


# -- At ports -------------------------------------------------------------------------------------------------------


@pytest.mark.thorough
@terminals
def test_our_master_talks_to_our_drives_over_a_pseudo_terminal(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with running("drives", "--baud", "115200") as (_, port):
        options = ["master", "--port", port, "--transmit", "--cycles", "2", "--baud", "115200", "--log", str(log)]
        done = subprocess.run([*BUS, *options], capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "11 commands, 11 reactions, 0 commands not answered\n"  # 3 and twice 4
    said = [octets(line.split()[1]) for line in log.read_text().splitlines()[1:]]
    assert len(said) == 22
    for command, reaction in zip(said[::2], said[1::2], strict=True):
        assert reaction[4] == command[4] | 0x10
        assert reaction[5:8] == command[5:8]


@terminals
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_drives_that_wait(number: signal.Signals) -> None:
    with running("drives") as (process, _):
        process.send_signal(number)
        assert finish(process) == (0, "")


@terminals
def test_a_signal_ends_a_master_that_talks(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with (
        running("drives") as (_, port),
        subprocess.Popen(
            [*BUS, "master", "--port", port, "--transmit", "--log", str(log)], stdout=subprocess.PIPE, text=True
        ) as master,
    ):
        while not log.exists() or log.read_text().count("\n") < 3:
            assert master.poll() is None
        master.terminate()
        output, _ = master.communicate(timeout=TIMEOUT_S)
    assert master.returncode == 0
    assert re.fullmatch(r"\d+ commands, \d+ reactions, \d+ commands not answered\n", output)


@contextmanager
def recording_into_a_pipe() -> Iterator[tuple[subprocess.Popen[str], int, int]]:
    """Record endlessly; return the process, and both ends of its pipe."""
    ours, theirs = os.pipe()
    process = subprocess.Popen(
        [*BUS, "-w", "-", "--cycles", "1000000", "--reads", "60"], stdout=theirs, stderr=subprocess.PIPE, text=True
    )
    try:
        yield process, ours, theirs
    finally:
        process.kill()
        process.communicate()
        os.close(ours)
        os.close(theirs)


@signals
def test_signals_end_a_recording_after_a_whole_block() -> None:
    with recording_into_a_pipe() as (process, ours, _):
        data = os.read(ours, 1)
        process.terminate()
        process.send_signal(signal.SIGINT)  # a second one does not come between
        while process.poll() is None or select.select([ours], [], [], 0)[0]:
            if select.select([ours], [], [], 0.1)[0]:
                data += os.read(ours, 65536)
        code, said = finish(process)
        assert code == 0
        assert said.endswith("written to standard output\n")
    while data:
        length = int.from_bytes(data[4:8], "little")
        assert data[length - 4 : length] == data[4:8]
        data = data[length:]


@signals
def test_a_signal_ends_a_recording_that_nobody_reads() -> None:
    with recording_into_a_pipe() as (process, ours, theirs):
        assert os.read(ours, 1)
        while select.select([], [theirs], [], 0)[1]:
            assert process.poll() is None
        process.terminate()
        assert finish(process) == (
            1,
            "sistap bus: standard output is not being read; the last records are missing in it\n",
        )


def test_without_transmit_a_port_is_not_even_opened(tmp_path: Path) -> None:
    result = subprocess.run(
        [*BUS, "master", "--port", str(tmp_path / "none")], capture_output=True, text=True, check=False
    )
    assert result.returncode == 2  # 3 would be: it cannot be opened


def test_a_port_that_is_not_there() -> None:
    for name in ("demo", "drives", "master"):
        command = [*BUS, name, "--port", "/dev/nowhere", "--transmit"]
        result = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
        assert (result.returncode, result.stderr) == (
            3,
            "sistap: /dev/nowhere does not exist: `sistap ports` lists the ports there are\n",
        )


def test_the_list_needs_no_pyserial() -> None:
    code = "import sys; sys.modules['serial'] = None; from sistap.cli import main; sys.exit(main(['bus', '--list']))"
    assert subprocess.run([sys.executable, "-c", code], check=False, stdout=subprocess.DEVNULL).returncode == 0
