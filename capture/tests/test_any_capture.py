# SPDX-License-Identifier: GPL-2.0-or-later
"""Every command that reads captures, with any capture: it ends with a result, or with a line that says what is wrong.

A capture is chance: telegrams that a drive or a fool might send, damaged or not, several in a packet, with any times,
flags and events.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path

import pytest
from commands import run
from hypothesis import given, settings
from hypothesis import strategies as st
from portable import WRITES_TABLES
from report_capture import ACCEPT, SET_TRS, SET_TZA

from sistap.commands.recorder.reasons import judges
from sistap.commands.recorder.values import Value, ValueLines, line
from sistap.dissected.accesses.access import Access
from sistap.dissected.episodes.live import LIVE
from sistap.dissected.explain.relay import Entry, JudgedEntry
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings
from sistap.tap.records.record import INTERVAL_MAX, Event, Framing, Record, Type, event
from sistap.tap.sis.telegram import build
from sistap.tap.terminal.exits import DONE, FAILED, USAGE

START_NS = 1_700_000_000_000_000_000
EVERY_FLAG = 0x7F
PATIENCE_S = 1800  # for the many examples of `check` on a busy machine
QUICK = 12  # examples of `test`: each starts tshark, several times
FEWER = settings() if settings().max_examples > 100 else settings(max_examples=QUICK)
MS = 1_000_000
DAY_NS = 86_400_000 * MS

bytes_of = st.binary(max_size=24)
masters, stations = st.sampled_from([16, 17, 0, 255]), st.sampled_from([3, 4, 0, 255])
services = st.sampled_from([0x10, 0x12, 0x14, 0x1D, 0x1F, 0x03, 0x04, 0x80, 0x8E, 0x00, 0xFF])
# What chapter 6 reads and writes of parameters, with the elements: names, attributes, units, limits, operating data.
controls = st.sampled_from([0x3C, 0x14, 0x1C, 0x24, 0x2C, 0x34, 0x38, 0x04, 0x0C])
idents = st.sampled_from([b"\x28\0", b"\x2c\0", b"\x01\x80", b"\x86\x01", b"\x86\0", b"\x33\0"])
elements = st.one_of(
    st.sampled_from([b"\1\0\x42\0", b"\0\0\x11\0", b"\0\0\x54\0", b"\0\0\x72\2", b"a\\b", b"\xa0", b"nan", b"\5\0"]),
    bytes_of,
)


@st.composite
def telegrams(draw: st.DrawFn) -> bytes:
    """Commands and reactions; some are damaged, or are nothing."""
    kind = draw(st.sampled_from(["command", "reaction", "any", "noise"]))
    if kind == "noise":
        return draw(bytes_of)
    is_reaction = kind == "reaction"
    body = draw(bytes_of)
    if kind != "any":
        about = bytes([draw(controls), draw(st.sampled_from([3, 4, 0]))])
        status = bytes([draw(st.sampled_from([0, 0, 0, 1, 0xF0]))])
        body = status + about + draw(elements) if is_reaction else about + b"\0" + draw(idents) + draw(elements)
    data = build(draw(services), draw(masters), draw(stations), body[:245], reaction=is_reaction)
    return data if draw(st.integers(0, 9)) else data[:-1] + bytes([data[-1] ^ 1])


intervals = st.one_of(st.integers(0, 20 * MS), st.sampled_from([0, INTERVAL_MAX]), st.integers(0, INTERVAL_MAX))


@st.composite
def timed(draw: st.DrawFn, size: int) -> tuple[list[int], bytes]:
    """Intervals and flags of characters: all in one read, one by one, or anything."""
    how = draw(st.sampled_from(["one read", "one by one", "any"]))
    if how == "one read":
        return [0] * size, bytes([Flag.SAME_READ] * size)
    if how == "one by one":
        return [draw(intervals), *[MS] * (size - 1)][:size], bytes([draw(st.sampled_from([0, 0x20]))] + [0] * size)[
            :size
        ]
    flags = st.lists(st.one_of(st.just(0), st.integers(0, EVERY_FLAG)), min_size=size, max_size=size)
    return draw(st.lists(intervals, min_size=size, max_size=size)), bytes(draw(flags))


told = st.sampled_from(
    ["TrS = 40 ms", "TzA = 1 ms, TrS = 1 ms", "TzA = 0 ms", "x; kept: a fault at 2026", "x; system time jumped by -3 s"]
)
texts = st.one_of(told, st.text(max_size=20))
settings_of = st.builds(
    LineSettings, st.sampled_from([0, 1, 9600, 0xFFFFFFFF]), st.just(8), st.sampled_from("NE"), st.just(2)
)
uncertainties = st.sampled_from([0, 310_000, 16 * MS, 500 * MS, UNCERTAINTY_UNKNOWN])


@st.composite
def records(draw: st.DrawFn) -> Record:
    """A record; its time is since the one before it."""
    later_ns = draw(
        st.one_of(st.integers(0, 50 * MS), st.sampled_from([0, 400 * MS, 90_000_000 * MS, -MS, -5000 * MS]))
    )
    line, line_settings = draw(st.sampled_from([0, 0, 0, 1, 2])), draw(settings_of)
    if draw(st.integers(0, 7)) == 0:
        return event(later_ns, line, line_settings, Event(draw(st.integers(0, 9))), draw(texts))
    data = b"".join(draw(st.lists(telegrams(), min_size=1, max_size=3))) if draw(st.booleans()) else draw(telegrams())
    gaps, flags = draw(timed(len(data)))
    kind = draw(st.sampled_from([Type.FRAME, Type.FRAME, Type.FRAME, Type.OTHER]))
    framing = draw(st.sampled_from([Framing.SIS] * 5 + [Framing.ASCII, Framing.PROCEDURE_3964R, Framing.SILENCE]))
    return Record(later_ns, kind, line, line_settings, data, gaps, flags, draw(uncertainties), framing)


Made = tuple[Record, str, int]
dissectors = st.sampled_from(["sertap", "sertap", "sertap", "sis"])
packets = st.tuples(records(), dissectors, st.integers(0, 1))


@st.composite
def exchanges(draw: st.DrawFn) -> list[Made]:
    """A command that is answered, as most are: of one service, in one way of reading, perhaps in one packet."""
    service = draw(st.one_of(services, st.sampled_from([0x10, 0x1F])))  # most ask for a value, or write one
    master, station = draw(masters), draw(stations)
    about = bytes([draw(st.one_of(st.just(0x3C), controls)), 3])
    data = [
        build(service, master, station, about + b"\0" + draw(idents)),
        build(service, master, station, b"\0" + about + draw(elements), reaction=True),
    ]
    if draw(st.integers(0, 4)) == 0:
        data = [b"".join(data)]
    how = draw(st.booleans()), draw(uncertainties)
    dissector = draw(dissectors)
    return [(_frame(one, 0 if how[0] and place else 20 * MS, *how), dissector, 0) for place, one in enumerate(data)]


def _frame(data: bytes, later_ns: int, is_one_read: bool, uncertainty_ns: int = 310_000) -> Record:
    intervals = [0] * len(data) if is_one_read else [20 * MS, *[MS] * (len(data) - 1)]
    flags = bytes([Flag.SAME_READ * is_one_read] * len(data))
    return Record(later_ns, Type.FRAME, 0, LineSettings(), data, intervals, flags, uncertainty_ns)


@st.composite
def beginnings(draw: st.DrawFn) -> list[Made]:
    """Limits that the bus sets (chapter 7), or a person tells, or none."""
    limits = [SET_TZA, SET_TRS, ACCEPT] if draw(st.booleans()) else []
    told_here = [event(0, 0, LineSettings(), Event.LIMITS_TOLD, draw(told))] if draw(st.booleans()) else []
    set_here = [_frame(one, 20 * MS, is_one_read=False) for one in limits]
    return [(record, "sertap", 0) for record in (*told_here, *set_here)]


scenes = st.one_of(exchanges(), packets.map(lambda packet: [packet]))
captures = st.tuples(beginnings(), st.lists(scenes, max_size=30).map(lambda many: list(chain(*many)))).map(
    lambda both: [*both[0], *both[1]]
)


def written(path: Path, made: Sequence[Made]) -> Path:
    """Write a capture with records, and telegrams that no tap has timed."""
    blocks = [pcapng.section_header("", "")]
    blocks += [pcapng.interface_description(pcapng.Interface(252, name)) for name in ("a", "b\\c")]
    time_ns = START_NS
    for record, dissector, number in made:
        time_ns += record.time_ns
        data = record.pack() if dissector == "sertap" else record.data
        blocks.append(pcapng.enhanced_packet(number, time_ns, pcapng.upper_pdu(dissector, data)))
    path.write_bytes(b"".join(blocks))
    return path


COMMANDS = [
    "report A --format text -o -",
    "report A B --format html -o -",
    "report A --format json -o -",
    "report A --format text -o - --tza 2 --trs 5",
    "compare A B",
    "compare B A --format html -o -",
    "compare A B --format json -o -",
    *(["tables A B -o tables"] if WRITES_TABLES else []),
    "parameters A B",
    "parameters A --csv",
    "parameters A B --changes",
    "parameters A --csv --wide",
    "log A",
]


class Told(ValueLines):
    """Puts each value into a line."""

    def put(self, time_ns: int, accesses: Iterable[Access]) -> None:
        """Check that each is one line."""
        for value in (Value(time_ns, access) for access in accesses if access.plain is not None):
            assert line(value).startswith("sis,") and "\n" not in line(value)


ANY = pytest.mark.attack(
    "any capture: chance telegrams, several in a packet, times, flags, events",
    "each command has a result, or a line that says what is wrong",
)


@ANY
@pytest.mark.timeout(PATIENCE_S)
@FEWER
@given(command=st.sampled_from(COMMANDS), first=captures, second=captures)
def test_a_command_with_any_capture(command: str, first: Sequence[Made], second: Sequence[Made]) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        written(folder / "A", first)
        written(folder / "B", second)
        done = run(folder, *command.split())
    assert done.returncode == DONE or done.stderr.count("sistap: ") == 1, done.stderr
    assert done.returncode in (DONE, FAILED, USAGE), done.stderr
    if done.returncode == DONE and "json" in command:
        json.loads(done.stdout, parse_constant=pytest.fail)


@ANY
@pytest.mark.timeout(PATIENCE_S)
@FEWER
@given(made=captures)
def test_a_recorder_with_any_capture(made: Sequence[Made], tshark: Tshark) -> None:
    """What decides what is kept, and passes values on."""
    (judge,) = judges(tshark, ["faults"], LIVE, Told())
    with tempfile.TemporaryDirectory() as name:
        path = written(Path(name, "A"), made)
        for line in tshark.lines(["-r", str(path), *judge.arguments(None)]):
            judge.reason(JudgedEntry(Entry(START_NS, b""), judge.columns(line)))
        judge.silent(START_NS + 10**12)
