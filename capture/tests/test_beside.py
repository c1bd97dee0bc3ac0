# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of an adapter beside an analyser: two captures of the same traffic."""

from __future__ import annotations

import random
import re
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from sistap import cli
from sistap.dissected.captures.reading import records
from sistap.tap.common.quantiles import quantile
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.settings import Read
from sistap.tap.records.assembler import Assembler
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Type

sys.path.append(str(Path(__file__).parent.parent / "benchmark"))
from beside import aligned, frames, lines, measured  # noqa: E402

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


def test_the_report(true: Path, tmp_path: Path) -> None:
    report = "\n".join(lines(true, taken(true)))
    assert re.search(r"^  p99.9 +0.0000 ms$", report, re.MULTILINE)
    assert "outside the uncertainty that the capture says: 0 of" in report
    strange = tmp_path / "strange.pcapng"
    assert cli.main(["bus", "routing", "-w", str(strange)]) == 0
    with pytest.raises(ValueError, match="no telegram in common"):
        list(lines(true, strange))
