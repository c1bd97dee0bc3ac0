# SPDX-License-Identifier: GPL-2.0-or-later
"""Episodes while they happen: a recorder keeps what is told, when it is told."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import planted
import pytest
from machines import BEGIN_S, judged
from machines import access as measured

from sistap.commands.recorder import recorder as recorder_module
from sistap.commands.recorder.keeper import Around
from sistap.commands.recorder.reasons import judges
from sistap.commands.recorder.recorder import Recorder, Wanted
from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.captures import reading
from sistap.dissected.episodes.episode import Hit, severity_of
from sistap.dissected.episodes.live import FIELD, LIVE, LiveEpisodes
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.packets.dissection import EXCEEDED, UNRESOLVED, Packet, Telegram
from sistap.dissected.wireshark.rows import EVENT, FRAME, OTHER
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files.pcapng import Interface
from sistap.tap.records.record import Event, Type

SECOND = 1_000_000_000
HOUR_S, DAY_S = 3600.0, 86_400.0
LEARNED_S = LIVE.learning_s + HOUR_S


class Bus:
    """A master and stations; what is told of them."""

    def __init__(self) -> None:
        self.live = LiveEpisodes()
        self.told: list[Hit] = []
        self.now_s = BEGIN_S
        self.heard_s: dict[str, float] = {}
        self.port = ""

    def packet(
        self, *telegrams: Telegram, accesses: Sequence[Access] = (), kind: int = FRAME, text: str = "", **more: int
    ) -> None:
        said = (self.port, kind, None, 9600, "8E1", None, more.get("event"), text, 0, 0, ())
        packet = Packet(*said, number=1, epoch_s=self.now_s, time_s=self.now_s, uncertainty_s=None, intervals_s=[])
        packet.telegrams, packet.accesses = [*telegrams], [*accesses]
        packet.since_s, self.heard_s[self.port] = self.now_s - self.heard_s.get(self.port, BEGIN_S), self.now_s
        self.told += self.live.add(packet)

    def ask(self, station: int = 3, *, master: int = 16, after_unanswered: bool = False) -> None:
        self.packet(telegram(master, station, {FIELD: "1"} if after_unanswered else {}))

    def answer(self, station: int = 3, *accesses: Access) -> None:
        self.packet(telegram(16, station, {}, is_reaction=True), accesses=accesses)

    def exchange(self, *accesses: Access, master: int = 16) -> None:
        self.ask(master=master)
        self.answer(3, *accesses)

    @property
    def kinds(self) -> list[str]:
        return [hit.kind for hit in self.told]


def telegram(master: int, station: int, columns: dict[str, str], *, is_reaction: bool = False) -> Telegram:
    talker, listener = (station, master) if is_reaction else (master, station)
    known = (True, 0x10, talker, listener, is_reaction, None, False, False, False, False, "", False)
    return Telegram(*known, None, None, None, None, None, None, None, columns)


def access(ident: str, value: str, number: float | None = None, *, master: int | None = None) -> Access:
    """Return a read; a write if a master is named."""
    parameter = Parameter("", "3", 7, ident)
    data = value.encode().hex()  # whatever it is: another for another value
    return Access(parameter, master is not None, master or 16, "", value, number, data, "", "", "", "")


def speed(rpm: float) -> Access:
    return access("S-0-0040", f"{rpm} rpm", rpm)


@pytest.fixture
def bus() -> Bus:
    """A bus of which everything usual is known."""
    bus = Bus()
    for _ in range(int(LEARNED_S / 10)):
        bus.now_s += 10
        bus.exchange(access("S-0-0390", "0xA0101"), speed(1000 + random.Random(bus.now_s).gauss(0, 1)))
    assert bus.told == []
    return bus


def test_a_silent_station_is_told_from_the_first_command_on(bus: Bus) -> None:
    bus.ask()
    began_s = bus.now_s
    for _ in range(4):
        bus.now_s += 1
        bus.ask(after_unanswered=True)
    assert bus.kinds == ["unanswered", "unanswered", "silent", "silent"]
    assert {hit.from_s for hit in bus.told} == {began_s}
    bus.answer()
    assert bus.kinds[-1] == "silent" and len(bus.told) == 5
    bus.exchange()
    assert len(bus.told) == 5


def test_of_two_masters_each_knows_whom_it_asked(bus: Bus) -> None:
    bus.ask(3, master=16)
    bus.ask(4, master=17)
    bus.packet(telegram(17, 4, {}, is_reaction=True))
    bus.now_s += 1
    bus.ask(3, master=16, after_unanswered=True)
    assert [hit.station for hit in bus.told if hit.kind == "unanswered"] == [3]


def test_the_station_that_was_asked_first_is_silent(bus: Bus) -> None:
    bus.ask(3)
    bus.now_s += 1
    bus.ask(4, after_unanswered=True)
    assert [hit.station for hit in bus.told] == [3]


def test_an_event_of_the_tap_is_no_reaction(bus: Bus) -> None:
    """A marker, say."""
    bus.ask()
    bus.packet(kind=EVENT)
    bus.now_s += 1
    bus.ask(after_unanswered=True)
    assert bus.kinds == ["unanswered"]


def test_what_may_have_been_the_reaction_is_no_silence(bus: Bus) -> None:
    bus.ask()
    bus.packet(kind=OTHER)
    told = len(bus.told)  # it is damaged
    bus.ask(after_unanswered=True)
    bus.answer()
    assert len(bus.told) == told


def test_a_station_that_never_answered_is_perhaps_not_there(bus: Bus) -> None:
    bus.ask(9)
    for _ in range(10):
        bus.now_s += 1
        bus.ask(9, after_unanswered=True)
    assert bus.told == []


@pytest.mark.parametrize("is_heard", [True, False])
def test_after_a_command_that_perhaps_nobody_took_nothing_is_apart_from_the_last_one(*, is_heard: bool) -> None:
    bus = Bus()
    bus.exchange(measured(3, "S-0-0036", 1000.0, is_write=True))
    for rpm in [1000.0] * 60 + [500.0] * 30:
        if rpm < 1000 and not is_heard:
            bus.packet(telegram(16, 3, {"sis.parameter": "S-0-0036", "sis.service": "0x1f"}))
            bus.ask(after_unanswered=True)
            bus.answer()
        bus.now_s += 1
        bus.exchange(measured(3, "S-0-0040", rpm))
    assert ("apart" in bus.kinds) is is_heard


@pytest.mark.parametrize("is_heard", [True, False])
def test_what_perhaps_a_drive_took_somebody_wrote(bus: Bus, *, is_heard: bool) -> None:
    bus.exchange(access("P-0-0123", "1", master=16))
    bus.exchange(access("P-0-0123", "1"))
    if not is_heard:
        bus.packet(telegram(16, 3, {"sis.parameter": "P-0-0123", "sis.service": "0x1f"}))
        bus.now_s += 1
        bus.ask(after_unanswered=True)
        bus.answer()
    bus.exchange(access("P-0-0123", "2"))
    assert ("other" in bus.kinds) == is_heard


def test_a_new_master_is_told_when_it_comes_and_when_it_comes_back(bus: Bus) -> None:
    for pause in (0, 1, 1, 50, 70, 1):
        for _ in range(pause):
            bus.now_s += 10
            bus.exchange()
        bus.exchange(master=17)
    assert bus.kinds == ["master", "master"]


def test_a_token_that_a_new_master_sends_to_another_one_is_no_visit(bus: Bus) -> None:
    bus.ask(16, master=17)
    assert bus.told == []


def test_a_write_of_a_new_master_is_told_each_time(bus: Bus) -> None:
    bus.exchange(access("S-0-0091", "1", master=16))
    bus.exchange(master=17)
    for value in ("5", "6"):
        bus.exchange(access("S-0-0091", value, master=17))
    assert bus.kinds == ["limit_write", "master", "write", "write"]


def test_what_a_usual_master_writes_is_told_when_it_is_new_or_a_limit_changes(bus: Bus) -> None:
    for ident, value in (("S-0-0091", "1"), ("S-0-0091", "1"), ("S-0-0036", "1"), ("S-0-0036", "2"), ("S-0-0091", "2")):
        bus.exchange(access(ident, value, master=16))
    assert [(hit.kind, hit.parameter) for hit in bus.told] == [
        *(("limit_write", "S-0-0091"), ("write", "S-0-0036"), ("limit_write", "S-0-0091"))
    ]


def test_what_was_never_written_is_told_once_after_a_while() -> None:
    """But a limit that had another value is told at once."""
    bus = Bus()
    for ident in ("S-0-0036", "S-0-0091", "S-0-0036", "S-0-0091", "S-0-0001"):
        bus.exchange(access(ident, str(bus.now_s), master=16))
        bus.now_s += LIVE.learning_s / 3
    assert [(hit.kind, hit.parameter) for hit in bus.told] == [("limit_write", "S-0-0091"), ("write", "S-0-0001")]


def test_a_diagnosis_is_told_at_once_and_when_it_ends(bus: Bus) -> None:
    for value in ("0xF2028", "0xF2028", "0xA0101", "0xA0101"):
        bus.now_s += 10
        bus.exchange(access("S-0-0390", value))
    begun, ended = bus.told
    assert (begun.kind, begun.from_s, begun.to_s) == ("fault", bus.now_s - 30, bus.now_s - 30)
    assert (ended.from_s, ended.to_s) == (bus.now_s - 30, bus.now_s - 10)
    assert {hit.detail for hit in bus.told} == {"F2028 (S-0-0390, before A0101)"}


@pytest.mark.parametrize(
    ("ident", "value", "severity"),
    [
        ("S-0-0390", "0x000F2028", Severity.ERROR),
        ("S-0-0390", "0xF228", Severity.ERROR),  # ECODRIVE03 has two digits after F2
        ("S-0-0390", "0x000E2050", Severity.WARNING),
        ("S-0-0011", "0x0004", Severity.ERROR),  # each bit is an error
        ("S-0-0012", "0x0004", Severity.WARNING),
        ("S-0-0390", "0x000AF228", None),
        ("P-0-0390", "0xF228", None),  # not a diagnosis
    ],
)
def test_a_fault_of_a_drive_is_an_error(bus: Bus, ident: str, value: str, severity: Severity | None) -> None:
    shown = "0x0000" if ident in ("S-0-0011", "S-0-0012") else "0xA0101"
    for one in (shown, shown, value, shown, shown):
        bus.now_s += 10
        bus.exchange(access(ident, one, float(int(one, 0))))
    found = [severity_of(hit) for hit in bus.told if hit.kind != "changed"]
    assert found == ([severity] * 2 if severity is not None else [])


def test_a_step_is_told_when_it_lasts_and_from_its_beginning(bus: Bus) -> None:
    began_s = bus.now_s + 10
    for value in (700, 701, 699, 700, 702):
        bus.now_s += 10
        bus.exchange(speed(value))
    (hit,) = bus.told
    assert (hit.kind, hit.from_s) == ("step", began_s)


def test_a_step_of_the_first_hour_may_be_usual() -> None:
    bus = Bus()
    for value in [1000] * 100 + [700] * 100:
        bus.now_s += 10
        bus.exchange(speed(value))
    assert bus.told == []


def test_the_faults_of_a_day_are_forgotten(bus: Bus) -> None:
    """Also after many changes: what only moves is no longer told, and is told again when it has come to rest."""
    for number in range(LIVE.lively * 2):
        bus.now_s += 10
        bus.exchange(access("S-0-0390", f"0x{number % 2}"), speed(1000.0 * (number // 5)))
    (engine,) = bus.live._engine._buses.values()
    (values,) = (one for parameter, one in engine.values.followed() if parameter.ident == "S-0-0390")
    assert len(values.states) <= LIVE.lively + 1
    bus.told = []
    for _ in range(int(2 * DAY_S / 60)):
        bus.now_s += 60
        bus.exchange(access("S-0-0390", "0x1"), speed(1000.0))
    bus.told = []
    bus.exchange(access("S-0-0390", "0xF2028"))
    assert bus.kinds == ["fault"] and len(values.states) == 2


def test_a_silence_of_the_bus_is_told_while_it_lasts(bus: Bus) -> None:
    """Once; and again when it ends."""
    ended_s = bus.now_s
    silent = [hit for later_s in range(200) for hit in bus.live.silent(ended_s + later_s)]
    assert [(hit.kind, hit.from_s) for hit in silent] == [("bus_silent", ended_s)]


def test_what_nobody_looked_at_is_neither_silence_nor_jump(bus: Bus) -> None:
    bus.ask()
    bus.live.skip()
    bus.now_s += 1000
    bus.ask(after_unanswered=True)
    bus.answer()
    assert bus.told == []
    bus.ask()
    for _ in range(3):
        bus.now_s += 1
        bus.ask(after_unanswered=True)
    assert bus.kinds[-1] == "silent"  # it is one from here on


@pytest.fixture
def two(bus: Bus) -> Bus:
    """Two buses of which everything usual is known; the same stations and masters are at both."""
    began_s, bus.port = bus.now_s, "b"
    for _ in range(int(LEARNED_S / 10)):
        bus.now_s += 10
        for bus.port in ("", "b"):
            bus.exchange()
    assert bus.now_s > began_s and bus.told == []
    return bus


def test_of_two_buses_each_knows_who_was_asked(two: Bus) -> None:
    two.port = ""
    two.ask()
    two.port = "b"
    two.packet(kind=OTHER)
    two.exchange()
    two.port = ""
    two.now_s += 1
    two.ask(after_unanswered=True)
    assert [(hit.kind, hit.port) for hit in two.told] == [("unanswered", "")]


def test_what_nobody_looked_at_is_no_silence_of_any_bus(two: Bus) -> None:
    two.live.skip()
    two.now_s += 1000
    for two.port in ("", "b"):
        two.exchange()
    assert two.told == []


def test_new_masters_are_told_each_and_at_each_bus(two: Bus) -> None:
    for two.port in ("", "b"):
        for master in (17, 18, 17):
            two.exchange(master=master)
        two.ask(4, master=17)
    assert [(hit.topic, hit.station, hit.port) for hit in two.told] == [
        (master, station, port) for port in ("", "b") for master, station in (("17", 3), ("18", 3), ("17", 4))
    ]


def test_each_bus_that_is_silent_is_told(two: Bus) -> None:
    assert [(hit.kind, hit.port) for hit in two.live.silent(two.now_s + 200)] == [
        ("bus_silent", ""),
        ("bus_silent", "b"),
    ]


def test_what_a_station_does_not_know_is_not_kept(bus: Bus) -> None:
    """A panel may ask for it the whole night."""
    refusal = telegram(16, 3, {}, is_reaction=True)
    refusal.is_refusal = True
    bus.ask()
    bus.packet(refusal, accesses=[access("S-0-0001", "")._replace(error="0x1001")])
    assert bus.told == []


@pytest.mark.parametrize(("verdict", "told"), [(EXCEEDED, ["late"]), (UNRESOLVED, [])])
def test_what_is_perhaps_late_is_not_kept(bus: Bus, verdict: int, told: Sequence[str]) -> None:
    late = telegram(16, 3, {}, is_reaction=True)
    late.is_doubtful, late.reaction = True, judged(0.06, 0.05, verdict)
    bus.ask()
    bus.packet(late)
    assert bus.kinds == told


def test_a_step_of_the_clock_is_told(bus: Bus) -> None:
    """It is a note, but no verdict that is not certain."""
    bus.packet(kind=EVENT, event=Event.MARKER, text="system time jumped by -2.5 s")
    assert bus.kinds == ["clock"]


Keep = Callable[[Path], list[Path]]


@pytest.fixture
def keep(tshark: Tshark, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Keep]:
    """Records a capture as if it came now; returns the kept files."""
    monkeypatch.setattr(recorder_module, "PATIENCE_S", 60)

    def keep(capture: Path) -> list[Path]:
        folder = tmp_path / "kept"
        folder.mkdir()
        wanted = Wanted(folder, judges(tshark, ["faults"], LIVE), Around(10 * SECOND, 10 * SECOND), 100)
        recorder = Recorder(wanted, tshark, {0: Interface(252, "a line")}, lambda said: pytest.fail(said))
        first, *rest = reading.records(capture)
        recorder.begin(first)
        for record in rest:
            recorder.write(record)
        recorder.end(rest[-1].time_ns)
        return sorted(folder.iterdir())

    yield keep


def span_s(file: Path) -> tuple[float, float]:
    """Return when the first and the last record of a kept file came, in s of the night."""
    records = [one for one in reading.records(file) if one.event != Event.CAPTURE_STARTED and one.type != Type.BEFORE]
    times = [record.time_ns for record in records]
    return min(times) / SECOND - planted.BEGIN_S, max(times) / SECOND - planted.BEGIN_S


def test_each_event_of_a_night_is_kept_with_what_is_around_it(tmp_path: Path, keep: Keep) -> None:
    spans = list(map(span_s, keep(planted.play(tmp_path / "night.pcapng"))))
    for event in planted.PLANTED:
        assert any(begin_s < event.second - 5 and event.second + 5 < end_s for begin_s, end_s in spans), event
    assert any(begin_s < 260 and end_s > 320 for begin_s, end_s in spans)  # what came before the silence, too
    assert sum(end_s - begin_s for begin_s, end_s in spans) < 420  # and nothing else of 480 s


def test_nothing_is_kept_of_a_night_without_events(tmp_path: Path, keep: Keep) -> None:
    assert keep(planted.play(tmp_path / "clean.pcapng", is_clean=True)) == []
