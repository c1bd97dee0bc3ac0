# SPDX-License-Identifier: GPL-2.0-or-later
"""Two captures of the same traffic beside each other: `selftest --beside`."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from sistap import cli
from sistap.commands.beside.aligning import aligned, frames
from sistap.commands.beside.comparing import Comparison
from sistap.commands.beside.lateness import Late, Lateness, drawing, measured
from sistap.dissected.captures.reading import records
from sistap.dissected.draw.svg import svg
from sistap.tap.common.quantiles import quantile
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.settings import Read
from sistap.tap.records.assembler import Assembler
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Type

MS = 1_000_000
HOUR = 3_600_000 * MS

Delay = Callable[[int], int]  # how late the character of this number is


@pytest.fixture(scope="module")
def true(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Slow characters, with the times that they have."""
    file = tmp_path_factory.mktemp("beside") / "true.pcapng"
    assert cli.main(["bus", "slow-characters", "-w", str(file)]) == 0
    return file


def taken(  # noqa: PLR0913 - all that a tap can do
    true: Path,
    delay: Delay = lambda number: 0,
    *,
    offset_ns: int = 0,
    drift: float = 0,
    uncertainty_ns: int = 2 * MS,
    without: range = range(0),
    several: int = 1,
) -> Path:
    """Take the same traffic with another tap: its clock is off and drifts, and it delivers `several` at once."""
    file = true.with_name("other.pcapng")
    with closing(Output(str(file), force=True)) as output:
        writer = PcapngWriter(output, {0: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "other")}, Counters())
        writer.begin()
        assembler = Assembler()
        number, begin_ns, last_ns = 0, 0, 0
        waiting = b""
        for record in records(true):
            if record.type == Type.EVENT:
                continue
            begin_ns = begin_ns or record.time_ns
            if not assembler.lines:
                assembler.add_line(0, record.settings, record.time_ns)
            time_ns = record.time_ns
            for place, value in enumerate(record.data):
                time_ns += record.intervals[place] if place else 0
                number += 1
                waiting += bytes([value])
                if number in without or (len(waiting) < several and place + 1 < len(record.data)):
                    waiting = waiting[:-1] if number in without else waiting
                    continue
                at = time_ns + offset_ns + int((time_ns - begin_ns) * drift) + delay(number)
                last_ns = max(last_ns, at)
                assembler.take(Read(0, last_ns, waiting, bytes(len(waiting)), uncertainty_ns), last_ns, "")
                waiting = b""
        assembler.flush([0], last_ns)
        for record in assembler.due(last_ns):
            writer.write(record)
        writer.end(last_ns)
    return file


def late_ms(true: Path, other: Path) -> list[float]:
    pairs = aligned(frames(true), frames(other))
    return sorted(one.late_ns / MS for one in measured(pairs).characters)


def test_a_capture_beside_itself_is_in_time(true: Path) -> None:
    pairs = aligned(frames(true), frames(true))
    assert all(one.number == another.number for one, another in pairs)
    assert {one.late_ns for one in measured(pairs).characters} == {0}


@pytest.mark.parametrize("offset_ns", [0, 3 * MS, -40 * HOUR, 40 * HOUR])
@pytest.mark.parametrize("drift", [0, 80e-6, -80e-6])
def test_offset_and_drift_are_found_and_taken_out(true: Path, offset_ns: int, drift: float) -> None:
    chance = random.Random(1)
    other = taken(true, lambda number: chance.randrange(MS), offset_ns=offset_ns, drift=drift)
    pairs = aligned(frames(true), frames(other))
    found = measured(pairs)
    assert len(pairs) == len(frames(true))
    assert abs(found.offset_ns - offset_ns) < 0.1 * MS
    assert abs(found.drift_ppm - drift * 1e6) < 60  # in a capture of 1.4 s
    late = sorted(one.late_ns for one in found.characters)
    assert late[0] >= -1
    assert abs(quantile(late, 0.5) - 0.5 * MS) < 0.15 * MS
    assert 0.85 * MS < quantile(late, 0.99) < 1.1 * MS
    assert not any(one.is_outside for one in found.characters)


def test_characters_outside_the_uncertainty_are_counted(true: Path) -> None:
    other = taken(true, lambda number: 3 * MS if number in (100, 200, 300) else 0)
    found = measured(aligned(frames(true), frames(other)))
    assert sum(one.is_outside for one in found.characters) >= 3
    worst = max(found.characters, key=lambda one: one.late_ns)
    assert abs(worst.late_ns - 3 * MS) < 0.1 * MS


def test_of_several_in_a_read_only_the_last_is_late(true: Path) -> None:
    found = measured(aligned(frames(true), frames(taken(true, several=4, uncertainty_ns=13 * MS)))).characters
    assert max(one.late_ns for one in found) > 3 * MS  # the first waited for the others
    assert sum(one.is_outside for one in found) == 0


def test_what_one_of_them_has_not_is_left_out(true: Path) -> None:
    other = taken(true, without=range(20, 200))
    pairs = aligned(frames(true), frames(other))
    assert 0 < len(pairs) < len(frames(true))
    assert all(one.data == another.data for one, another in pairs)
    assert max(one.late_ns for one in measured(pairs).characters) < 0.1 * MS


def test_a_stall_is_late_and_no_other_telegram(true: Path) -> None:
    """The master repeats the same commands every 25 ms or so; for 150 ms the adapter delivers nothing."""
    stall = range(200, 300)
    times = {}
    number = 0
    for frame in frames(true):
        for time_ns in frame.times_ns:
            number += 1
            times[number] = time_ns
    until_ns = times[stall.start] + 150 * MS
    other = taken(true, lambda number: max(0, until_ns - times[number]) if number >= stall.start else 0)
    pairs = aligned(frames(true), frames(other))
    assert [one.data for one, _ in pairs] == [one.data for one in frames(true)]
    assert [one.number for one, _ in pairs] == [one.number for one in frames(true)]
    assert abs(max(one.late_ns for one in measured(pairs).characters) - 150 * MS) < 2 * MS


def test_a_whole_cycle_that_is_missing_shifts_nothing(true: Path) -> None:
    """Times are right again afterwards; the same telegrams come before and after."""
    all_ = frames(true)
    for missing in (range(10, 14), range(21, 25), range(30, 31)):
        other = [frame for place, frame in enumerate(all_) if place not in missing]
        pairs = aligned(all_, other)
        assert [one.number for one, _ in pairs] == [frame.number for frame in other]


def test_long_gaps_and_strange_traffic_take_no_time(true: Path) -> None:
    """Thousands of telegrams that only one capture has: aligning continues after them."""
    chance = random.Random(1)
    one = frames(true)
    step_ns = one[-1].time_ns - one[0].time_ns + 50 * MS
    long = [
        frame._replace(
            number=frame.number + again * len(one),
            data=frame.data if again in (0, 99) else bytes([chance.randrange(3)]),
            times_ns=[time_ns + again * step_ns for time_ns in frame.times_ns],
            latest_ns=[time_ns + again * step_ns for time_ns in frame.latest_ns],
        )
        for again in range(100)
        for frame in one
    ]
    ends = long[: len(one)] + long[-len(one) :]
    for pairs in (aligned(ends, long), aligned(long, ends)):
        assert [(first.number, second.number) for first, second in pairs] == [(end.number, end.number) for end in ends]


def test_the_report(true: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # Nothing is known of its times, but that they are worse than the limit.
    other = taken(true, uncertainty_ns=6 * MS)
    assert cli.main(["selftest", "--beside", str(true), str(other)]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^  p99.9 +0.0000 ms$", out, re.MULTILINE)
    assert "outside the uncertainty that the capture says: 0 of" in out
    assert re.search(r"^  TzA  exceeded    unresolved +[1-9]\d*  open$", out, re.MULTILINE)
    assert "DIFFERENT" not in out


def test_a_verdict_that_is_wrong_is_marked(true: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # It says that its times are exact, and they are not.
    other = taken(true, lambda number: 20 * MS if number % 50 == 0 else 0, uncertainty_ns=0)
    assert cli.main(["selftest", "--beside", str(true), str(other)]) == 0
    assert re.search(r"^  TzA  ok +exceeded +[1-9]\d*  DIFFERENT$", capsys.readouterr().out, re.MULTILINE)


def test_the_picture(true: Path, tmp_path: Path) -> None:
    file = tmp_path / "late.svg"
    other = taken(true, lambda number: 20 * MS if number % 50 == 0 else 0, uncertainty_ns=0)
    assert cli.main(["selftest", "--beside", str(true), str(other), "--plot", str(file)]) == 0
    drawn = file.read_text()
    late = sum(one.is_outside for one in Comparison(true, other).lateness.characters)
    assert late > 0
    assert f">outside: {late}<" in drawn
    assert len(drawn) < 100_000


@pytest.mark.parametrize(
    ("count", "most"), [(200_000, 1_200_000), pytest.param(1_000_000, 2_000_000, marks=pytest.mark.thorough)]
)
def test_a_picture_of_a_whole_day_is_small(count: int, most: int) -> None:
    """A million characters in a day. With a dot for each, the first would be of 2.5 MB."""
    chance = random.Random(1)
    characters = [Late(number * MS, 0, chance.expovariate(1 / MS), 8 * MS) for number in range(count)]
    assert len(svg(drawing(Lateness(characters, 0, 0)), "x")) < most


def test_what_cannot_be_compared_is_one_line(true: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    text = tmp_path / "log.txt"
    text.write_text("nothing" * 10)
    strange = tmp_path / "strange.pcapng"
    assert cli.main(["bus", "routing", "-w", str(strange)]) == 0
    capfd.readouterr()
    refused: list[tuple[list[str | Path], str]] = [
        ([true, text], "not a pcapng file"),
        ([true, tmp_path / "missing"], "cannot read"),
        ([true, tmp_path], "cannot read"),
        ([true, strange], "no telegram in common"),
        ([true, true, "--plot", "late.pdf"], "end it in .svg"),
        ([true, true, "-i", "/dev/null"], "leave out -i"),
    ]
    for arguments, words in refused:
        assert cli.main(["selftest", "--beside", *map(str, arguments)]) == 2
        said = capfd.readouterr().err
        assert words in said
        assert said.count("\n") == 1
    assert cli.main(["selftest", "--plot", "late.svg"]) == 2
