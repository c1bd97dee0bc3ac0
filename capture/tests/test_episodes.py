# SPDX-License-Identifier: GPL-2.0-or-later
"""Episodes: what was planted is found, with time and station; nothing else is."""

from __future__ import annotations

import itertools
import json
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import planted
import pytest
from machines import FAULT, LAPTOP, RUNS, Machine, access, packet, telegram
from report_capture import ANSWER, READ, Sent, write
from test_levels import scattered

from sistap import cli
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.rules import RULES, THRESHOLDS, Subject
from sistap.dissected.episodes.silence import BusSilence, StationSilence
from sistap.dissected.episodes.states import RateChanges
from sistap.dissected.packets.dissection import Telegram
from sistap.dissected.wireshark.rows import EVENT
from sistap.tap.records.record import KEPT, Event
from sistap.tap.terminal.exits import USAGE

CAPTURES = Path(__file__).parents[2] / "test-captures"


def told(capsys: pytest.CaptureFixture[str], *captures: str | Path) -> list[dict[str, Any]]:
    capsys.readouterr()
    assert cli.main(["report", "--format", "json", *map(str, captures)]) == 0
    found: list[dict[str, Any]] = json.loads(capsys.readouterr().out)["episodes"]
    return found


def second(time: str) -> float:
    return datetime.fromisoformat(time).timestamp() - planted.BEGIN_S


def is_told(event: planted.Planted, episodes: Sequence[dict[str, Any]]) -> bool:
    return any(
        episode["kind"] == event.kind
        and episode["station"] == event.station
        and abs(second(episode["from"]) - event.second) <= 1
        and (episode["parameter"] or "") == event.parameter
        for episode in episodes
    )


SEEDS = [1, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(2, 7))]


@pytest.mark.parametrize("seed", SEEDS)
def test_each_planted_event_is_an_episode_with_its_time_and_station(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], seed: int
) -> None:
    episodes = told(capsys, planted.play(tmp_path / "night.pcapng", seed=seed))
    assert [event for event in planted.PLANTED if not is_told(event, episodes)] == []
    assert len(episodes) == len(planted.PLANTED) + 1  # the master that writes is new, too
    (silent,) = (episode for episode in episodes if episode["kind"] == "silent")
    assert second(silent["to"]) == pytest.approx(160, abs=1)
    assert silent["count"] == 1 and silent["severity"] == "error" and silent["worst"] > 40
    (write,) = (episode for episode in episodes if episode["kind"] == "write")
    assert "2000.0000 -> 200.0000 by new master 17" in write["text"]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_night_without_events_has_no_episode(tmp_path: Path, capsys: pytest.CaptureFixture[str], seed: int) -> None:
    assert told(capsys, planted.play(tmp_path / "clean.pcapng", seed=seed, is_clean=True)) == []


def test_two_lines_have_a_silence_each_and_one_clock(capsys: pytest.CaptureFixture[str]) -> None:
    """An interval is that to the character before on its own line."""
    assert told(capsys, CAPTURES / "3964r.pcapng") == []


def test_a_master_that_asks_once_a_minute_is_no_fault(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capture = tmp_path / "night.pcapng"
    assert cli.main(["bus", "night", "--duration", "3600", "-w", str(capture)]) == 0
    assert [episode["severity"] for episode in told(capsys, capture) if episode["kind"] == "bus_silent"] == ["note"]


def heard(silences_s: Iterable[float]) -> list[Hit]:
    """Return the silences that are told of a bus with a character before and after each of these."""
    silence, now_s = BusSilence(), 0.0
    told: list[Hit] = []
    for length_s in (0.0, *silences_s):
        now_s += length_s
        told += silence.add(replace(packet(now_s), since_s=length_s))
    return told


TALK = [0.1] * 150  # exchanges of 15 s


def test_a_cable_that_is_off_again_and_again_is_told_each_time() -> None:
    flaps_s = [10, 10.5, 10, 9.5, 60, 10, 60, 5]
    silences_s = [*TALK * 10, *(silence_s for flap_s in flaps_s for silence_s in (*TALK, flap_s))]
    assert [hit.worst for hit in heard(silences_s)] == pytest.approx(flaps_s)
    assert all(hit.severity is None for hit in heard(silences_s))


def test_a_master_that_pauses_in_a_rhythm_is_known_after_a_while() -> None:
    """It talks longer than what is usual is remembered. A silence beside the rhythm is told."""
    rhythm_s = [silence_s for _ in range(60) for silence_s in (*TALK * 4, 45.0)]
    kinds = [hit.kind for hit in heard(rhythm_s)]
    alone = THRESHOLDS.rhythm_times + 1  # the first one begins it
    assert kinds == ["bus_silent"] * alone + ["rhythm"] * (60 - alone)
    told = [hit.worst for hit in heard([*rhythm_s, *TALK, 300.0, *rhythm_s]) if hit.kind == "bus_silent"]
    assert told[-2:] == pytest.approx([300, 45])


def test_what_recurs_in_a_rhythm_is_told_as_one(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each is counted: a cable may fail in a rhythm, too."""
    talk = [Sent(READ), Sent(ANSWER)] * 400
    pauses = [one for _ in range(14) for one in (Sent(READ, silence_ms=10_000.0), Sent(ANSWER), *talk)]
    capture = write(tmp_path / "rhythm.pcapng", [*talk, *pauses])
    episodes = told(capsys, capture)
    alone = THRESHOLDS.rhythm_times + 1
    assert [episode["kind"] for episode in episodes] == ["bus_silent"] * alone + ["rhythm"]
    assert episodes[-1]["count"] == 14 - alone and episodes[-1]["severity"] == "note"
    assert cli.main(["report", "--format", "text", str(capture)]) == 0
    first = " ".join(capsys.readouterr().out.split())
    assert f"Bus silent {alone} times (longest 10 s at " in first and "Bus silent 3 times in a rhythm" in first


def test_values_after_a_write_without_a_reaction_are_no_step() -> None:
    """Nobody knows whether the drive took the command. The next write is answered."""
    engine = Engine()
    numbers = itertools.count(1)

    def say(value: float, *, is_write: bool = False, has_reaction: bool = True) -> None:
        number = next(numbers)
        ident, service = ("S-0-0036", 0x1F) if is_write else ("S-0-0040", 0x10)
        columns = {"sis.parameter": ident, "sis.service": str(service)}
        asked = telegram(16, 3, service=service, unanswered=not has_reaction, columns=columns)
        said = access(3, ident, value, master=16, is_write=is_write)
        engine.add(packet(10.0 * number, asked, accesses=[said] if has_reaction else []))

    for command, has_reaction in ((1000, True), (1100, True), (950, False), (1000, True)):
        say(command, is_write=True, has_reaction=has_reaction)
        for value in scattered(command, 60, command):
            say(value)
    assert not [one for one in engine.finish() if one.kind == "step"]


@pytest.mark.parametrize(
    ("after", "outcome"),
    [
        ((), "still set at the end"),
        (("500 rpm",), "still set at the end"),
        (("480 rpm",), "at the end 480 rpm"),
    ],
)
def test_what_became_of_what_a_new_master_wrote(after: Sequence[str], outcome: str) -> None:
    machine = Machine(4)
    machine.run(150)
    machine.exchange(access(4, "P-0-0091", "3000 rpm"))
    machine.write(4, "P-0-0091", "500 rpm", master=LAPTOP)
    for value in after:
        machine.exchange(access(4, "P-0-0091", value))
    (written,) = machine.told().of("write")
    assert (written.hit.detail, written.outcome) == ("3000 rpm -> 500 rpm by new master 127", outcome)
    assert written.text.endswith(f"by new master 127; {outcome}")


def test_what_lasts_to_the_end_says_so() -> None:
    machine = Machine(4, 5, 6)
    for code, torque in ((RUNS, 20.0), (FAULT, 20.0), (RUNS, 20.0), (FAULT, 60.0)):
        machine.says[4] = code
        machine.run(200, access(4, "S-0-0084", torque, unit="%"))
    found = [(one.kind, round(one.from_s - machine.begin_s, -2), one.outcome) for one in machine.told().episodes]
    lasting = "still so when last read"
    assert found == [("fault", 200, ""), ("fault", 600, lasting)]  # the step is one with the fault


@pytest.mark.parametrize(("first", "outcome"), [(4, "not heard again"), (5, "")])
def test_a_station_that_is_silent_to_the_end(first: int, outcome: str) -> None:
    """One that never answered is perhaps not there."""
    silence = StationSilence()
    header: tuple[Any, ...] = (None, None, None, None, None, None, {})
    for number in range(1, 11):
        command = (True, 0x10, 16, 4, False, None, False, False, False, number >= first or first == 5, "", False, None)
        said = [Telegram(*command, *header)]
        if number < first < 5:
            said.append(Telegram(True, 0x10, 4, 16, True, 0, False, False, False, False, "", False, number, *header))
        assert list(silence.add(replace(packet(float(number)), telegrams=said))) == []
    assert [(hit.kind, hit.outcome) for hit in silence.finish("")] == [("silent", outcome)]


def test_values_in_the_next_file_of_a_recorder_are_no_step() -> None:
    """The command was written between the two files, and is in neither."""
    engine, now_s = Engine(), itertools.count(0, 10)

    def say(ident: str, value: float) -> None:
        said = access(3, ident, value, is_write=ident == "S-0-0036")
        engine.add(packet(next(now_s), accesses=[said]))

    for commands in ([1000.0], [], [1200.0]):  # each in a file
        started: dict[str, Any] = {"type": EVENT, "event": Event.CAPTURE_STARTED, "text": f"a tap{KEPT}late"}
        engine.add(packet(next(now_s), **started))
        for command in commands:
            say("S-0-0036", command)
        for value in scattered(1, 60, *(commands or [1100.0])):
            say("S-0-0040", value)
    assert not [one for one in engine.finish() if one.kind == "step"]


def test_what_a_file_begins_with_again_has_no_rate() -> None:
    rate = RateChanges()
    said = [replace(packet(second), baud=baud) for second, baud in enumerate((19200, 9600, 19200, 9600))]
    said[1] = replace(said[1], type=EVENT, event=Event.CAPTURE_STARTED, is_again=True)
    assert [hit.from_s for one in said for hit in rate.add(one)] == [3]


@pytest.mark.parametrize(("longest_s", "count"), [("299", 1), ("301", 0)])
def test_a_threshold_can_be_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], longest_s: str, count: int
) -> None:
    exchange = [Sent(READ), Sent(ANSWER)] * 2
    capture = write(tmp_path / "dead.pcapng", [*exchange, Sent(READ, silence_ms=300_000.0), Sent(ANSWER)])
    assert len(told(capsys, "--rule", f"bus_silent_s={longest_s}", "--rule", "silent_s=2", capture)) == count


@pytest.mark.parametrize("command", ["compare", "annotate", "tables"])
def test_every_command_has_the_same_rules(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """A capture with a silence of five minutes is no longer unusual."""
    if command == "tables":
        pytest.importorskip("pyarrow", reason="pyarrow writes the tables: pip install pyarrow")
    exchange = [Sent(READ), Sent(ANSWER)] * 2
    good = write(tmp_path / "good.pcapng", exchange)
    dead = write(tmp_path / "dead.pcapng", [*exchange, Sent(READ, silence_ms=300_000.0), Sent(ANSWER)])
    (tmp_path / "log.txt").write_text(cli_output(capsys, "log", str(dead)))
    arguments = {
        "compare": [str(good), str(dead)],
        "annotate": [str(tmp_path / "log.txt")],
        "tables": [str(dead), "-o", str(tmp_path / "t")],
    }
    finished: list[list[Episode]] = []
    finish = Engine.finish

    def watched(engine: Engine) -> list[Episode]:
        finished.append(finish(engine))
        return finished[-1]

    monkeypatch.setattr(Engine, "finish", watched)
    for longest_s, count in (("299", 1), ("301", 0)):
        assert cli.main([command, *arguments[command], "--rule", f"bus_silent_s={longest_s}"]) == 0
        assert sum(episode.kind == "bus_silent" for episode in finished[-1]) == count


def cli_output(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    capsys.readouterr()
    assert cli.main([*arguments]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize(
    "rule", ["silence=3", "bus_silent_s", "bus_silent_s=-1", "bus_silent_s=nan", "rare_writes=1.5"]
)
def test_a_rule_that_is_none(capsys: pytest.CaptureFixture[str], rule: str) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["report", "--rule", rule, "x.pcapng"])
    assert ended.value.code == USAGE and "--rule" in capsys.readouterr().err


def test_every_kind_has_a_subject_and_a_title() -> None:
    assert {rule.subject for rule in RULES.values()} == set(Subject)
    assert all(rule.title for rule in RULES.values())


def test_a_rule_finds_all_that_has_the_colour_of_its_fault() -> None:
    """What is wrong with a telegram is said in one place."""
    faults = tomllib.loads((CAPTURES.parent / "plugin/protocol/faults.toml").read_text())["faults"]
    for kind, name in (("error", "error_reaction"), *((name, name) for name in ("damaged", "line_error", "lost"))):
        assert set(faults[name]["tests"]) <= set(RULES[kind].filter.split(" || ")), kind
