# SPDX-License-Identifier: GPL-2.0-or-later
"""What `sistap parameters` writes of accesses: the list, a wide table, and what differs from a backup."""

from __future__ import annotations

from typing import Any

import pytest
from machines import LAPTOP, access, undescribed

from sistap.commands.parameters import against, wide
from sistap.commands.parameters.backup import Drive, Saved
from sistap.commands.parameters.reading import FoundAccess
from sistap.commands.parameters.writing import list_as_csv, list_as_text, user_table
from sistap.dissected.accesses import listing
from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import AccessPlace, Listing
from sistap.dissected.telegrams.attribute import Attribute, Format
from sistap.dissected.telegrams.values import encoded
from sistap.tap.terminal.exits import Refusal

SPEED = "S-0-0040"
RPM = Attribute.of(4, Format.SIGNED, more=4 << 24)  # four decimal places, as machines.access() writes it


def listed(*accesses: Access, file: str = "a") -> Listing:
    made = Listing()
    for packet, one in enumerate(accesses, 1):
        made.add(AccessPlace(file, packet, 0.0), one)
    return made


def found(*accesses: Access) -> list[FoundAccess]:
    return [FoundAccess(AccessPlace("a", packet, 1.5 * packet), one) for packet, one in enumerate(accesses, 1)]


READS = access(3, SPEED, 7.0), access(3, SPEED, 5.0), access(3, SPEED, 9.0, is_write=True, master=LAPTOP)


def test_a_row_of_the_list() -> None:
    """PLC writes 8, the laptop 9; what is refused is no write, and no value."""
    refused = access(3, SPEED, "", error="0x7002", is_write=True)
    heads, row = list_as_text(listed(access(3, SPEED, 8.0, is_write=True), *READS, refused), several_files=False)
    words = ["3", "4", SPEED, "rpm", "2", "2", "1", "8.0 rpm", "9.0 rpm", "5.0 rpm", "9.0 rpm", "127", "4"]
    assert [word.strip() for word in row.split("  ") if word.strip()] == words
    assert not {"Port", "File", "Bytes"} & set(heads.split())
    assert [*list_as_text(listed(), several_files=False)] == []


def test_after_a_write_of_a_part_the_value_is_not_known() -> None:
    """Of a list, say: a segment was written."""
    made = Listing()
    read, write = access(3, SPEED, 7.0), access(3, SPEED, 7.0, is_write=True)
    part = write._replace(data=None, value="a part")
    changes = [made.add(AccessPlace("a", packet, 0.0), one) for packet, one in enumerate((read, write, part, write), 1)]
    assert [change and change.before for change in changes] == [None, None, "7.0 rpm", None]
    assert [change is not None for change in changes] == [False, False, True, True]


def test_the_greatest_of_several() -> None:
    (one,) = listed(*(access(3, SPEED, number) for number in (1.0, 9.0, 5.0)))
    assert one.greatest and one.greatest.number == 9


@pytest.mark.parametrize("other", [0.5, -0.5])
def test_zero_may_be_the_least_or_the_greatest(other: float) -> None:
    (one,) = listed(access(3, SPEED, 0.0), access(3, SPEED, other))
    assert one.least and one.greatest and (one.least.number, one.greatest.number) == (min(other, 0), max(other, 0))


def test_a_text_that_is_written_again_is_no_change() -> None:
    """Of the ASCII protocol: it has no bytes."""
    made = Listing()
    texts = [access(3, SPEED, text, is_write=True, master=None) for text in ("on", "on", "off")]
    changes = [made.add(AccessPlace("a", packet, 0.0), one) for packet, one in enumerate(texts, 1)]
    assert [change and change.before for change in changes] == [None, None, "on"]
    assert [change is not None for change in changes] == [True, False, True]


def test_a_long_list_is_compared_to_its_last_byte() -> None:
    made = Listing()
    lists = [undescribed(3, SPEED, bytes(40) + bytes([last]), is_write=True) for last in (1, 1, 2)]
    changes = [made.add(AccessPlace("a", packet, 0.0), one) for packet, one in enumerate(lists, 1)]
    assert [change is not None for change in changes] == [True, False, True]


def test_an_empty_list_is_a_value() -> None:
    made = Listing()
    lists = [undescribed(3, SPEED, data, is_write=True) for data in (b"\1", b"", b"", b"\2")]
    changes = [made.add(AccessPlace("a", packet, 0.0), one) for packet, one in enumerate(lists, 1)]
    assert [change and change.before for change in changes] == [None, "01", None, ""]
    assert changes[2] is None and changes[3]


@pytest.mark.parametrize("number", [1.0, 2.0])
def test_a_value_that_was_read_once_is_the_least_and_the_greatest(number: float) -> None:
    (one,) = listed(access(3, SPEED, number))
    assert one.least and one.greatest and (one.least.number, one.greatest.number) == (number, number)


def test_name_unit_and_limits_are_those_told_last() -> None:
    names = "name", "unit", "minimum", "maximum"
    told: list[dict[str, Any]] = [dict(zip(names, texts.split(), strict=True)) for texts in ("a b c d", "A B C D")]
    (one,) = listed(*(access(3, SPEED, 1.0, **said) for said in (*told, dict.fromkeys(names, ""))))
    assert [getattr(one, name) for name in names] == [*"ABCD"]


def test_who_asked() -> None:
    assert [access(3, SPEED, 1.0, master=master).by for master in (0, 127, None)] == ["0", "127", "ASCII"]


@pytest.mark.parametrize(("value", "plain"), [(0.0, 0.0), ("on", "on"), ("", None)])
def test_a_value_for_programs_has_no_unit(value: str | float, plain: str | float | None) -> None:
    assert access(3, SPEED, value).plain == plain


def test_accesses_that_do_not_fit_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(listing, "MOST", 1)
    made = listed(access(3, SPEED, 1.0), access(4, SPEED, 1.0), access(4, SPEED, 1.0))
    assert (len(made), made.left_out) == (1, 2)


def test_columns_that_only_some_need() -> None:
    assert next(list_as_text(listed(*READS), several_files=True)).split()[-1] == "File"
    ports = listed(*READS, access(3, SPEED, 1.0, port="COM3"))
    assert next(list_as_text(ports, several_files=False)).startswith("Port")
    raw = undescribed(3, SPEED, b"\1\0\0\0")
    heads, *rows = list_as_text(listed(raw, raw, *READS, access(4, SPEED, 1.0)), several_files=False)
    at = heads.index("Bytes")
    assert [row[at : at + 5].strip() for row in rows] == ["2", ""]
    assert "Bytes" not in next(list_as_text(listed(raw, access(4, SPEED, 1.0)), several_files=False))


def test_the_list_for_programs() -> None:
    heads, row = list_as_csv(listed(*READS))
    said = dict(zip(heads.split(","), row.split(","), strict=True))
    assert (said["reads"], said["writes"], said["errors"], said["least"], said["greatest"]) == (
        "2",
        "1",
        "0",
        "5.0",
        "9.0",
    )
    assert (said["written_by"], said["written_in_packet"], said["written_in_file"]) == ("127", "3", "a")


def test_a_wide_table_has_a_line_for_each_time() -> None:
    other = access(4, "P-0-0012", "on")
    both = FoundAccess(AccessPlace("a", 1, 1.5), other)
    table = [*wide.lines([both, *found(*READS), FoundAccess(AccessPlace("a", 9, 4.5), other)])]
    assert table[0] == "time,4 device 4 P-0-0012,3 device 4 S-0-0040 (rpm)"
    assert [line.split(",", 1)[1] for line in table[1:]] == ["on,7.0", ",5.0", "on,9.0"]
    assert [*wide.lines(found(access(3, SPEED, "", error="0x7002")))] == []
    ports = [*wide.lines(found(access(3, SPEED, 1.0, port="COM3"), access(3, SPEED, 1.0, port="COM4")))]
    assert ports[0] == "time,COM3 3 device 4 S-0-0040 (rpm),COM4 3 device 4 S-0-0040 (rpm)"


def saved(data: bytes | None, attribute: Attribute = RPM) -> list[tuple[str, Drive]]:
    one = Saved(SPEED, "Speed", attribute, "rpm", "-1", "1", ["7"], data)
    return [("3", Drive("Axis", "DKC", "3", [one]))]


SEVEN = (70_000).to_bytes(4, "little")


@pytest.mark.parametrize(
    ("accesses", "line"),
    [
        (READS, "3 device 4  S-0-0040 (Speed)  7.0000 rpm -> 9.0000 rpm  written by 127 in packet 3"),
        (READS[:2], "3 device 4  S-0-0040 (Speed)  7.0000 rpm -> 5.0000 rpm  read in packet 2"),
        (READS[:1], ""),
        ((READS[2], READS[0]), ""),
        ((READS[2], READS[1]), "3 device 4  S-0-0040 (Speed)  7.0000 rpm -> 5.0000 rpm  written by 127 in packet 1"),
        ((READS[0], access(3, SPEED, "", error="0x7002")), ""),
    ],
)
def test_the_last_value_is_beside_the_backup(accesses: tuple[Access, ...], line: str) -> None:
    told = [*against.lines(saved(SEVEN), found(*accesses))]
    assert told == [*filter(None, [line]), f"{int(bool(line))} of 1 parameters of station 3 differ from the backup"]


@pytest.mark.parametrize(
    ("backup", "accesses", "why"),
    [
        (saved(SEVEN), (), "the capture has no value of a parameter"),
        (saved(None), READS, "no value of a parameter that the backup has and a master can write"),
        (saved(SEVEN, RPM._replace(bits=RPM.bits | 0x7000_0000)), READS, "that the backup has and a master can write"),
        (saved(SEVEN), (access(5, SPEED, 1.0), access(10, SPEED, 1.0)), "has values of stations 5, 10: choose with"),
    ],
)
def test_nothing_compared_is_said(backup: list[tuple[str, Drive]], accesses: tuple[Access, ...], why: str) -> None:
    with pytest.raises(Refusal, match=why):
        list(against.lines(backup, found(*accesses)))


def test_a_parameter_set_is_in_the_number_of_the_table() -> None:
    ((_, drive),) = saved(SEVEN)
    other = drive._replace(parameters=[drive.parameters[0]._replace(ident="P-2-0012", name='"n\\')])
    row = '"S","0040","Speed","rpm","0x04220001","-1.0000 rpm","1.0000 rpm","3"'
    assert [*user_table(drive, "3")] == [row]
    assert next(user_table(other, "")).startswith('"P","2-0012","\\x22n\\x5c",')


@pytest.mark.parametrize(("fraction", "ns"), [("", 0), (".5", 500_000_000), (".000000001", 1)])
def test_a_time_may_have_a_fraction(fraction: str, ns: int) -> None:
    """Four bytes of seconds since 1970, four of nanoseconds."""
    time = encoded(Attribute.of(8, Format.TIME), f"1970-01-02T00:00:01{fraction}Z")
    assert time == (86_401).to_bytes(4, "little") + ns.to_bytes(4, "little")


def test_parameters_are_sorted_by_port_and_numbers() -> None:
    own = ("b", "10", 4), ("b", "3/2/8", 4), ("b", "3", 10), ("b", "3", 9), ("b", "5", 4), ("a", "99", 4)
    keys = [Parameter(*one, ident) for one in own for ident in ("S-0-0041", "S-0-0040")]
    made = listed(*(access(3, SPEED, 1.0)._replace(parameter=key) for key in keys))
    assert [one.parameter for one in made] == [keys[place] for place in (11, 10, 7, 6, 5, 4, 3, 2, 9, 8, 1, 0)]
