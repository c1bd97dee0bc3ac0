# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap compare`: evening and night of the virtual bus, whose differences are written down in their scenarios."""

from __future__ import annotations

import itertools
import json
from datetime import datetime
from pathlib import Path
from typing import Any

import planted
import pytest
from commands import refused, run
from report_capture import ACCEPT, ANSWER, BUS, READ, READ_4, SET_TRS, SET_TZA, Sent, write

from sistap.dissected.captures import reading
from sistap.tap.files import pcapng
from sistap.tap.line.settings import Flag
from sistap.tap.sis.telegram import build

READ_BODY, ANSWER_BODY = bytes.fromhex("3C 03 00 28 00"), bytes.fromhex("00 3C 03 E8 03")  # those of READ, ANSWER

EVENING = """\
title = "an evening on which all is well"
[line]
trs_ms = 50
twm_ms = 60
[[station]]
address = 3
[[station]]
address = 4
[[master]]
address = 16
script = [
    { set = "TrS", ms = 50, station = 3 },
    { set = "TrS", ms = 50, station = 4 },
    { set = "accept", station = 255, device = 0 },
    { read = "S-0-0091", station = 4 },
    WRITE
    { loop = [{ read = "S-0-0036", station = 3 }, { read = "S-0-0036", station = 4 }] },
]
"""
# From 2 s on drive 4 is 20 ms slower, and two of its reactions never come.
NIGHT = """
[[fault]]
kind = "late"
station = 4
ms = 20
from_s = 2
[[fault]]
kind = "silent"
station = 4
which = [60, 70]
"""
WRITE = '{ write = "S-0-0091", value = 10, station = 4 },'


def play(folder: Path, name: str, text: str, seed: int) -> Path:
    scenario = folder / f"{name}.toml"
    scenario.write_text(text)
    done = run(folder, "bus", scenario, "--seed", str(seed), "--duration", "12", "-w", f"{name}.pcapng")
    assert done.returncode == 0, done.stderr
    return folder / f"{name}.pcapng"


@pytest.fixture(scope="module")
def bus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("bus")
    evening, night = EVENING.replace("WRITE", ""), EVENING.replace("WRITE", WRITE) + NIGHT
    return {
        "evening": play(folder, "evening", evening, 5),
        "next": play(folder, "next", evening, 6),
        "night": play(folder, "night", night, 5),
    }


def lines(text: str) -> dict[str, list[str]]:
    """Return the findings by subject; they directly follow the two sides."""
    found = text.splitlines()
    assert [line.partition(" ")[0] for line in found[:3]] == ["good:", "bad:", ""]
    told: dict[str, list[str]] = {}
    subject = ""
    for line in found[3:]:
        if not line:
            break
        subject = line[:7].strip() or subject
        told.setdefault(subject, []).append(line[9:])
    return told


def as_json(folder: Path, *arguments: str | Path) -> Any:
    done = run(folder, "compare", *arguments, "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


@pytest.mark.usefixtures("dissector")
def test_the_first_lines_say_what_happened_in_the_night(tmp_path: Path, bus: dict[str, Path]) -> None:
    done = run(tmp_path, "compare", bus["evening"], bus["night"])
    assert (done.returncode, done.stderr) == (0, "")
    told = lines(done.stdout)
    assert list(told) == ["Bus", "Silent", "Drives", "Changed", "Limits", "Times"]
    (write,) = told["Changed"]
    assert write.startswith(
        "Limit of a drive written, station 4 S-0-0091: 00 2d 31 01 -> 0a 00 00 00 by master 16; still set at the end, "
    )
    (slower,) = told["Times"]
    assert slower.startswith("station 4 answers Read parameter (0x10) slower: half within ")
    (again,) = told["Limits"]
    assert again.startswith("Sent again, station 4: a command without a reaction (2 times), ")
    assert told["Bus"] == told["Silent"] == told["Drives"] == ["nothing differs"]


@pytest.mark.parametrize("fault", planted.PLANTED, ids=lambda fault: f"{fault.kind}-{fault.station}")
def test_what_was_planted_in_the_night_is_told_with_its_time_and_station(
    nights: dict[str, Any], fault: planted.Planted
) -> None:
    found = [one for one in nights["episodes"] if (one["kind"], one["station"]) == (fault.kind, fault.station)]
    assert all(one["differs"] and one["good"] == 0 for one in found)
    # Two damaged telegrams of a station are one finding.
    assert any(second(one["from"]) - 1 <= fault.second <= second(one["to"]) + 1 for one in found)


def second(time: str) -> float:
    return datetime.fromisoformat(time).timestamp() - planted.BEGIN_S


def test_a_new_master_is_not_chance_and_its_write_comes_first(nights: dict[str, Any]) -> None:
    sure = [one for one in nights["episodes"] if one["kind"] in ("master", "write", "silent")]
    assert sure and not any(one["may_be_chance"] for one in sure)
    assert "2000.0000 -> 200.0000 by new master 17" in nights["lines"]["Changed"][0]
    assert not [text for text in nights["lines"]["Changed"] if "chance" in text]


@pytest.fixture(scope="module")
def nights(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A clean night of one seed, and one with planted events of another."""
    folder = tmp_path_factory.mktemp("nights")
    good = planted.play(folder / "good.pcapng", seed=1, is_clean=True)
    return as_json(folder, good, planted.play(folder / "bad.pcapng", seed=2))


def test_each_error_code_is_named(tmp_path: Path) -> None:
    """Of six codes, none is behind "and 3 more"."""
    codes = [0x8001, 0x8002, 0x8004, 0x8005, 0x800B, 0x800C]
    refusals = [build(0x10, 16, 3, b"\x01\x3c\x03" + code.to_bytes(2, "little"), reaction=True) for code in codes]
    exchanges = itertools.chain(*((Sent(READ), Sent(refusal)) for refusal in refusals))
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER)] * 30)
    bad = write(tmp_path / "bad.pcapng", [Sent(READ), Sent(ANSWER), *exchanges])
    drives = " ".join(as_json(tmp_path, good, bad)["lines"]["Drives"])
    assert [code for code in codes if f"0x{code:04x}" not in drives] == []


def test_a_master_of_the_good_side_is_not_new(tmp_path: Path) -> None:
    """17 asks once on the good side. On the bad one it asks after the 200 commands that the engine learns from."""
    by_17, by_18 = (
        [Sent(build(0x10, master, 3, READ_BODY)), Sent(build(0x10, master, 3, ANSWER_BODY, reaction=True))]
        for master in (17, 18)
    )
    usual = [Sent(READ), Sent(ANSWER)] * 210
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER), *by_17])
    told = as_json(tmp_path, good, write(tmp_path / "bad.pcapng", [*by_18, *usual, *by_17]))
    (new,) = (one["text"] for one in told["episodes"] if one["kind"] == "master")
    assert new == "New master: master 18 asked station 3: 1 command, 1 value read, 0 written"


@pytest.mark.thorough
def test_how_much_slower(tmp_path: Path, bus: dict[str, Path]) -> None:
    compared = as_json(tmp_path, bus["evening"], bus["night"])
    [slower] = [times for times in compared["times"] if times["differs"]]
    half = slower["half_within"]
    assert slower["station"] == 4
    assert half["bad_s"] - half["good_s"] == pytest.approx(0.020, abs=0.002)
    assert not half["may_be_chance"]


@pytest.mark.thorough
def test_another_evening_is_nothing_to_cry_about(tmp_path: Path, bus: dict[str, Path]) -> None:
    compared = as_json(tmp_path, bus["evening"], bus["next"])
    assert not any(compared["lines"].values())
    assert not compared["differs"]


@pytest.mark.thorough
def test_a_capture_and_itself(tmp_path: Path, bus: dict[str, Path]) -> None:
    done = run(tmp_path, "compare", bus["night"], bus["night"], "--format", "json")
    assert "night.pcapng is named twice: what is on both sides cannot differ" in " ".join(done.stderr.split())
    compared = json.loads(done.stdout)
    assert not compared["differs"]
    assert all(times["half_within"]["may_be_chance"] for times in compared["times"])


@pytest.mark.parametrize("at", [4, 5, 9, 11])
def test_a_side_may_be_in_several_files(tmp_path: Path, at: int) -> None:
    """They are read as one, wherever they begin: limits hold, and a reaction may belong to the file before."""
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER)])
    bad = write(tmp_path / "bad.pcapng", BUS)
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(pcapng.Interface(252, "test"))]
    packets = [pcapng.enhanced_packet(0, one.time_ns or 0, one.data) for one in reading.packets(bad)]
    for name, some in (("1", packets[:at]), ("2", packets[at:])):
        (tmp_path / name).write_bytes(b"".join([*blocks, *some]))
    whole, cut = (as_json(tmp_path, "--good", good, "--bad", *files) for files in ([bad], ["1", "2"]))
    for name in ("settings", "times", "services", "episodes"):
        assert cut[name] == whole[name], name


@pytest.mark.thorough
def test_several_files_of_a_side(tmp_path: Path, bus: dict[str, Path]) -> None:
    both = as_json(tmp_path, "--good", bus["evening"], bus["next"], "--bad", bus["night"])
    alone = [as_json(tmp_path, bus[name], bus["night"])["good"] for name in ("evening", "next")]
    assert both["good"]["captures"] == ["evening.pcapng", "next.pcapng"]
    assert both["good"]["telegrams"] == sum(one["telegrams"] for one in alone)


def test_who_left_and_who_is_new(tmp_path: Path) -> None:
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER)] * 30)
    answer_of_4 = build(0x10, 16, 4, bytes.fromhex("00 3C 04 E8 03"), reaction=True)
    bad = write(tmp_path / "bad.pcapng", [Sent(READ_4), Sent(answer_of_4)] * 30)
    told = as_json(tmp_path, good, bad)
    assert {count["what"]: (count["good"], count["bad"]) for count in told["stations"]} == {
        "station 3": (30, 0),
        "station 4": (0, 30),
    }
    (gone,) = (text for text in told["lines"]["Silent"] if text.startswith("gone: station 3, 30 times"))
    assert "new: station 4, 30 times" in told["lines"]["Changed"]


@pytest.mark.thorough
def test_who_is_asked_and_never_answers(tmp_path: Path) -> None:
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER)] * 30)
    bad = write(tmp_path / "bad.pcapng", [Sent(READ), Sent(ANSWER), Sent(READ_4)] * 30)
    told = as_json(tmp_path, good, bad)
    assert told["stations"] == []
    # The last command is not known to be unanswered: its master says no more.
    assert [(one["what"], one["good"], one["bad"]) for one in told["services"]] == [
        ("Read parameter (0x10) of station 4", 0, 29)
    ]


def test_times_that_were_not_measured(tmp_path: Path) -> None:
    """A command and its reaction in one read, and TrS set: judged, but nobody knows how long it took."""
    whole = [Sent(one, flags={place: Flag.SAME_READ for place in range(1, len(one) + 1)}) for one in (READ, ANSWER)]
    capture = write(tmp_path / "one-read.pcapng", [Sent(SET_TRS), Sent(SET_TZA), Sent(ACCEPT), *whole])
    other = write(tmp_path / "other.pcapng", [Sent(SET_TRS), Sent(SET_TZA), Sent(ACCEPT), *whole[::-1], *whole])
    times = as_json(tmp_path, capture, other)["times"]
    assert {one["what"] for one in times} == {"from character to character"}
    assert all(one["good"]["count"] and one["good"]["shortest_s"] is not None for one in times)


@pytest.mark.thorough
def test_limits_and_faults(tmp_path: Path) -> None:
    """BUS has limits, a line error and lost characters; the other side has one good exchange."""
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER)])
    told = as_json(tmp_path, good, write(tmp_path / "bad.pcapng", BUS))
    settings = {one["what"]: (one["good"], one["bad"]) for one in told["settings"]}
    assert settings["TzA"] == ("none", "5 ms")
    assert settings["TrS"] == ("none", "50 ms")
    assert settings["Rate and format"] == ("9600 Bd 8E1", "9600 Bd 8E1")
    faults = {one["kind"]: (one["good"], one["bad"]) for one in told["episodes"]}
    assert faults["line_error"] == (0, 1)
    assert faults["lost"] == (0, 1)
    assert faults["interval"] == (0, 1)


@pytest.mark.thorough
def test_a_page(tmp_path: Path, bus: dict[str, Path]) -> None:
    done = run(tmp_path, "compare", bus["evening"], bus["night"], "--format", "html", "-o", "changed.html")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    page = (tmp_path / "changed.html").read_text()
    assert page.startswith("<!DOCTYPE html>")
    assert "S-0-0091" in page
    assert "<script" not in page
    assert "http" not in page


@pytest.mark.thorough
def test_a_capture_that_is_cut_or_empty(tmp_path: Path, bus: dict[str, Path]) -> None:
    cut = tmp_path / "cut.pcapng"
    cut.write_bytes(bus["night"].read_bytes()[:-40])
    done = run(tmp_path, "compare", bus["evening"], cut)
    assert done.returncode == 0
    assert done.stderr.count("\n") == 1
    assert "before the damage" in done.stderr
    empty = write(tmp_path / "empty.pcapng", [], dissector="sis")
    done = run(tmp_path, "compare", empty, empty)
    assert (done.returncode, done.stderr) == (0, f"sistap: {empty} has no packets\n" * 2)
    assert "0 telegrams" in done.stdout


@pytest.mark.thorough
def test_what_cannot_be_compared(tmp_path: Path, bus: dict[str, Path]) -> None:
    evening = bus["evening"]
    for wrong in ([evening], [evening] * 3, ["--good", evening], ["--good", evening, "--bad", evening, "--", evening]):
        refused(run(tmp_path, "compare", *wrong), 2, "two captures", "--good")
    refused(run(tmp_path, "compare", evening, "none.pcapng"), 2, "cannot read none.pcapng")
    refused(run(tmp_path, "compare", evening, "."), 2, ". has no captures")
    (tmp_path / "junk").write_text("this is no capture\n" * 9)
    refused(run(tmp_path, "compare", evening, "junk"), 2, "junk is not a capture")
    refused(run(tmp_path, "compare", evening, evening, "-o", evening), 2, "is the capture itself", "-o")
    refused(run(tmp_path, "compare", evening, bus["night"], "-o", "/no/such/file"), 2, "cannot write")


def test_a_value_that_changed_between_the_captures(tmp_path: Path) -> None:
    """Nobody wrote it: 1000 on one side, 1001 on the other."""
    other = build(0x10, 16, 3, bytes.fromhex("00 3C 03 E9 03"), reaction=True)
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER)] * 30)
    told = as_json(tmp_path, good, write(tmp_path / "bad.pcapng", [Sent(READ), Sent(other)] * 30))
    (changed,) = told["lines"]["Changed"]
    assert "S-0-0040" in changed and changed.endswith("e9 03, was e8 03")
