# SPDX-License-Identifier: GPL-2.0-or-later
"""What a row of tshark says of a packet, and how several captures are read as one. The rows are made here."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import pytest
from no_tap import Printing

from sistap.dissected.accesses.access import accesses
from sistap.dissected.captures.portions import Begin, Portion
from sistap.dissected.packets.apart import apart
from sistap.dissected.packets.dissection import Dissection, Packet, packet_of
from sistap.dissected.packets.kept import Kept, Span
from sistap.dissected.wireshark.rows import BEFORE, EVENT, FRAME, JOINT, OTHER
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import KEPT, Event
from sistap.tap.terminal.console import visible

READ = {"frame.number": "7", "sis.start": "0x02", "sis.checksum.status": "1", "sis.service": "0x10", "sis.talker": "1"}


def of(**columns: str) -> Packet:
    """Return the packet of a read, and of what is said besides; `_` stands for a point."""
    return packet_of(READ | {name.replace("__", "."): text for name, text in columns.items()})


def several(*texts: str) -> str:
    return JOINT.join(texts)


@pytest.mark.parametrize(
    ("status", "is_good"), [("1", True), ("Good", True), ("0", False), ("Bad", False), ("2", False), ("", False)]
)
def test_what_is_good(status: str, is_good: bool) -> None:
    assert of(sis__checksum__status=status).telegrams[0].good is is_good


@pytest.mark.parametrize(
    ("columns", "is_refusal"),
    [
        ({"sis__status": "0x00"}, False),
        ({"sis__status": "0x01"}, True),
        ({"sis__status": "0xf0"}, True),
        ({"sis__status": several("0x00", "0x01")}, False),  # a list of services: its own status is the first
        ({"sis__control__status": "6"}, True),  # ECODRIVE03: 110, error
        ({"sis__control__status": "4"}, False),  # 100, a warning
        ({"sis__control__status": "0"}, False),
        ({}, False),
    ],
)
def test_what_is_a_refusal(columns: dict[str, str], is_refusal: bool) -> None:
    assert of(sis__control__reaction="1", **columns).telegrams[0].is_refusal is is_refusal


@pytest.mark.parametrize("name", ["trs", "tza", "tmas"])
@pytest.mark.parametrize(("verdict", "is_doubtful"), [("0", False), ("1", True), ("2", True), ("", False)])
def test_what_is_doubtful(name: str, verdict: str, is_doubtful: bool) -> None:
    assert (
        of(**{f"sis__{name}__verdict": verdict, f"sis__{name}__limit": "0.05"}).telegrams[0].is_doubtful is is_doubtful
    )


def test_times_with_their_limits_and_verdicts() -> None:
    (telegram,) = of(
        **{"sis__reaction_time": "0.01", "sis__trs__limit": "0.05", "sis__trs__verdict": "0", "sis__command_in": "6"},
        **{"sis__tza__interval_max": "0.003", "sis__tza__limit": "0.002", "sis__tza__verdict": "1"},
        **{"sis__tmas__cycle": "0.1", "sis__silence_before": "0.4", "sis__bus__load": "40", "sis__tza__position": "5"},
    ).telegrams
    assert (telegram.reaction, telegram.pause) == ((0.01, 0.05, 0), (0.003, 0.002, 1))
    assert (telegram.cycle, telegram.silence) == ((0.1, None, None), (0.4, None, None))
    assert (telegram.command_in, telegram.load_percent, telegram.pause_position) == (6, 40, 5)
    (twice,) = of(sis__reaction_time=several("0.01", "0.02"), sis__trs__limit=several("0.05", "0.06")).telegrams
    assert twice.reaction == (0.01, 0.05, None)
    (nothing,) = of().telegrams
    times = nothing.reaction, nothing.pause, nothing.cycle, nothing.silence, nothing.command_in, nothing.load_percent
    assert times == (None,) * 6


def test_a_verdict_without_a_time_is_not_measured() -> None:
    """All came in one read, or the clock was set back."""
    (telegram,) = of(sis__trs__verdict="2", sis__tza__verdict="2", sis__tmas__verdict="2").telegrams
    for judged in (telegram.reaction, telegram.pause, telegram.cycle):
        assert judged and (judged.time_s, judged.verdict, judged.measured_s) == (0.0, 2, [])


def test_without_a_verdict_on_tza_the_record_says_the_longest_interval() -> None:
    assert of(sertap__interval__max="0.004").telegrams[0].pause == (0.004, None, None)
    assert of(sertap__interval__max="0.004", sis__tza__interval_max="0.003").telegrams[0].pause == (0.003, None, None)


def test_the_first_interval_is_before_the_record() -> None:
    packet = of(sertap__interval=several("0.5", "0.001", "0.002"), sertap__type="0", frame__time_epoch="100")
    assert (packet.since_s, packet.intervals_s, packet.type) == (0.5, [0.001, 0.002], FRAME)
    assert [packet.end_s, packet.ended_s] == pytest.approx([0.003, 100.003])
    first = of(sertap__interval="0.001", sertap__interval__unknown="1")  # of its line: nothing is printed for it
    assert (first.since_s, first.intervals_s) == (None, [0.001])
    assert of(sertap__interval=several("0.5", "1"), sertap__interval__unknown=several("1", "True")).intervals_s == []
    longest = of(sertap__interval=several("4.294967295", "0.1"))  # it may be longer
    assert (longest.since_s, longest.intervals_s) == (None, [0.1])
    assert of().since_s is None


def test_words_and_times_of_a_record() -> None:
    said = {"sertap.type": "0", "sertap.line": "1", "sertap.baud": "19200", "sertap.format": "8E1"}
    said |= {"sertap.framing": "2", "sertap.uncertainty": "0.0003", "frame.interface_name": "COM3"}
    said |= {"frame.time_epoch": "100.000000005", "frame.time_relative": "2.5", "sertap.character": "0x02\x1f0x1f"}
    one = packet_of(READ | said)
    assert (one.number, one.type, one.line, one.baud, one.format, one.framing) == (7, FRAME, 1, 19200, "8E1", 2)
    assert (one.interface, one.uncertainty_s, one.epoch_ns, one.time_s) == ("COM3", 0.0003, 100_000_000_005, 2.5)
    assert (one.characters, one.text, one.event) == (b"\x02\x1f", "", None)


def test_line_errors_and_reads() -> None:
    errors = {
        "sertap__error__character": Flag.CHARACTER_ERROR,
        "sertap__error__break": Flag.BREAK,
        "sertap__error__unlocated": Flag.UNLOCATED_ERROR,
        "sertap__error__lost": Flag.LOST_BEFORE,
    }
    for name, flag in errors.items():
        assert of(**{name: several("0", "1")}).errors == flag
        assert of(**{name: several("0", "False")}).errors == 0
    assert of(sertap__error__break="1", sertap__error__lost="1").errors == Flag.BREAK | Flag.LOST_BEFORE
    for same, is_one in (("1", False), (several("1", "1"), True), (several("True", "1", "1"), True)):
        assert of(sertap__interval=several("9", "0", "0"), sertap__same_read=same).is_of_one_read is is_one
    assert not of(sertap__same_read="1").is_of_one_read


def test_what_a_damaged_telegram_says_may_be_damaged() -> None:
    def faults(**columns: str) -> list[str]:
        return [fault.name for fault in of(**columns).faults]

    refused = {"sis__status": "0x01", "sis__control__error__set": "1"}
    assert faults(**refused) == ["error_reaction", "system_error"]
    assert faults(sis__checksum__status="0", **refused) == ["damaged"]
    assert faults(sis__checksum__status="0", sis__trs__verdict="1") == ["trs_exceeded", "damaged"]


def test_each_of_several_telegrams_has_its_faults_and_the_record_its_own() -> None:
    packet = packet_of(
        {
            "frame.number": "7",
            "sis.start": several("0x02", "0x02"),
            "sis.status": several("0x01", "0x01"),
            "sis.talker": several("3", "4"),
            "sis.packed": "sis.start=1 sis.status=1 sis.talker=1",
            "sertap.error.character": "1",
        }
    )
    assert [one.talker for one in packet.telegrams] == [3, 4]
    assert [[fault.name for fault in one.faults] for one in packet.telegrams] == [["error_reaction"]] * 2
    assert [fault.name for fault in packet.faults] == ["error_reaction", "error_reaction", "line_error"]
    alone = of(sis__status="0x01", sertap__error__character="1")
    assert [fault.name for fault in alone.faults] == ["error_reaction", "line_error"]


def test_a_damaged_telegram_hides_no_fault_of_another() -> None:
    said = {"sis.start": several("0x02", "0x02"), "sis.status": several("0x01", "0x01")}
    packed = {"sis.checksum.status": several("0", "1"), "sis.packed": "sis.start=1 sis.status=1 sis.checksum.status=1"}
    packet = packet_of({"frame.number": "7"} | said | packed)
    assert [[fault.name for fault in one.faults] for one in packet.telegrams] == [["damaged"], ["error_reaction"]]
    assert [fault.name for fault in packet.faults] == ["error_reaction", "damaged"]


def test_what_only_the_second_telegram_says_is_its_own() -> None:
    said = {"frame.number": "7", "sis.start": several("0x02", "0x02"), "sis.talker": several("1", "3")}
    packet = packet_of(said | {"sis.status": "0x01", "sis.packed": "sis.start=1 sis.status=1 sis.talker=1"})
    assert [(one.talker, one.status) for one in packet.telegrams] == [(1, None), (3, 1)]


def test_values_are_dealt_out_by_what_the_later_telegrams_say() -> None:
    """Of three: the last alone is about a parameter, and the second alone says a phase, and two statuses."""
    columns = {
        "frame.number": "7",
        "sis.start": several("0x02", "0x02", "0x02"),
        "sis.status": several("0x00", "0x01", "0x02", "0x03"),
        "sis.talker": several("3", "4", "5"),
        "sis.command_in": "6",
        "sis.phase": "4",
        "sis.parameter": "S-0-0036",
        "sis.packed": several(
            "sis.phase=1 sis.start=1 sis.status=2 sis.talker=1", "sis.parameter=1 sis.start=1 sis.status=1 sis.talker=1"
        ),
        "sis.value": "",
    }
    assert apart(columns, 3) == [
        {"sis.start": "0x02", "sis.status": "0x00", "sis.talker": "3", "sis.command_in": "6"},
        {"sis.start": "0x02", "sis.status": several("0x01", "0x02"), "sis.talker": "4", "sis.phase": "4"},
        {"sis.start": "0x02", "sis.status": "0x03", "sis.talker": "5", "sis.parameter": "S-0-0036"},
    ]


def test_what_stands_in_the_place_of_a_telegram_is_none() -> None:
    columns = {
        "sis.start": several("0x02", "0x02"),
        "sis.raw": "ff",
        "sis.packed": several("sis.raw=1", "sis.start=1"),
    }
    assert apart(columns, 2) == [{"sis.start": "0x02"}, {"sis.start": "0x02"}]


def test_what_cannot_be_dealt_out_is_left_out() -> None:
    """An empty text is not printed, so one of these is missing."""
    said = {"sis.value": "1", "sis.start": several("0x02", "0x02"), "sis.packed": "sis.start=1 sis.value=2"}
    assert apart(said, 2) == [{"sis.start": "0x02"}, {"sis.start": "0x02"}]


def test_an_older_dissector_does_not_say_what_is_of_which() -> None:
    said = {"sis.start": several("0x02", "0x02"), "sis.talker": several("1", "3"), "sis.status": "0x01"}
    packet = packet_of(READ | said)
    assert [(one.talker, one.status) for one in packet.telegrams] == [(1, None), (3, None)]
    assert [fault.name for fault in packet.faults] == ["error_reaction"]  # of one of them


def test_other_words_of_a_telegram() -> None:
    (one,) = of(
        sis__repeat_of="3", sis__phase=several("4", "2"), sis__control__error="True", sis__listener="3"
    ).telegrams
    assert (one.is_repeat, one.phase, one.has_system_error, one.listener, one.unanswered) == (True, "4", True, 3, False)
    assert [of(sis__control__reaction=text).telegrams[0].is_reaction for text in ("1", "True", "0", "")] == [
        *(True, True, False, False)
    ]
    (other,) = of(sis__command__unanswered="1", sis__reaction__again="x", sis__twm__early="x").telegrams
    assert (other.unanswered, other.is_repeat, other.signs) == (True, False, ("again", "early"))
    assert of(sis__body__missing="1", sis__length__long="1").telegrams[0].signs == ("against",)


# -- Reads and writes ------------------------------------------------------------------------------------------------

PLACED = {"station": "3/2/8", "device": 4, "parameter": "S-0-0036"}
NAMED = {"name": "Velocity", "unit": "rpm", "minimum": "-9 rpm", "maximum": "8 rpm"}


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (
            {"access": "write", "master": 0, "value": "1 rpm", "number": 1.0, "data": "10270000"} | NAMED,
            (True, 0, "", "1 rpm", 1.0, "10270000", "Velocity", "rpm", "-9 rpm", "8 rpm", False, None),
        ),
        (
            {"access": "read", "master": 127, "value": "01", "data": "01", "raw": True},
            (False, 127, "", "01", None, "01", "", "", "", "", True, None),
        ),
        ({"access": "read", "error": "0x7002"}, (False, None, "0x7002", "", None, None, *[""] * 4, False, None)),
        (
            {"access": "read", "value": "0", "number": 0, "text": "0"},
            (False, None, "", "0", 0, None, *[""] * 4, False, "0"),
        ),
    ],
)
def test_what_is_said_of_a_read_or_write(said: dict[str, Any], expected: tuple[object, ...]) -> None:
    (found,) = of(sis__access=json.dumps(PLACED | said), frame__interface_name="COM3").accesses
    assert (found.parameter, found[1:]) == (("COM3", "3/2/8", 4, "S-0-0036"), expected)


def test_a_packet_may_tell_several_or_none() -> None:
    """A list of services has several. One that another version has written, or that is long, hides no other."""
    texts = [{"access": "read", "value": value} for value in ("1", "2" * 1000, "3")]
    told = several(*(json.dumps(PLACED | text) for text in texts[:2]), "?", json.dumps(PLACED | texts[2]))
    assert [one.value for one in of(sis__access=told).accesses] == ["1", "2" * 1000, "3"]
    assert of().accesses == []


ODD_TEXT = 'a\\b \\\\ \\u0041 \\n "q" \xa0\xe4\u2409'  # as the plugin shows it; a no-break space cannot be seen


@pytest.mark.parametrize("is_doubled", [False, True], ids=["4.0", "4.2"])
def test_a_text_with_quotes_and_backslashes(is_doubled: bool) -> None:
    """`-T fields` doubles each backslash since Wireshark 4.2; the tap, and 4.0, do not."""
    escaped = "".join(c if c.isalnum() and c.isascii() else f"\\u{ord(c):04x}" for c in ODD_TEXT)
    row = f'{{"access":"read","master":16,"station":"3","device":5,"parameter":"S-0-0030","value":"{escaped}"}}'
    row = row.replace("\\", "\\\\") if is_doubled else row
    assert [access.value for access in accesses("", row)] == [visible(ODD_TEXT)]


@pytest.mark.parametrize("number", range(6))
def test_an_access_that_nobody_understands_is_left_out(number: int) -> None:
    texts = '{"value":"\\x"}', "{}", "[]", "1", "{", '{"access":"read","number":' + "1" * 5000 + "}"
    assert list(accesses("", texts[number])) == []


@pytest.mark.parametrize("digits", ["1" * 400, "-" + "1" * 400 + ".5"], ids=["integer", "decimals"])
def test_a_number_that_is_too_large(digits: str) -> None:
    """The ASCII protocol has digits without an end."""
    row = f'{{"access":"read","station":"3","device":5,"parameter":"S-0-0030","value":"{digits}","number":{digits}}}'
    (access,) = accesses("", row)
    assert (access.number, access.value) == (None, digits)


# -- Rows of the plugin's tap ----------------------------------------------------------------------------------------


def entry(kind: str, own: bytes) -> bytes:
    """Return a kind and a row of it, as plugin/docs/rows.md has them."""
    parts = (0, kind.encode()), (1, own)
    return b"".join(struct.pack("=IHH", 8 + len(data), is_row, 7) + data for is_row, data in parts)


class Tap:
    """A tshark that has the tap. It was asked for the status, too."""

    def __init__(self, *entries: bytes) -> None:
        self._entries = entries

    def pieces(self, _arguments: Sequence[str]) -> Iterator[bytes]:
        return iter([b"sis,rows 1\tsis.status\tsis.start\tsis.packed\n", *self._entries])


def test_a_row_of_the_tap_with_two_telegrams() -> None:
    """Two reactions of two stations, and a read of each."""
    kind = "sertap.type=0\tframe.interface_name=COM3\t\nsis.start=2\tsis.talker=3\t\nsis.start=2\tsis.talker=4\t"
    own = struct.pack("=qddIIHHHH", 100, 2.5, math.nan, 5, 9, 2, 2, 2, 0)
    own += struct.pack("=dddddII", 0.4, 0.01, 0.003, math.nan, 40.0, 8, 5)
    own += struct.pack("=dddddII", math.nan, 0.02, math.nan, 0.1, math.nan, 0, 0)
    own += struct.pack("=2d", 0.5, 0.001) + b"\x02\x1f"
    reads = [json.dumps(PLACED | {"access": "read", "value": value}) + JOINT for value in ("one", "two", "three")]
    more = "\t".join(["0x00\x1f0x01", "0x02\x1f0x02", "sis.start=1 sis.status=1"])
    texts = "\t".join([more, reads[0], reads[1] + reads[2]])
    tshark = cast(Tshark, Tap(entry(kind, own + texts.encode())))
    with Dissection(tshark, [Portion(Path("a"))], ["sis.status"]) as reading:
        (found,) = reading.packets()
    assert (found.number, found.epoch_ns, found.uncertainty_s, found.characters) == (
        9,
        100_000_000_005,
        None,
        b"\2\x1f",
    )
    assert (found.since_s, found.intervals_s, found.interface, found.type) == (0.5, [0.001], "COM3", FRAME)
    one, other = found.telegrams
    assert [access.value for access in one.accesses] == ["one"]
    assert [access.value for access in other.accesses] == ["two", "three"]
    assert [(access.parameter.port, access.value) for access in found.accesses] == [
        ("COM3", value) for value in ("one", "two", "three")
    ]
    assert (one.talker, one.columns["sis.status"], one.columns["sis.talker"]) == (3, "0x00", "3")
    assert (other.talker, other.columns["sis.status"], other.columns["sis.talker"]) == (4, "0x01", "4")
    times = [(one.silence, one.reaction, one.pause, one.cycle) for one in found.telegrams]
    assert times[0] == ((0.4, None, None), (0.01, None, None), (0.003, None, None), None)
    assert times[1] == (None, (0.02, None, None), None, (0.1, None, None))
    assert [(one.load_percent, one.command_in, one.pause_position) for one in found.telegrams] == [
        (40.0, 8, 5),
        (None, None, None),
    ]


# -- Several captures ------------------------------------------------------------------------------------------------


KNOWN = "frame.number", "frame.time_epoch", "frame.time_relative", "sis.command_in", "sis.bus.load", "sis.start"
TAP = "frame.interface_name", "sertap.type", "sertap.event", "sertap.text"


def row(
    number: int, epoch_s: float, relative_s: float, command_in: object = "", load: object = "", **more: object
) -> dict[str, object]:
    """Return a telegram, or what else the tap has written."""
    said = zip(KNOWN, (number, epoch_s, relative_s, command_in, load, "" if more else "0x02"), strict=True)
    return dict(said) | {f"sertap.{name}": value for name, value in more.items()}


def dissection(
    captures: Mapping[str, Sequence[Mapping[str, object]]],
    error: str = "",
    told: int = 0,
    known: Collection[str] = (*KNOWN, *TAP),
    **more: Any,
) -> Dissection:
    parts = [Portion(Path(name), told, begins=[Begin(told + 1, Path(name), 1)]) for name in captures]
    return Dissection(cast(Tshark, Printing(captures, known, error)), parts, **more)


TWO = {
    "a": [row(1, 100, 0), row(2, 101, 1, 1, 40.0)],
    "b": [row(1, 200, 0, load=100.0), row(2, 200.96875, 0.96875, 1, 90.0), row(3, 201, 1, load=30.0)],
}


def test_packets_of_several_captures_count_on_and_so_do_their_seconds() -> None:
    with dissection(TWO) as reading:
        packets = list(reading.packets())
        assert [(one.number, one.time_s) for one in packets] == [(1, 0), (2, 1), (3, 100), (4, 100.96875), (5, 101)]
        commands = [one.telegrams[0].command_in for one in packets]
        assert commands == [None, 1, None, 3, None]
        # In its first second, the load is of less than a second.
        assert [one.telegrams[0].load_percent for one in packets] == [None, 40.0, None, None, 30.0]
        again = [(one.number, one.time_s) for one in reading.again([Span(1, 1), Span(100.96875, 101)])]
        assert again == [(2, 1), (4, 100.96875), (5, 101)]
        assert "sis.talker" in reading.missing and "sis.start" not in reading.missing
    with dissection(TWO, keeps=False) as reading:
        assert list(reading.packets()) and not list(reading.again([Span(0, 1000)]))


@pytest.mark.parametrize("span", [Span(0, 1), Span(5, 6)])
def test_what_is_kept_is_found_where_times_are_out_of_order(span: Span) -> None:
    with Kept() as kept:
        for time_s in (5, 1, 3):
            kept.put(time_s, str(time_s))
        assert [*kept.rows([span])] == ["5", "1", "3"]
        assert [*kept.rows([Span(6, 7)])] == [*kept.rows([Span(-1, 0)])] == []


def test_of_much_only_what_is_near_is_read_again() -> None:
    with Kept() as kept:
        for number in range(1501):
            kept.put(number, number)
        assert [*kept.rows([Span(700, 701), Span(1500, 1501)])] == [*range(500, 1000), 1500]


def test_each_packet_has_its_place_in_its_own_capture() -> None:
    with dissection(TWO) as reading:
        places = [reading.place(one) for one in reading.packets()]
    assert [(path.name, number) for path, number in places] == [("a", 1), ("a", 2), ("b", 1), ("b", 2), ("b", 3)]


def test_what_was_told_before_a_file_has_no_number() -> None:
    """What the second is told came before its own begin, so its own begins after a second."""
    told = row(1, 100, 0, type=EVENT, event=int(Event.TOLD_BEFORE))
    with dissection({"a": [told, row(2, 101, 1)], "b": [told, row(2, 201, 101), row(3, 202, 102)]}, told=1) as reading:
        packets = list(reading.packets())
        assert [(one.number, one.time_s) for one in packets] == [(1, 0), (2, 100), (3, 101)]
        places = [reading.place(one) for one in packets]
    assert [(path.name, number) for path, number in places] == [("a", 1), ("b", 1), ("b", 2)]


def test_what_came_before_a_time_only_teaches() -> None:
    with dissection(TWO, since_s=101) as reading:
        packets = [(one.time_s, one.is_before) for one in reading.packets()]
        assert packets == [(0, True), (0, False), (99, False), (99.96875, False), (100, False)]
        assert [one.number for one in reading.again([Span(-1, 1000)])] == [2, 3, 4, 5]


def test_what_a_file_begins_with_again_is_not_told_again() -> None:
    def begins(number: int, text: str = "a tap", event: Event = Event.CAPTURE_STARTED) -> dict[str, object]:
        return row(number, 100, 0, type=EVENT, event=int(event), text=text)

    told = begins(2, "", Event.TOLD_BEFORE)
    marker, limits = begins(2, "a marker", Event.MARKER), begins(2, "TzA", Event.LIMITS_TOLD)
    files = {
        "a": [begins(1), limits, marker],
        "b": [begins(1), limits, told, row(3, 101, 0)],
        "c": [begins(1, "other"), told],
        "d": [begins(1) | {"frame.interface_name": "COM4"}, told],  # an adapter that was plugged in meanwhile
        "e": [begins(1), row(2, 102, 0, type=BEFORE), begins(3, "TrS", Event.LIMITS_TOLD)],
    }
    with dissection(files) as reading:
        packets = list(reading.packets())
    assert [(one.text, one.is_again) for one in packets] == [
        ("a tap", False),
        ("TzA", False),
        ("a marker", False),
        ("", False),
        ("other", True),
        ("a tap", True),
        ("TrS", False),
    ]
    with dissection({"a": [begins(1)], "b": [begins(1)]}) as reading:  # two captures, each from its beginning
        assert len(list(reading.packets())) == 2


def test_a_file_of_a_recorder_is_kept_apart() -> None:
    started = {"sertap__event": str(int(Event.CAPTURE_STARTED)), "sertap__text": f"a tap{KEPT}late"}
    assert of(sertap__type=str(EVENT), **started).is_kept_apart
    assert not of(sertap__type=str(OTHER), **started).is_kept_apart
    assert not of(sertap__type=str(EVENT), **started | {"sertap__event": str(int(Event.MARKER))}).is_kept_apart
    assert not of(sertap__type=str(EVENT), **started | {"sertap__text": "a tap"}).is_kept_apart


def test_the_warnings_of_captures_that_are_cut() -> None:
    cut = 'tshark: The file "x" appears to have been cut short in the middle of a packet.'
    with dissection(TWO, cut) as reading:
        assert len(list(reading.packets())) == 5
        assert reading.warning == "; ".join(
            ["the capture appears to have been cut short in the middle of a packet."] * 2
        )


def test_where_tshark_fails_after_some_packets_they_are_told() -> None:
    with dissection({"a": []}, "tshark: Killed") as reading, pytest.raises(TsharkError, match="Killed"):
        list(reading.packets())
    with dissection({"a": [row(1, 100, 0)]}, "tshark: Killed") as reading:
        assert len(list(reading.packets())) == 1 and reading.warning == "Killed"


def test_without_a_dissector_nothing_is_told() -> None:
    with dissection({"a": []}, known=TAP) as reading, pytest.raises(TsharkError, match="sistap install"):
        list(reading.packets())


def test_preferences_are_asked_for() -> None:
    printing = Printing({"a": []}, KNOWN)
    with Dissection(cast(Tshark, printing), [Portion(Path("a"))], preferences={"sis.tza_ms": 2}) as reading:
        assert list(reading.packets()) == []
    assert printing.asked[:5] == ["-r", "a", "-2", "-o", "sis.tza_ms:2"]
