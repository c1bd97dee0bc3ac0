# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap parameters` of a capture whose every telegram is written down in accesses.txt."""

from __future__ import annotations

import csv
import io
import os
import shutil
from pathlib import Path

import pytest
from commands import refused, run
from report_capture import Sent, write

from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import MOST, AccessPlace, Listing
from sistap.dissected.captures import reading
from sistap.tap.files import pcapng
from sistap.tap.sis.telegram import build

HOUSE = Path(__file__).parent.parent.parent
CAPTURE = HOUSE / "test-captures" / "accesses.pcapng"
OTHER = CAPTURE.with_name("values.pcapng")

LIST = """\
Station  Device  Parameter  Name                             Unit  Reads  Writes  Errors  First        \
Last         Least     Greatest  Written by  In packet
3        5       P-0-0012   Limit                            Nm        2       3       2  5.00 Nm      \
-3.00 Nm     -3.00 Nm  7.50 Nm           17         18
3        5       S-0-0047   Position command value                     1       1       0  01 02 03 04  \
05 02 03 04                              16         28
3        5       S-0-0048   Additive position command value            1       1       0               \
                                         16         34
3        6       S-0-0047   Position command value                     0       1       0  11 22 33 44  \
11 22 33 44                              16         32
4/8      0       P-0-0012                                              0       1       0  01 00        \
01 00                                    16         38
4/8      0       S-0-0047   Position command value                     0       0       1
"""

# Packet 14 writes what is there already; in packet 34 it is a part of a list.
CHANGES = [
    ("16", "3", "5", "P-0-0012", "Limit", "Nm", "5.00 Nm", "7.50 Nm", "16"),
    ("17", "3", "5", "P-0-0012", "Limit", "Nm", "7.50 Nm", "-3.00 Nm", "18"),
    ("16", "3", "5", "S-0-0047", "Position command value", "", "01 02 03 04", "05 02 03 04", "28"),
    ("16", "3", "6", "S-0-0047", "Position command value", "", "", "11 22 33 44", "32"),
    ("16", "3", "5", "S-0-0048", "Additive position command value", "", "", "", "34"),
    ("16", "4/8", "0", "P-0-0012", "", "", "", "01 00", "38"),
]
COLUMNS = ("master", "station", "device", "parameter", "name", "unit", "from", "to", "packet")


@pytest.mark.usefixtures("dissector")
def test_the_list(tmp_path: Path) -> None:
    done = run(tmp_path, "parameters", CAPTURE)
    assert (done.returncode, done.stderr, done.stdout) == (0, "", LIST)


@pytest.mark.usefixtures("dissector")
def test_changes(tmp_path: Path) -> None:
    done = run(tmp_path, "parameters", "--changes", "--csv", CAPTURE)
    rows = list(csv.DictReader(done.stdout.splitlines()))
    assert [tuple(row[name] for name in COLUMNS) for row in rows] == CHANGES
    assert {row["file"] for row in rows} == {"accesses.pcapng"}


def test_changes_as_text(tmp_path: Path) -> None:
    lines = run(tmp_path, "parameters", "--changes", CAPTURE, TZ="CET-1").stdout.splitlines()
    assert len(lines) == len(CHANGES)
    assert lines[1].endswith("+01:00  17 -> 3 device 5  P-0-0012 (Limit)  7.50 Nm -> -3.00 Nm  packet 18")
    assert lines[4].endswith(
        "  16 -> 3 device 5  S-0-0048 (Additive position command value)  unknown -> unknown  packet 34"
    )


def test_the_list_as_csv(tmp_path: Path) -> None:
    done = run(tmp_path, "parameters", "--csv", CAPTURE, "-o", "x.csv")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    with (tmp_path / "x.csv").open(newline="") as file:
        first = next(csv.DictReader(file))
    assert first.pop("written_at").startswith("2023-11-1")
    assert first == {
        **{"port": "accesses", "station": "3", "device": "5", "parameter": "P-0-0012", "name": "Limit", "unit": "Nm"},
        **{"minimum": "-10.00 Nm", "maximum": "10.00 Nm", "reads": "2", "writes": "3", "errors": "2"},
        **{"first": "5.00 Nm", "last": "-3.00 Nm", "least": "-3.0", "greatest": "7.5"},
        **{"written_by": "17", "written_in_packet": "18", "written_in_file": "accesses.pcapng"},
        "bytes": "0",
    }


def test_all_values_in_a_wide_table(tmp_path: Path) -> None:
    """accesses.txt: 5.00 Nm is read and written, 7.50 Nm and -3.00 Nm are written, and the last is read."""
    done = run(tmp_path, "parameters", "--csv", "--wide", CAPTURE)
    head, *rows = list(csv.reader(done.stdout.splitlines()))
    assert (done.returncode, done.stderr) == (0, "")
    assert head[:2] == ["time", "3 device 5 P-0-0012 Limit (Nm)"]
    assert "4/8 device 0 P-0-0012" in head
    assert {len(row) for row in rows} == {len(head)}
    assert [row[1] for row in rows if row[1]] == ["5.0", "5.0", "7.5", "-3.0", "-3.0"]
    assert all(sum(cell != "" for cell in row) == 2 for row in rows), "a time and one value"


def test_wide_belongs_to_csv(tmp_path: Path) -> None:
    refused(run(tmp_path, "parameters", "--wide", CAPTURE), 2, "--wide belongs to --csv, without --changes")


@pytest.mark.thorough
def an_hour_later(capture: Path, path: Path) -> Path:
    """Write a capture in which the same happens again."""
    packets = list(reading.packets(capture))
    blocks = [pcapng.section_header("test", ""), pcapng.block(pcapng.INTERFACE_DESCRIPTION, packets[0].interface)]
    blocks += [pcapng.enhanced_packet(0, (one.time_ns or 0) + 3600 * 10**9, one.data) for one in packets]
    path.write_bytes(b"".join(blocks))
    return path


def test_several_captures_go_on(tmp_path: Path) -> None:
    """In the second, the value of the first is known; counts are those of both."""
    again = an_hour_later(CAPTURE, tmp_path / "again.pcapng")
    rows = list(csv.DictReader(run(tmp_path, "parameters", "--changes", "--csv", CAPTURE, again).stdout.splitlines()))
    second = {(row["device"], row["parameter"], row["packet"]): row["from"] for row in rows[len(CHANGES) :]}
    assert second == {
        # read as 5.00 before
        ("5", "P-0-0012", "16"): "5.00 Nm",
        ("5", "P-0-0012", "18"): "7.50 Nm",
        ("5", "S-0-0047", "28"): "01 02 03 04",
        ("5", "S-0-0048", "34"): "",
    }, "what was written already is no change"
    table = run(tmp_path, "parameters", CAPTURE, again).stdout.splitlines()
    assert table[0].endswith("In packet  File")
    assert table[1].split()[5:8] == ["4", "6", "4"]
    assert table[1].endswith("18  again.pcapng")


def test_ports_are_told_apart(tmp_path: Path) -> None:
    lines = run(tmp_path, "parameters", CAPTURE, OTHER).stdout.splitlines()
    assert lines[0].startswith("Port ")
    assert {line.split()[0] for line in lines[1:]} == {"accesses", "values"}


def test_a_capture_that_is_cut(tmp_path: Path) -> None:
    cut = tmp_path / "cut.pcapng"
    cut.write_bytes(OTHER.read_bytes()[:-1000])
    done = run(tmp_path, "parameters", "cut.pcapng", CAPTURE)
    assert done.returncode == 0
    assert done.stderr.count("\n") == 1
    assert "cut.pcapng: only what comes before the damage" in done.stderr
    assert "accesses.pcapng" in done.stdout, "the next one is read"


@pytest.mark.thorough
def test_what_cannot_be_read_or_written(tmp_path: Path, full: Path) -> None:
    (tmp_path / "junk").write_bytes(b"this is no capture at all, just a text\n" * 9)
    refused(run(tmp_path, "parameters", "junk"), 2, "junk is not a capture")
    refused(run(tmp_path, "parameters", CAPTURE, "nothing"), 2, "cannot read nothing")
    os.mkfifo(tmp_path / "pipe")
    refused(run(tmp_path, "parameters", "pipe"), 2, "pipe is not a file")
    shutil.copy(CAPTURE, tmp_path / "x.pcapng")
    refused(run(tmp_path, "parameters", "x.pcapng", "-o", "x.pcapng"), 2, "is the capture itself")
    refused(run(tmp_path, "parameters", CAPTURE, "-o", full), 1, "/dev/full", "No space left")
    (tmp_path / "none").mkdir()
    refused(run(tmp_path, "parameters", CAPTURE, WIRESHARK_PLUGIN_DIR=str(tmp_path / "none")), 1, "sistap install")


def test_nothing_in_it(tmp_path: Path) -> None:
    done = run(tmp_path, "parameters", CAPTURE.with_name("phases.pcapng"))
    assert (done.returncode, done.stdout) == (0, "")
    assert done.stderr == "sistap: no parameter was read or written\n"


PLACE = AccessPlace("file", 1, 0.0)
WRITTEN = Access(Parameter("", "3", 5, "S-0-0030"), True, 16, "", "01", None, "01", "", "", "", "")


def test_after_a_part_was_written_the_value_is_unknown() -> None:
    listing = Listing()
    part = WRITTEN._replace(value="", data=None)
    changes = [listing.add(PLACE, access) for access in (WRITTEN, WRITTEN, part, WRITTEN)]
    assert [change and change.before for change in changes] == [None, None, "01", None]
    assert changes[1] is None
    assert changes[3]


def test_a_change_that_the_text_does_not_show() -> None:
    """A long list is cut in the text; its bytes are compared."""
    listing = Listing()
    assert listing.add(PLACE, WRITTEN)
    assert listing.add(PLACE, WRITTEN._replace(data="02"))


def test_memory_is_bounded() -> None:
    listing = Listing()
    for number in range(MOST + 2):
        listing.add(PLACE, WRITTEN._replace(parameter=WRITTEN.parameter._replace(ident=f"S-0-{number}")))
    assert len(listing) == MOST
    assert listing.left_out == 2


# Names and units of a drive, in Latin-1, and how they are shown: plugin/parameters/text.c, then what nobody sees.
SHOWN = {
    b"a\\b": "a\\b",
    b"Flow \\x": "Flow \\x",
    b"\\": "\\",
    b"\\\\": "\\\\",
    b"\\u0041\\n": "\\u0041\\n",
    b'"now", {}%s&<b>\'': '"now", {}%s&<b>\'',
    b"\t\n\r\0\x1f\x7f": "\u2409\u240a\u240d\u2400\u241f\u2421",
    b"\x85\x9b\xa0\xad\xe4\xff": "<85><9b>\\xa0<ad>\xe4\xff",
}


@pytest.mark.attack(
    "a drive whose names have backslashes, quotes, control characters",
    "backslashes and quotes as they are, control characters as visible ones",
)
@pytest.mark.usefixtures("dissector")
def test_every_name_that_a_drive_can_have(tmp_path: Path) -> None:
    """Name and unit of P-0-0000 and so on, then its value."""
    sent = []
    for number, name in enumerate(SHOWN):
        for control, data in ((0x14, name), (0x24, name), (0x3C, b"\5\0")):
            sent.append(Sent(build(0x10, 16, 3, bytes([control, 5, 0, number, 0x80]))))
            sent.append(Sent(build(0x10, 16, 3, bytes([0, control, 5]) + data, reaction=True)))
    capture = write(tmp_path / "names.pcapng", sent)
    done = run(tmp_path, "parameters", capture, "--csv")
    assert (done.returncode, done.stderr) == (0, "")
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    assert [(row["name"], row["unit"]) for row in rows] == [(text, text) for text in SHOWN.values()]
    other = write(tmp_path / "other.pcapng", sent[2:])
    for done in (
        run(tmp_path, "report", capture, "--format", "json", "-o", "-"),
        run(tmp_path, "compare", capture, other),
    ):
        assert (done.returncode, done.stderr) == (0, "")
