# SPDX-License-Identifier: GPL-2.0-or-later
"""Whatever the clock of the tap, a verdict says just what its record proves, and never what is not true."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest

from adapter import EXCEEDED, OK, TOLERANCE, UNRESOLVED, Adapter, admissible, records, seen, windows
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings
from sistap.tap.records.record import Record
from sistap.tap.sis.telegram import build
from tables import shown

MS = 1_000_000
TZA_MS, TRS_MS = 5, 40
EXCHANGES = 300
START_NS = 1_700_000_000_000_000_000

SLOW, FAST = LineSettings(9600), LineSettings(115200)

# The clock, the line, and which verdicts it must at least come to.
CLOCKS = {
    "exact": (Adapter(), SLOW, {OK, EXCEEDED, UNRESOLVED}),
    "10 us": (Adapter(delay_ns=10_000), SLOW, {OK, EXCEEDED, UNRESOLVED}),
    "1 ms": (Adapter(MS, 100_000), SLOW, {OK, EXCEEDED, UNRESOLVED}),
    "1 ms, 115200 Bd": (Adapter(MS, 100_000), FAST, {OK, EXCEEDED, UNRESOLVED}),
    "16 ms": (Adapter(16 * MS, 300_000), SLOW, {OK, EXCEEDED, UNRESOLVED}),
    "16 ms, 115200 Bd": (Adapter(16 * MS, 300_000), FAST, {EXCEEDED, UNRESOLVED}),
    "stalls": (Adapter(MS, 100_000, stall_ns=80 * MS), SLOW, {OK, EXCEEDED, UNRESOLVED}),
    "unknown": (Adapter(MS, says=False), SLOW, {UNRESOLVED}),
}
# A clock with which all three verdicts are found. The thorough tests try the rest.
FIRST = "1 ms"
REST = [name for name in CLOCKS if name != FIRST]


class Sent(NamedTuple):
    """A telegram and when its characters truly arrived, in ns."""

    telegram: bytes
    arrivals: list[int]


def near(limit_ns: int, uncertainty_ns: int, random: Random) -> int:
    """Return a time that a judge of this limit finds hard, or any."""
    if random.random() < 0.5:
        return int(limit_ns * random.choice((0.5, 1, 2, 8)) * random.random())
    return limit_ns + random.choice((0, 0, 1, -1)) * uncertainty_ns + random.choice((0, 1, -1, -MS // 10, MS // 10))


def exchange(random: Random) -> tuple[bytes, bytes]:
    """Make a command and its reaction of any length: something written, or something read."""
    station, device = random.randint(3, 9), random.randint(1, 9)
    written, read = random.choice(((random.randint(0, 20), 0), (0, random.randint(1, 60))))
    service = 0x10 if read else 0x1F
    command = bytes([0x3C, device, 0, 36, 0]) + random.randbytes(written)
    reaction = bytes([0, 0x3C, device]) + random.randbytes(read)
    return build(service, 16, station, command), build(service, 16, station, reaction, reaction=True)


def bus(adapter: Adapter, settings: LineSettings, random: Random) -> list[Sent]:
    """Send commands and reactions, with pauses of any length at any place."""
    uncertainty_ns = adapter.timer_ns + adapter.delay_ns
    now, sent = START_NS, []
    for _ in range(EXCHANGES):
        silences_ns = random.randint(20, 60) * MS, near(TRS_MS * MS, uncertainty_ns, random)
        for telegram, silence_ns in zip(exchange(random), silences_ns, strict=True):
            # A sender may be a little fast or slow.
            character_ns = int(settings.character_ns * random.uniform(1 - TOLERANCE, 1 + TOLERANCE))
            intervals = [silence_ns] + [character_ns] * (len(telegram) - 1)
            for _ in range(random.choice((0, 0, 1, 2))):
                intervals[random.randrange(1, len(telegram))] = near(TZA_MS * MS, uncertainty_ns, random)
            longer = [max(interval, character_ns) for interval in intervals]
            sent.append(Sent(telegram, list(itertools.accumulate(longer, initial=now))[1:]))
            now = sent[-1].arrivals[-1]
    return sent


def capture_of(made: Sequence[Record], path: Path) -> None:
    """Write the records into a capture."""
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "adapter")
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(interface)]
    blocks += [pcapng.enhanced_packet(0, one.time_ns, pcapng.upper_pdu("sertap", one.pack())) for one in made]
    path.write_bytes(b"".join(blocks))


def longest(arrivals: Sequence[int]) -> int:
    """Return the longest interval."""
    return max(later - earlier for earlier, later in itertools.pairwise(arrivals))


def verdict_of(arrivals: Sequence[int], limit_ms: int, character_ns: int) -> int:
    """Judge by the true times: without the character that ends an interval, and with it."""
    longest_ns, limit_ns = longest(arrivals), limit_ms * MS
    return EXCEEDED if longest_ns - character_ns > limit_ns else OK if longest_ns <= limit_ns else UNRESOLVED


def believable(record: Record, one: Sent) -> None:
    """Check the model itself: its records say nothing wrong about when the characters arrived."""
    if record.uncertainty_ns != UNCERTAINTY_UNKNOWN:
        spacing_ns = int(record.settings.character_ns * (1 - TOLERANCE))
        for window, arrived_ns in zip(windows(record, spacing_ns), one.arrivals, strict=True):
            assert window.earliest <= arrived_ns <= window.latest


def judged(made: Sequence[Record], sent: Sequence[Sent]) -> list[dict[str, tuple[set[int], int]]]:
    """Return the right verdicts of each telegram and the true one, by limit; every second is a reaction."""
    right = []
    for number, (record, one) in enumerate(zip(made, sent, strict=True)):
        believable(record, one)
        character_ns = record.settings.character_ns
        verdicts = {"tza": (admissible(record, TZA_MS * MS), verdict_of(one.arrivals, TZA_MS, character_ns))}
        if number % 2:
            between = [sent[number - 1].arrivals[-1], one.arrivals[0]]
            true = verdict_of(between, TRS_MS, character_ns)
            verdicts["trs"] = admissible(record, TRS_MS * MS, made[number - 1]), true
        right.append(verdicts)
    return right


def dissected(tshark: Tshark, capture: Path) -> list[dict[str, str]]:
    """Return what tshark shows of each telegram, the same in one pass and in two."""
    options = ("-o", f"sis.tza_ms:{TZA_MS}", "-o", f"sis.trs_ms:{TRS_MS}")
    fields = "tza.verdict trs.verdict tza.interval_max tza.position"
    once, twice = (shown(tshark, capture, fields, *passes, *options) for passes in ((), ("-2",)))
    assert once == twice
    return list(once.values())


@pytest.mark.parametrize("name", [FIRST, *(pytest.param(name, marks=pytest.mark.thorough) for name in REST)])
def test_no_verdict_is_wrong(name: str, tshark: Tshark, tmp_path: Path) -> None:
    adapter, settings, needed = CLOCKS[name]
    random = Random(name)
    sent = bus(adapter, settings, random)
    characters = seen([time_ns for one in sent for time_ns in one.arrivals], adapter, random)
    made = records([one.telegram for one in sent], characters, settings)
    capture_of(made, tmp_path / "clock.pcapng")
    failures, found = [], set()
    frames = zip(dissected(tshark, tmp_path / "clock.pcapng"), judged(made, sent), strict=True)
    for number, (cells, limits) in enumerate(frames, 1):
        verdicts = {name.removesuffix(".verdict"): int(cell) for name, cell in cells.items() if "verdict" in name}
        assert verdicts.keys() == limits.keys()
        for limit, verdict in verdicts.items():
            right, true = limits[limit]
            if verdict not in right & {true, UNRESOLVED}:
                failures.append(f"frame {number}: {limit} {verdict}, right are {right}, true is {true}")
        found |= set(verdicts.values())
    assert not failures, "\n".join(failures)
    assert found >= needed


@pytest.mark.thorough
def test_the_longest_interval_and_its_place(tshark: Tshark, tmp_path: Path) -> None:
    """With an exact clock they are the true ones; of equal intervals the first."""
    random = Random(1)
    sent = bus(Adapter(), SLOW, random)
    characters = seen([time_ns for one in sent for time_ns in one.arrivals], Adapter(), random)
    capture_of(records([one.telegram for one in sent], characters, SLOW), tmp_path / "clock.pcapng")
    for cells, one in zip(dissected(tshark, tmp_path / "clock.pcapng"), sent, strict=True):
        intervals = [later - earlier for earlier, later in itertools.pairwise(one.arrivals)]
        assert cells["tza.interval_max"] == f"{max(intervals) / 1e9:.9f}"
        assert cells["tza.position"] == str(intervals.index(max(intervals)) + 2)
