# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap compare`: evening and night of the virtual bus, whose differences are written down in their scenarios."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from commands import refused, run
from report_capture import ANSWER, BUS, READ, READ_4, Sent, write

from sistap.sis.telegram import build

HOUSE = Path(__file__).parent.parent.parent

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


@pytest.fixture(params=["plugin", "script"])
def dissector(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the plugin that was built, and with sis.lua."""
    if request.param == "script":
        (tmp_path / "plugins").mkdir()
        shutil.copy(HOUSE / "lua-fallback" / "sis.lua", tmp_path / "plugins")
        monkeypatch.setenv("WIRESHARK_PLUGIN_DIR", str(tmp_path / "plugins"))


def lines(text: str) -> dict[str, str]:
    """Return the five lines by their subjects; they directly follow the two sides."""
    found = text.splitlines()
    assert [line.partition(" ")[0] for line in found[:3]] == ["good:", "bad:", ""]
    assert found[8:9] in ([""], [])
    return {subject: told.strip() for subject, told in ((line[:20].strip(), line[20:]) for line in found[3:8])}


def as_json(folder: Path, *arguments: str | Path) -> Any:
    done = run(folder, "compare", *arguments, "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


@pytest.mark.usefixtures("dissector")
def test_five_lines_say_what_happened_in_the_night(tmp_path: Path, bus: dict[str, Path]) -> None:
    done = run(tmp_path, "compare", bus["evening"], bus["night"])
    assert (done.returncode, done.stderr) == (0, "")
    told = lines(done.stdout)
    assert told["Stations, services"] == "new: Write parameter (0x1f) of station 4, once (may be chance)"
    # The write is the tenth packet: the event, three settings of limits with their two reactions, a reading.
    assert told["Parameters"].endswith("was 00 2d 31 01, written by 16 in packet 10 of night.pcapng")
    assert told["Parameters"].startswith("station 4 S-0-0091 (Bipolar velocity limit value) 0a 00 00 00,")
    assert told["Times"].startswith("station 4 answers Read parameter (0x10) slower: half within ")
    assert "Command without a reaction 2, was 0" in told["Errors"]
    assert told["Line, limits"] == "nothing differs"


@pytest.mark.thorough
def test_how_much_slower(tmp_path: Path, bus: dict[str, Path]) -> None:
    compared = as_json(tmp_path, bus["evening"], bus["night"])
    [slower] = [times for times in compared["times"] if times["differs"]]
    half = slower["half_within"]
    assert slower["station"] == 4
    assert half["bad_s"] - half["good_s"] == pytest.approx(0.020, abs=0.002)
    assert half["chance"] < 0.01


@pytest.mark.thorough
def test_another_evening_is_nothing_to_cry_about(tmp_path: Path, bus: dict[str, Path]) -> None:
    compared = as_json(tmp_path, bus["evening"], bus["next"])
    assert set(compared["lines"].values()) == {"nothing differs"}
    assert not compared["differs"]


@pytest.mark.thorough
def test_a_capture_and_itself(tmp_path: Path, bus: dict[str, Path]) -> None:
    compared = as_json(tmp_path, bus["night"], bus["night"])
    assert not compared["differs"]
    assert {one["chance"] for times in compared["times"] for one in (times["half_within"],)} == {1.0}


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
    line = told["lines"]["Stations, services"]
    assert "gone: station 3, 30 times" in line
    assert "new: station 4, 30 times" in line
    assert "may be chance" not in line


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


@pytest.mark.thorough
def test_limits_and_faults(tmp_path: Path) -> None:
    """BUS has limits, a line error and lost characters; the other side has one good exchange."""
    good = write(tmp_path / "good.pcapng", [Sent(READ), Sent(ANSWER)])
    told = as_json(tmp_path, good, write(tmp_path / "bad.pcapng", BUS))
    settings = {one["what"]: (one["good"], one["bad"]) for one in told["settings"]}
    assert settings["TzA"] == ("none", "5 ms")
    assert settings["TrS"] == ("none", "50 ms")
    assert settings["Rate and format"] == ("9600 Bd 8E1", "9600 Bd 8E1")
    faults = {one["what"]: (one["good"], one["bad"]) for one in told["faults"]}
    assert faults["Damaged telegram"] == (0, 1)
    assert faults["Error or break on the line"] == (0, 1)
    assert faults["Interval in a telegram longer than TzA"] == (0, 1)
    assert told["lines"]["Line, limits"] == "TzA 5 ms, was none; TrS 50 ms, was none"


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
    assert (done.returncode, done.stderr) == (0, "")
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
    refused(run(tmp_path, "compare", evening, evening, "-o", "/no/such/file"), 2, "cannot write")
