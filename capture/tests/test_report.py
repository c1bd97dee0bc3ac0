# SPDX-License-Identifier: GPL-2.0-or-later
"""The figures of a report are those that the capture was made of."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st
from no_tap import NoTap, WithoutTap
from report_capture import (
    ACCEPT,
    ANSWER,
    ANSWER_4,
    BUS,
    DAMAGED,
    LINE,
    READ,
    READ_4,
    SET_TRS,
    SET_TZA,
    STARTED,
    Sent,
    write,
)
from sharkd import Sharkd

from sistap.commands.report import page, plain, tables
from sistap.commands.report.command import stretch
from sistap.commands.report.figures import Figures
from sistap.commands.report.gather import Report, gather
from sistap.commands.report.windows import PACKETS_KEPT, ReportWindow, asked
from sistap.dissected.captures.portions import Portion
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.packets.dissection import FIELDS, UNRESOLVED, Dissection, Packet, packet_of
from sistap.dissected.packets.kept import Span
from sistap.dissected.wireshark.rows import info
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag
from sistap.tap.records.record import Framing, Type
from sistap.tap.sis.faults import FAULTS
from sistap.tap.sis.telegram import build
from sistap.tap.terminal.exits import Refusal

CAPTURES = Path(__file__).parents[2] / "test-captures"
CHARACTER_S = LINE.character_ns / 1e9
FRAMES = [sent for sent in BUS if sent.type == Type.FRAME]


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("report") / "bus.pcapng", BUS)


def made(tshark: Tshark, capture: Path, *windows: str) -> Report:
    return gather(tshark, [Portion(capture)], [asked(*stretch(text)) for text in windows], lambda text: None)


@pytest.fixture(scope="module")
def report(tshark: Tshark, capture: Path) -> Report:
    return made(tshark, capture)


@pytest.fixture(scope="module")
def figures(report: Report) -> dict[str, Any]:
    return cast(dict[str, Any], json.loads(plain.as_json(report)))


def test_what_was_captured(figures: dict[str, Any]) -> None:
    assert figures["packets"] == len(BUS) + 1
    assert figures["records"] == {"telegrams": len(FRAMES), "other_characters": 1, "events": 1}
    assert figures["telegrams"] == {"all": len(FRAMES), "damaged": 1}
    assert figures["ports"] == ["test port"]
    assert figures["lines"] == ["9600 Bd 8E1"]
    assert figures["began_epoch_s"] == 1_700_000_000
    pauses = sum(sum(sent.pauses_ms.values()) / 1e3 - len(sent.pauses_ms) * CHARACTER_S for sent in BUS)
    in_one_read = 2 * CHARACTER_S
    characters = sum(len(sent.data) - 1 for sent in BUS) * CHARACTER_S
    silences = sum(sent.silence_ms for sent in BUS) / 1e3
    assert figures["duration_s"] == pytest.approx(silences + characters + pauses - in_one_read, abs=1e-6)
    assert [(event["packet"], event["code"], event["text"]) for event in figures["events"]] == [(1, 1, STARTED)]


def test_how_exact_the_clock_was(figures: dict[str, Any]) -> None:
    assert figures["clock"] == {
        "uncertainty_least_s": 0.00031,
        "uncertainty_most_s": 0.0005,
        "records_without_uncertainty": 0,
        "intervals_in_one_read": 2,
    }


def test_verdicts(figures: dict[str, Any]) -> None:
    tza, trs = figures["limits"]["tza"], figures["limits"]["trs"]
    assert tza["limits_s"] == [0.005]
    assert (tza["exceeded"], tza["unresolved"]) == (1, 1)
    # None is known before 0xFF; whether it holds for the 0xFF itself is the dissector's affair.
    assert tza["no_limit"] in (2, 3)
    assert tza["ok"] + tza["no_limit"] == len(FRAMES) - 2
    assert trs == {"limits_s": [0.05], "ok": 4, "exceeded": 1, "unresolved": 0, "no_limit": 0}


def test_what_decides_what_is_unresolved_is_said(report: Report) -> None:
    """Drive 4 has 5.2 ms, TzA is 5 ms, and a character takes 1.146 ms: no tap decides that."""
    assert {row[0]: row[-1] for row in tables.pauses(report).rows}["4"] == "1; 1 depends on where TzA begins to count"


def test_which_tza_would_be_kept(figures: dict[str, Any]) -> None:
    """By hand: the master's longest is 7.5 ms, and 0.31 ms uncertain; drive 4 has 5.2 ms, 0.5 ms uncertain, of 5 ms."""
    talkers = {one["station"]: one for one in figures["tza_by_talker"]}
    master, drive = talkers[16], talkers[4]
    assert (master["longest_s"], master["before_character"], master["smallest_safe_ms"]) == (0.0075, 6, 8)
    assert master["part_of_limit"] == pytest.approx(7.81 / 5)
    assert (drive["smallest_safe_ms"], drive["unresolved"]) == (6, 1)
    # If only the pause counts: less 1.146 ms, 6.664 and 4.554 ms. No tap decides what TzA means.
    assert [one["smallest_safe_ms_of_pause_alone"] for one in (master, drive)] == [7, 5]
    assert (drive["depends_on_what_counts"], drive["resolved_if_more_exact_than_s"]) == (1, None)
    places = {one["before_character"]: one for one in figures["tza_by_character"]}
    assert places[6]["longest_s"] == 0.0075 and places[4]["longest_s"] == 0.0052
    for one in (*places.values(), *talkers.values()):
        assert one["histogram"][-1]["from_s"] <= one["longest_s"] <= one["histogram"][-1]["to_s"]
    drawn = sum(bar["count"] for one in places.values() for bar in one["histogram"])
    assert drawn + figures["clock"]["intervals_in_one_read"] == sum(one["count"] for one in places.values())
    assert sum(one["count"] for one in places.values()) == sum(
        len(sent.data) - 1 for sent in FRAMES if sent.data != DAMAGED and not any(f & 8 for f in sent.flags.values())
    )


def test_faults(figures: dict[str, Any]) -> None:
    assert figures["faults"] == {
        "tza_exceeded": 1,
        "trs_exceeded": 1,
        "tmas_exceeded": 0,
        "unanswered": 2,
        "error_reaction": 2,
        "system_error": 0,
        "damaged": 1,
        "line_error": 1,
        "lost": 1,
        "repeated": 2,  # 14 is 11 again, and 16 is 14 again
    }


def test_intervals_are_those_inside_telegrams_without_lost_characters(figures: dict[str, Any]) -> None:
    intervals = figures["intervals"]
    assert intervals["count"] == sum(
        len(sent.data) - 1 for sent in FRAMES if not any(f & 8 for f in sent.flags.values())
    )
    assert intervals["shortest_s"] == 0.0
    assert intervals["half_within_s"] == pytest.approx(CHARACTER_S, abs=1e-9)
    assert intervals["longest_s"] == 0.0075


def test_reaction_times(figures: dict[str, Any]) -> None:
    (service,) = figures["services"]
    assert (service["service"], service["name"]) == (0x10, "Read parameter")
    times = service["times"]
    # 25 ms four times, 80 ms once.
    assert times["count"] == 5
    assert times["shortest_s"] == times["half_within_s"] == pytest.approx(0.025, abs=1e-9)
    assert times["longest_s"] == pytest.approx(0.08, abs=1e-9)
    assert times["average_s"] == pytest.approx(0.18 / 5, abs=1e-9)
    assert service["trs"]["exceeded"] == 1


def test_a_log_beside_a_capture_adds_no_intervals(tshark: Tshark, tmp_path: Path) -> None:
    """Nine commands like the first, but each in one read: they are in no table of intervals, and in no quantile."""
    in_one_read = Sent(READ, flags={place: Flag.SAME_READ for place in range(2, len(READ) + 1)})
    alone, both = (
        made(tshark, write(tmp_path / f"{number}.pcapng", [Sent(READ), Sent(ANSWER), *[in_one_read] * number]))
        for number in (0, 9)
    )
    assert tables.pauses(both).rows == tables.pauses(alone).rows
    assert tables.places(both).rows == tables.places(alone).rows
    of_all, of_one = (report.figures.pauses.intervals for report in (both, alone))
    assert (of_all.count, of_all.within_s(0.5)) == (of_one.count, of_one.within_s(0.5))
    assert (both.figures.pauses.same_read, both.figures.pauses.count) == (9 * 12, 9 * 12 + 12 + len(ANSWER) - 1)


def test_what_came_in_one_read_is_judged_but_has_no_reaction_time(tshark: Tshark, tmp_path: Path) -> None:
    late = [
        Sent(data, flags={place: Flag.SAME_READ for place in range(first, len(data) + 1)}, uncertainty_ns=500_000_000)
        for data, first in ((READ, 2), (ANSWER, 1))
    ]
    report = made(tshark, write(tmp_path / "late.pcapng", [*BUS[:3], *late]))
    station = report.figures.stations[3]
    assert (station.reactions, station.times.count, station.trs.verdicts[UNRESOLVED]) == (1, 0, 1)
    (service,) = tables.services(report).rows
    assert service[2:7] == ("not measured",) * 5
    (talking, answering) = sorted(tables.stations(report).rows, key=lambda row: int(row[1]))[::-1]
    assert (talking[6:8], answering[6:8]) == (("", ""), ("not measured", "not measured"))
    assert page.page(report)
    figures = json.loads(plain.as_json(report), parse_constant=pytest.fail)
    assert [one["times"] for one in figures["services"]] == [{"count": 0}]
    (late_one,) = (one for one in report.episodes if one.kind == "late")
    assert (late_one.hit.detail, late_one.hit.worst) == ("perhaps: not measured, TrS 50 ms", None)
    assert any("are in no median: station 3 (1 of 1). Uncertainty" in text for text in tables.remarks(report))


def test_stations(figures: dict[str, Any]) -> None:
    stations = {station["station"]: station for station in figures["stations"]}
    names = ("commands", "reactions", "reactions_with_error", "sent_again", "not_answered")
    assert {address: tuple(station[name] for name in names) for address, station in stations.items()} == {
        16: (10, 0, 0, 2, 0),  # 14 is 11 again, and 16 is 14 again
        3: (0, 3, 0, 0, 2),
        4: (0, 2, 2, 0, 0),
    }
    assert stations[16]["tza"]["exceeded"] == 1
    assert stations[16]["longest_pause_s"] == 0.0075
    assert stations[4]["trs"]["exceeded"] == 1
    assert stations[4]["reaction_times"]["longest_s"] == pytest.approx(0.08, abs=1e-9)


def test_what_happened(figures: dict[str, Any]) -> None:
    episodes = [(episode["kind"], episode["severity"], episode["packets"]) for episode in figures["episodes"]]
    assert episodes == [
        ("interval", "error", [7]),
        ("late", "error", [10]),
        ("never", "note", [10, 13]),  # both refuse what nobody has ever read
        ("repeated", "note", [11]),  # and 15, but there something damaged came
        ("interval", "note", [13]),
        ("line_error", "note", [14]),
        ("damaged", "note", [15]),
        ("lost", "note", [17]),
    ]
    (interval,) = (episode for episode in figures["episodes"] if episode["packets"] == [7])
    assert (interval["kind"], interval["station"], interval["worst"]) == ("interval", 16, 0.0075)


def test_what_kept_its_limit_is_below_what_did_not_or_may_not_have(tshark: Tshark, tmp_path: Path) -> None:
    limited = [Sent(SET_TRS), Sent(ACCEPT)]
    times_ms = {62.6: 0, 11.8: 0, 80.0: 0, 49.9: 500_000}  # with their uncertainties in ns; TrS is 50 ms
    for time_ms, uncertainty_ns in times_ms.items():
        limited += [Sent(READ), Sent(ANSWER, silence_ms=time_ms, uncertainty_ns=uncertainty_ns)]
    judged = made(tshark, write(tmp_path / "x", limited))
    late, perhaps = judged.episodes
    assert (late.kind, late.station, late.count, late.packets) == ("late", 3, 2, [5, 9])
    assert late.text == "Reaction later than TrS, station 3: 80.000 ms, TrS 50 ms (2 times)"
    assert (perhaps.kind, perhaps.severity, perhaps.packets) == ("late", Severity.NOTE, [11])
    assert tables.answer(judged)[0].startswith("NOT OK, ")
    unresolved = made(tshark, write(tmp_path / "y", [*limited[:2], *limited[-2:]]))
    first, *_, last = tables.answer(unresolved)
    assert first.startswith("OK as far as it was judged, ")  # nobody set TzA
    assert "perhaps 1 reaction later than TrS (49.900 ms, TrS 50 ms, station 3, " in last


@pytest.mark.parametrize(
    ("started", "timer"),
    [
        ("FT232R (ftdi_sio, latency timer 16 ms)", " The latency timer of the adapter was 16 ms."),
        ("adapter not known", ""),
    ],
)
def test_beside_unresolved_verdicts_stands_what_to_do(tshark: Tshark, tmp_path: Path, started: str, timer: str) -> None:
    sent = [Sent(SET_TRS), Sent(ACCEPT), Sent(READ), Sent(ANSWER, silence_ms=49.9, uncertainty_ns=16_000_000)]
    judged = made(tshark, write(tmp_path / "x", sent, started=started))
    note = tables.verdicts(judged).note
    assert note.startswith("1 unresolved: the times are uncertain by ")
    assert f" to 16.000 ms.{timer} Make the times more exact: " in note
    assert "latency timer of an FTDI adapter at 1 ms. sistap doctor says how." in note
    assert escape(note) in page.page(judged)
    assert " ".join(note.split()) in " ".join(plain.as_text(judged).split())


def test_beside_unresolved_verdicts_of_unknown_times(tshark: Tshark, tmp_path: Path) -> None:
    unknown = [Sent(data, uncertainty_ns=UNCERTAINTY_UNKNOWN) for data in (SET_TRS, ACCEPT, READ, ANSWER)]
    note = tables.verdicts(made(tshark, write(tmp_path / "x", unknown))).note
    assert " unresolved: nobody knows how exact the times are. Make the times more exact: " in note


def test_beside_each_fault_stands_what_to_do(tshark: Tshark, report: Report) -> None:
    done = {title: (count, do) for title, count, _, do in tables.faults(report).rows}
    assert done["Damaged telegram"][1].endswith("Check cable, termination, ground and baud rate.")
    assert done["Command without a reaction"][1].startswith("Look whether this station answers at other times.")
    assert all((count != "0") == bool(do) for count, do in done.values())
    assert tables.verdicts(report).note  # one is unresolved: `test_verdicts`


def test_a_dead_bus_is_said(tshark: Tshark, tmp_path: Path) -> None:
    """Records cannot hold so long a silence; nor can one whose record before is in another file, or an interval."""
    exchange = [Sent(READ), Sent(ANSWER)] * 2
    dead = write(tmp_path / "dead.pcapng", [*exchange, Sent(READ, silence_ms=300_000.0), Sent(ANSWER)])
    report = made(tshark, dead)
    assert tables.answer(report)[0].endswith(", all stations: cable or master off?")
    assert [episode.text for episode in report.episodes] == ["Bus silent: 300 s: cable or master off?"]
    assert ("Silences above 200 ms", "1") in tables.summary(report).rows
    silences = json.loads(plain.as_json(report))["silences"]
    assert silences == {"above_200_ms": 1, "longest_s": 300.0, "longest_before_packet": 6}
    saturated = Sent(READ, pauses_ms={5: 4294.967295}, flags={5: Flag.INTERVAL_SATURATED})
    report = made(tshark, write(tmp_path / "inside.pcapng", [saturated]))
    assert ("16", "more than 4294.967 ms") in [(row[0], row[8]) for row in tables.stations(report).rows]


def test_display_filters_find_what_they_stand_beside(sharkd: Sharkd, capture: Path, report: Report) -> None:
    assert report.episodes
    for episode in report.episodes:
        assert sharkd.frames(capture, episode.filter) == episode.packets
        if episode.rule.filter:
            assert set(episode.packets) <= set(sharkd.frames(capture, episode.rule.filter))
    for fault in FAULTS:
        assert len(sharkd.frames(capture, fault.filter)) == report.figures.faults[fault.name]


def test_windows_show_the_worst_and_what_was_asked_for(tshark: Tshark, capture: Path) -> None:
    # The first exchange is packets 5 and 6: from the middle of the one to the middle of the other.
    before = sum(sent.silence_ms / 1e3 + (len(sent.data) - 1) * CHARACTER_S for sent in BUS[:3])
    start = before + 0.025 + 2.5 * CHARACTER_S
    length = (len(READ) - 1) * CHARACTER_S + 0.025
    report = made(tshark, capture, f"{start}+{length}", "100+1")
    asked, nothing, *worst = report.windows
    assert [packet.number for packet in asked.packets] == [5, 6]
    assert asked.packets[0].intervals_s == pytest.approx([CHARACTER_S] * (len(READ) - 1), abs=1e-9)
    assert nothing.packets == []
    assert [window.title for window in worst] == [
        "Packet 10: Reaction later than TrS",
        "Packet 7: Interval longer than TzA",
        "Packet 15: Damaged telegram",
    ]
    for window, packet in zip(worst, (10, 7, 15), strict=True):
        assert packet in [shown.number for shown in window.packets]


def test_a_window_that_shows_two_of_the_worst_is_not_made_twice(tshark: Tshark, capture: Path) -> None:
    report = made(tshark, capture, "0+10")
    assert [window.title for window in report.windows] == ["Asked for: 10 s from 0 s"]


class PrintingTshark(NoTap):
    """tshark with sis.lua, or with a dissector that lacks some fields. It says so as tshark 4.0 does."""

    def __init__(self, rows: Sequence[Mapping[str, str]], unknown: Collection[str] = ()) -> None:
        self._rows = rows
        self._unknown = unknown

    def lines(self, arguments: Sequence[str]) -> Iterator[str]:
        asked = list(zip(arguments, arguments[1:], strict=False))
        names = [name for option, name in asked if option == "-e"]
        if refused := [name for name in names if name in self._unknown]:
            raise TsharkError("tshark: Some fields aren't valid:\n" + "".join(f"\t{name}\n" for name in refused))
        assert ("-E", "header=y") in asked
        yield "\t".join(names)
        for row in self._rows:
            yield "\t".join(row.get(name, "") for name in names)


class CountedTshark:
    """tshark, and how often it dissects."""

    def __init__(self, tshark: Tshark) -> None:
        self._tshark = tshark
        self.runs = 0

    def pieces(self, arguments: Sequence[str]) -> Iterator[bytes]:
        self.runs += 1
        return self._tshark.pieces(arguments)


def test_nothing_is_dissected_again_for_the_windows(tshark: Tshark, capture: Path) -> None:
    counted = CountedTshark(tshark)
    report = made(cast(Tshark, counted), capture, "0+10")
    assert report.windows[0].packets
    assert counted.runs == 1


@given(
    times_s=st.lists(st.integers(0, 40).map(float), max_size=60),
    starts_s=st.lists(st.integers(0, 40).map(float), max_size=2),
)
def test_what_is_read_again_is_what_was_asked_for(times_s: list[float], starts_s: list[float]) -> None:
    """Whatever the order of the times, and wherever a blob ends."""
    times_s = [0.0, *times_s]
    rows = [
        {"frame.number": str(number), "frame.time_relative": str(time_s)} for number, time_s in enumerate(times_s, 1)
    ]
    timed = cast(Tshark, PrintingTshark(rows))
    spans = [Span(start_s, start_s + 3) for start_s in starts_s]
    with pytest.MonkeyPatch.context() as patch, Dissection(timed, [Portion(Path("x"))]) as dissection:
        patch.setattr("sistap.dissected.packets.kept._TOGETHER", 7)
        read = list(dissection.packets())
        again = list(dissection.again(spans))
    assert [packet.time_s for packet in read] == times_s
    assert again == [packet for packet in read if any(span.start_s <= packet.time_s <= span.end_s for span in spans)]


def test_no_room_to_keep_what_was_read(
    tshark: Tshark, capture: Path, full: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.TemporaryFile", lambda prefix: full.open("w+b"))
    with Dissection(tshark, [Portion(capture)]) as dissection:
        list(dissection.packets())
        with pytest.raises(Refusal, match="cannot keep what was read of the capture: No space left .* TMPDIR$"):
            list(dissection.again([]))


def test_a_window_keeps_a_bounded_number_of_packets() -> None:
    window = ReportWindow("", 0.0, 10.0)
    for _ in range(PACKETS_KEPT + 7):
        window.add(a_packet())
    assert (len(window.packets), window.left_out) == (PACKETS_KEPT, 7)


def a_packet() -> Packet:
    return Packet("", 0, 0, 9600, "8E1", 0, None, "", 0, 0, (), 1, 0.0, 1.0, None, [])


def test_bare_telegrams_have_reaction_times_and_no_verdict_on_tza(tshark: Tshark, tmp_path: Path) -> None:
    sent = [Sent(READ), Sent(ANSWER, silence_ms=30.0), Sent(READ), Sent(ANSWER)]
    report = made(tshark, write(tmp_path / "bare.pcapng", sent, dissector="sis"))
    figures = json.loads(plain.as_json(report))
    assert figures["telegrams"] == {"all": 4, "damaged": 0}
    assert figures["intervals"] == {"count": 0}
    assert figures["clock"]["uncertainty_most_s"] is None
    # From packet to packet: the command's own length and the silence.
    longest_s = (len(READ) - 1) * CHARACTER_S + 0.030
    assert figures["services"][0]["times"]["longest_s"] == pytest.approx(longest_s, abs=1e-6)
    assert any("no records of the tap" in remark for remark in tables.remarks(report))
    assert report.windows == []


@pytest.mark.parametrize(
    ("started", "remark"),
    [
        ("CH340; no line errors are reported", "The adapter reports no line errors: damaged characters look like good"),
        ("CP2102; line errors at their character", "Telegrams are damaged, but there is not one line error: they were"),
        ("of an unknown driver", ""),
    ],
)
def test_what_the_adapter_does_not_say(tshark: Tshark, tmp_path: Path, started: str, remark: str) -> None:
    damaged = Sent(READ[:-1] + bytes([READ[-1] ^ 1]))
    report = made(tshark, write(tmp_path / "x.pcapng", [Sent(READ), damaged], started=started))
    found = [text for text in tables.remarks(report) if "line error" in text]
    assert len(found) == bool(remark)
    assert "".join(found).startswith(remark)


def test_what_is_no_sis_is_counted_with_its_intervals(tshark: Tshark, tmp_path: Path) -> None:
    """3964R: an STX, and a block of four characters of which the third comes 100 ms late."""
    path = tmp_path / "3964r.pcapng"
    stx = Sent(b"\x02", framing=Framing.PROCEDURE_3964R)
    block = Sent(b"A\x10\x03R", pauses_ms={3: 100.0}, framing=Framing.PROCEDURE_3964R)
    report = made(tshark, write(path, [stx, block, Sent(b"x", type=Type.OTHER)]))
    figures = json.loads(plain.as_json(report))
    assert figures["records"] == {"telegrams": 0, "other_characters": 1, "events": 1}
    assert figures["other_frames"] == {"1": 2}
    assert figures["other_frame_intervals"]["count"] == 3
    assert figures["other_frame_intervals"]["longest_s"] == pytest.approx(0.1)
    assert "It has 2 handshakes and blocks of 3964R: their limits are not judged here." in tables.remarks(report)
    rows = {row[0]: row[1] for row in tables.summary(report).rows}
    assert rows["Packets"] == "4: 1 other characters, 1 events, 2 handshakes and blocks of 3964R"
    shown = "3, from character to character: half within 1.146 ms, the longest 100.000 ms"
    assert rows["Intervals in other frames"] == shown
    assert "handshakes and blocks of 3964R" in page.page(report)


def old(unknown: Collection[str]) -> Tshark:
    """tshark with a dissector that does not know some fields."""
    known = {"frame.number": "1", "frame.time_epoch": "0.0", "frame.time_relative": "0.0", "sis.start": "0x02"}
    known |= {"sis.checksum.status": "1", "sertap.type": "0", "sertap.interval.max": "0.001145833"}
    return cast(Tshark, PrintingTshark([known], unknown))


def test_fields_that_the_dissector_does_not_know_are_left_out_and_named() -> None:
    unknown = [name for name in FIELDS if name.startswith(("sis.tza", "sis.trs", "sis.tmas"))]
    report = made(old(unknown), Path("x.pcapng"))
    assert report.missing == unknown
    assert report.figures.telegrams == 1
    assert report.figures.limits["tza"].verdicts == {None: 1}  # the longest interval is known from the tap's record
    (remark,) = tables.remarks(report)
    assert all(name in remark for name in unknown)


def test_without_any_dissector_it_says_what_to_do() -> None:
    with pytest.raises(TsharkError, match="WIRESHARK_PLUGIN_DIR"):
        made(old([name for name in FIELDS if name.startswith("s")]), Path("x.pcapng"))


def test_tmas_is_judged_from_master_control_word_to_master_control_word(tshark: Tshark, tmp_path: Path) -> None:
    set_tmas = build(0x03, 16, 255, bytes.fromhex("FF 03 64 00"))  # 100 ms
    control_word = build(0x1F, 16, 3, bytes.fromhex("3C 03 00 86 00 00 E0"))  # S-0-0134
    done = build(0x1F, 16, 3, bytes.fromhex("00 3C 03"), reaction=True)
    sent = [
        Sent(set_tmas),
        Sent(ACCEPT),
        Sent(control_word),
        Sent(done),
        Sent(control_word, silence_ms=200),
        Sent(done),
    ]
    figures = json.loads(plain.as_json(made(tshark, write(tmp_path / "tmas.pcapng", sent))))
    assert figures["limits"]["tmas"]["limits_s"] == [0.1]
    assert figures["limits"]["tmas"]["exceeded"] == figures["faults"]["tmas_exceeded"] == 1
    characters = len(control_word) - 1 + len(done) - 1
    (cycle,) = (one for one in figures["episodes"] if one["severity"] == "error")
    assert (cycle["kind"], cycle["packets"]) == ("cycle", [6])
    assert cycle["worst"] == pytest.approx(0.225 + characters * CHARACTER_S, abs=1e-6)


def said(**columns: str) -> Packet:
    """Return the packet of which tshark says one thing."""
    row = {"frame.number": "7", "frame.time_epoch": "0.0", "frame.time_relative": "0.0"}
    row |= {name.replace("__", "."): text for name, text in columns.items()}
    with Dissection(cast(Tshark, PrintingTshark([row])), [Portion(Path("x.pcapng"))]) as dissection:
        (packet,) = dissection.packets()
    return packet


def test_intervals_whose_characters_are_not_said_are_left_out() -> None:
    def intervals(text: str, unknown: str) -> list[float]:
        return said(sertap__interval=text, sertap__interval__unknown=unknown).intervals_s

    assert intervals("0.1\x1f0.2\x1f0.3", "") == [0.2, 0.3]
    assert intervals("0.1\x1f0.2\x1f0.3", "1") == [0.1, 0.2, 0.3]
    assert intervals("0.1\x1f0.2\x1f0.3", "1\x1f1") == []


@pytest.mark.parametrize(
    "columns",
    [
        {"_ws.col.Info": r'3 other characters  "A\r\\"', "_ws.col.info": ""},  # 4.0
        {"_ws.col.Info": "", "_ws.col.info": r'3 other characters  "A\\r\\\\"'},  # 4.4 and 4.6
        {"_ws.col.info": r'3 other characters  "A\\r\\\\"'},
    ],
)
def test_an_escape_in_the_packet_list_is_not_escaped_again(columns: dict[str, str]) -> None:
    assert info(columns) == r'3 other characters  "A\r\\"'


def test_what_later_versions_of_wireshark_write() -> None:
    packet = said(sis__start="0x02", sis__control__reaction="True", sis__checksum__status="Good")
    assert packet.telegrams[0].is_reaction
    assert packet.telegrams[0].good
    assert not packet.faults


def test_rows_that_differ_only_in_what_is_their_own_are_told_apart(tshark: Tshark, tmp_path: Path) -> None:
    """What rows have in common is worked out once; each is as if it were alone. All captures, each a section of one."""
    every = tmp_path / "every.pcapng"
    every.write_bytes(b"".join(path.read_bytes() for path in sorted(CAPTURES.glob("*.pcapng"))))
    with Dissection(cast(Tshark, WithoutTap(tshark)), [Portion(every)]) as dissection:
        for packet in dissection.packets():
            alone = packet_of(dict(packet.columns))
            alone.time_s, alone.is_again = packet.time_s, packet.is_again
            if packet.time_s < 1:  # the load of less than a second is none
                for telegram in alone.telegrams:
                    telegram.load_percent = None
            assert packet == alone


def test_several_telegrams_in_a_packet_are_told_apart_where_that_is_possible() -> None:
    packet = said(
        sis__start="0x02\x1f0x02",
        sis__checksum__status="1\x1f0",
        sis__talker="16\x1f3",
        sis__service="0x10\x1f0x12",
        sis__control__reaction="0\x1f1",
        sis__reaction_time="0.5",
    )
    first, second = packet.telegrams
    assert (first.talker, first.service, first.is_reaction, first.good) == (16, 0x10, False, True)
    assert (second.talker, second.service, second.is_reaction, second.good) == (3, 0x12, True, False)
    assert first.reaction is None  # whose it is, is not said
    assert second.reaction is None
    figures = Figures()
    figures.add(packet)
    figures.finish()
    assert (figures.telegrams, figures.good) == (2, 1)
    assert list(figures.stations) == [16]


def test_alike_packets_are_counted_together_as_one_by_one(
    tshark: Tshark, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    every = tmp_path / "every.pcapng"
    every.write_bytes(b"".join(path.read_bytes() for path in sorted(CAPTURES.glob("*.pcapng"))))
    together = plain.as_text(made(tshark, every))
    monkeypatch.setattr("sistap.commands.report.figures.TOGETHER", 1)
    assert plain.as_text(made(tshark, every)) == together


def test_the_first_of_equal_times_is_the_longest() -> None:
    """Packets that are counted together do not come one after the other."""
    columns = {"sertap.type": "0", "sis.start": "0x02", "sis.talker": "3", "sis.checksum.status": "1"}
    times = {"sis.tza.interval_max": "0.004", "sis.silence_before": "0.300"}
    several = Figures()
    # The second is not like the first. The third is like the first, so it is counted before the second.
    for number, status, more in ((1, "0", {}), (2, "1", times), (3, "0", times)):
        own = {"frame.number": str(number), "sis.tza.position": str(number), "sis.status": status}
        packet = packet_of(columns | own | more)
        packet.alike = status
        several.add(packet)
    several.finish()
    assert several.silences.before == 2
    (pause,) = several.pauses.talkers.values()
    assert (pause.longest_s, pause.position) == (0.004, 2)


@pytest.mark.parametrize(
    "text", ["", "5", "5+", "+1", "5+0", "5+-1", "-1+2", "nan+1", "1+inf", "1e308+1e308", "1e10+1", "1+1e10", "a+b"]
)
def test_what_is_no_window(text: str) -> None:
    with pytest.raises(ValueError, match="12.5\\+0.2"):
        stretch(text)


def test_what_no_limit_judges_is_not_said_to_be_good(tshark: Tshark, tmp_path: Path) -> None:
    """Nothing sets TrS or TzA. To find no fault is no verdict; nor is a 0 in a table of those that exceed it."""
    report = made(tshark, write(tmp_path / "unknown.pcapng", [Sent(READ), Sent(ANSWER)]))
    first, *_, limits = tables.answer(report)
    assert first.startswith("OK as far as it was judged, ")
    assert limits == "Limits: not judged: reaction times (no TrS), intervals in telegrams (no TzA)."
    assert json.loads(plain.as_json(report))["not_judged"] == [
        "reaction times (no TrS)",
        "intervals in telegrams (no TzA)",
    ]
    assert f'<p class="headline">{limits}</p>' in page.page(report)
    assert "OK, " not in plain.as_text(report)
    assert {row[0]: row[2:5] for row in tables.verdicts(report).rows}[tables._LIMITS["trs"][0]] == ("not judged",) * 3
    assert {row[0]: row[-2:] for row in tables.stations(report).rows} == {
        "3": ("not judged", "not judged"),
        "16": ("0", "not judged"),  # it reacts to nothing
    }


def test_one_station_without_a_limit_is_named(tshark: Tshark, tmp_path: Path) -> None:
    """TrS is set for station 3 alone, TzA for all."""
    sent = [Sent(SET_TZA), Sent(ACCEPT)]
    for command, reaction in (("03 01 32 00", "00 03 01"), ("03 FF", "00 03 FF")):
        sent.append(Sent(build(0x03, 16, 3, bytes.fromhex(command))))
        sent.append(Sent(build(0x03, 16, 3, bytes.fromhex(reaction), reaction=True)))
    sent += [Sent(READ), Sent(ANSWER), Sent(READ_4), Sent(ANSWER_4)]
    report = made(tshark, write(tmp_path / "one.pcapng", sent))
    assert tables.answer(report)[-1] == "Limits: not judged: reaction times of station 4 (no TrS)."
    assert tables.stations(report).rows[1][-2:] == ("not judged", "0")


def test_all_is_judged_where_limits_are_known(tshark: Tshark, tmp_path: Path) -> None:
    sent = [Sent(SET_TZA), Sent(SET_TRS), Sent(ACCEPT), Sent(READ), Sent(ANSWER)]
    report = made(tshark, write(tmp_path / "known.pcapng", sent))
    first, *_, limits = tables.answer(report)
    assert (first.startswith("OK, "), limits) == (True, "Limits: nothing.")
