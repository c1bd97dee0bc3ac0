# SPDX-License-Identifier: GPL-2.0-or-later
"""What the statistics say of statistics.txt, counted by hand.

At 9600 8E1 a character takes 1.146 ms.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import bad_input
from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.record import Record, Type
from sistap.tap.sis.telegram import build

CAPTURE = Path(__file__).parent / "statistics.pcapng"


def table(text: str) -> dict[str, list[str]]:
    """Read a table of tshark: the cells of each row after its name."""
    rows = [[cell.strip() for cell in line.rstrip("|").split("|")] for line in text.splitlines() if "|" in line]
    return {row[0]: row[1:] for row in rows if row[0] not in ("Talker", "Station")}


def tree(text: str) -> list[tuple[str, int]]:
    """Read the counts of a statistics tree in its order, names as they are indented less one."""
    counts = re.findall(r"^( *)(\S.*?) {2,}(\d+) {2,}", text, re.MULTILINE)
    return [(indent + name, int(count)) for indent, name, count in counts]


PAGE = (CAPTURE.parents[1] / "plugin" / "docs" / "statistics.md").read_text("utf-8")
TITLES = {
    "conv,sis": "SIS Conversations",
    "endpoints,sis": "SIS Endpoints",
    "sis,bus": "SIS bus by station:",
    "sis,tza": "SIS intervals by talker (TzA):",
    "sis,parameters": "SIS parameters:",
    "sis,tree": "SIS telegrams:",
    "sertap,tree": "Serial tap: characters and intervals:",
    "rk512i,srt": "RK512I SRT Statistics:",
    "sis,srt": "SIS SRT Statistics:",
    "sisascii,srt": "SISASCII SRT Statistics:",
}


@pytest.fixture(scope="module")
def statistics(tshark: Tshark) -> dict[str, str]:
    """Return each table by its name, from one run of tshark."""
    wanted = [word for name in TITLES for word in ("-z", name)]
    printed = tshark.output("-q", *wanted, "-r", str(CAPTURE))
    parts = re.split(rf"^(?:SIS / )?({'|'.join(map(re.escape, TITLES.values()))})\n", printed, flags=re.MULTILINE)
    by_title = dict(zip(parts[1::2], parts[2::2], strict=True))
    return {name: by_title[title] for name, title in TITLES.items()}


def test_each_name_of_the_page_is_known(statistics: dict[str, str]) -> None:
    assert sorted(re.findall(r"^\| `(\S+)` \| \*", PAGE, re.MULTILINE)) == sorted(statistics)
    assert all("=====" in text for text in statistics.values())


def test_intervals_by_talker(statistics: dict[str, str]) -> None:
    # telegrams, characters, p50, p99, longest, exceeded, unresolved, in one read, then the histogram
    assert table(statistics["sis,tza"]) == {
        "All": "11 108 1.146 12.000 12.000 1 0 0 0 96 0 0 1 0 0".split(),
        "16": "6 54 1.146 12.000 12.000 1 0 0 0 47 0 0 1 0 0".split(),
        "3": "4 42 1.146 1.146 1.146 0 0 0 0 38 0 0 0 0 0".split(),
        "4": "1 12 1.146 1.146 1.146 0 0 0 0 11 0 0 0 0 0".split(),
    }


def test_bus_by_station(statistics: dict[str, str]) -> None:
    rows = table(statistics["sis,bus"])
    loads = {station: float(row.pop(8)) for station, row in rows.items()}
    # telegrams, repeats, unanswered, TzA, TrS, damaged, line errors, characters, longest silence, silences, cycles
    assert rows == {
        "All": "12 1 1 1 0 1 2 119 250.000 1 1".split(),
        "16": "6 0 0 1 0 0 1 54 250.000 1 0".split(),
        "3": "4 0 0 0 0 0 0 42 150.000 0 1".split(),
        "4": "1 1 1 0 0 0 0 12 25.000 0 0".split(),
    }
    # 119 characters; between them ten silences of 25 ms, one of 150, one of 250, and 12 ms in a telegram; each holds a
    # character's own time
    ms = 1.145833
    length = 119 * ms + 10 * (25 - ms) + (150 - ms) + (250 - ms) + (12 - ms)
    assert loads == {
        station: pytest.approx(100 * characters * ms / length, abs=0.06)
        for station, characters in {"All": 119, "16": 54, "3": 42, "4": 12}.items()
    }


def test_silences_longer_than_an_interval_can_be(tshark: Tshark, tmp_path: Path) -> None:
    """300 s before packet 2; at least 4.29 s in packet 7, and before the only telegram of another file; 12 s by the
    times of two packets, in a file of another program that does not flag the largest number.
    """
    silences = str(CAPTURE.with_name("timing-silences.pcapng"))
    assert table(tshark.output("-q", "-z", "sis,bus", "-r", silences))["All"][9:11] == ["300000.000", "7"]
    assert table(tshark.output("-q", "-z", "sis,tza", "-r", silences))["All"][3:5] == [">4294.967"] * 2
    later = tmp_path / "later.txt"
    lines = CAPTURE.with_name("timing-silences.txt").read_text().splitlines()
    later.write_text(next(line for line in lines if line.startswith("record")))
    later.with_suffix(".pcapng").write_bytes(Scenario(later).capture())
    rows = table(tshark.output("-q", "-z", "sis,bus", "-r", str(later.with_suffix(".pcapng"))))
    assert rows["All"][9:11] == [">4294.967", "1"]
    later.write_text("command 16>3 12\nsilence 4294.967295\nclock 7705.032705\nreaction 16>3 12 00 04")
    later.with_suffix(".pcapng").write_bytes(Scenario(later).capture())
    rows = table(tshark.output("-q", "-z", "sis,bus", "-r", str(later.with_suffix(".pcapng"))))
    assert rows["All"][9:11] == ["12000.000", "1"]


@pytest.mark.parametrize(("name", "title"), [("sis,tza", "Talker"), ("sis,bus", "Station")])
def test_the_first_title_leaves_room_for_the_arrow(statistics: dict[str, str], name: str, title: str) -> None:
    """Wireshark makes the column as wide as its title, and then draws the arrow over the end of it."""
    assert re.search(rf"^{title} {{4,}}\|", statistics[name], re.MULTILINE)


def test_service_response_times(statistics: dict[str, str]) -> None:
    rows = re.findall(
        r"^ +(\d+) +(\S.*?) {2,}(\d+) +([\d.]+) +([\d.]+) +([\d.]+) ", statistics["sis,srt"], re.MULTILINE
    )
    assert rows == [
        ("3", "Initialization of the SIS communication", "2", "0.025000", "0.025000", "0.025000"),
        ("18", "Read phase", "3", "0.025000", "0.150000", "0.066667"),
    ]


def test_tree(statistics: dict[str, str]) -> None:
    assert sorted(tree(statistics["sis,tree"])) == sorted(
        [
            ("Telegrams", 12),
            (" By service", 11),
            ("  Read phase", 7),
            ("   Command", 4),
            ("   Reaction", 3),
            ("  Initialization of the SIS communication", 4),
            ("   Command", 2),
            ("   Reaction", 2),
            (" By talker", 11),
            ("  16", 6),
            ("  3", 4),
            ("  4", 1),
            (" Reactions by status", 5),
            ("  Transmission error-free", 4),
            ("  Phase switching error", 1),
            (" Errors", 1),
            ("  0xd007 Phase switch not allowed while the master axis turns", 1),
            (" Damaged", 1),
        ]
    )


def test_a_filter(tshark: Tshark) -> None:
    rows = table(tshark.output("-q", "-z", "sis,tza,sis.talker == 4", "-r", str(CAPTURE)))
    assert set(rows) == {"All", "4"}


def intervals_of_one_read(tshark: Tshark, folder: Path, first: int) -> list[str]:
    """Return the row of a telegram of eight characters, of which those from this one on came in one read."""
    text = "command 16>3 12\n" + "".join(f"flag {n} 0x01\n" for n in range(first + 1, 9))
    (folder / "read.txt").write_text(text)
    (folder / "read.pcapng").write_bytes(Scenario(folder / "read.txt").capture())
    return table(tshark.output("-q", "-z", "sis,tza", "-r", str(folder / "read.pcapng")))["16"]


def test_intervals_without_exact_times(tshark: Tshark, tmp_path: Path) -> None:
    """All of a telegram in one read: there is nothing to make a quantile of."""
    row = intervals_of_one_read(tshark, tmp_path, first=1)
    assert row[:4] == ["1", "8", "", ""]
    assert row[4].startswith("<="), "an upper bound is no interval"
    assert row[7:] == "7 0 0 0 0 0 0 0".split()
    counts = dict(tree(tshark.output("-q", "-z", "sertap,tree", "-r", str(tmp_path / "read.pcapng"))))
    assert counts["Characters"] == 8 and counts[" In the same read as the one before"] == 7
    assert counts["Interval inside a frame (us)"] == 0


def test_the_interval_before_one_read(tshark: Tshark, tmp_path: Path) -> None:
    """The last three of eight: two intervals between them, four of 1.146 ms before, and one that is neither."""
    assert intervals_of_one_read(tshark, tmp_path, first=6)[7:] == "2 0 4 0 0 0 0 0".split()
    counts = dict(tree(tshark.output("-q", "-z", "sertap,tree", "-r", str(tmp_path / "read.pcapng"))))
    assert counts["Interval inside a frame (us)"] == counts[" 1000-1999"] == 4


def test_load_of_two_lines_is_their_mean(tshark: Tshark) -> None:
    """duplex.txt: 30 characters on one line, 32 on the other, five silences of 25 ms and a pause of 12 ms."""
    rows = table(tshark.output("-q", "-z", "sis,bus", "-r", str(CAPTURE.with_name("duplex.pcapng"))))
    ms = 1.145833
    length = 62 * ms + 5 * (25 - ms) + (12 - ms)
    for station, characters in {"16": 30, "3": 32, "All": 31}.items():
        assert float(rows[station][8]) == pytest.approx(100 * characters * ms / length, abs=0.06)


def test_files_read_as_one_are_no_more_lines(tshark: Tshark, tmp_path: Path) -> None:
    """Sections of a ring number their interfaces anew. The second time goes back, so the span is twice that of one."""
    twice = tmp_path / "twice.pcapng"
    for name in ("duplex.pcapng", "statistics.pcapng"):
        once = CAPTURE.with_name(name)
        twice.write_bytes(2 * once.read_bytes())
        load, load_of_both = (
            float(table(tshark.output("-q", "-z", "sis,bus", "-r", str(file)))["All"][8]) for file in (once, twice)
        )
        assert load_of_both == pytest.approx(load, rel=0.05)


def test_errors_inside_a_list_of_services_count(tshark: Tshark, tmp_path: Path) -> None:
    """A list of two readings, of which one has no such parameter (0x1001) and one is written too much (0x7003)."""
    read, written = bytes.fromhex("3C 03 00 24 00"), bytes.fromhex("3C 03 00 24 00 01 02 03 04 05")
    asked = bytes([len(read) + 1, 0x10]) + read + bytes([len(written) + 1, 0x1F]) + written
    answered = bytes.fromhex("01  06 10 01 3C 03 01 10  06 1F 01 3C 03 03 70")
    capture = tmp_path / "list.pcapng"
    bad_input.write(capture, [build(0x04, 16, 3, asked), build(0x04, 16, 3, answered, reaction=True)])
    counts = dict(tree(tshark.output("-q", "-z", "sis,tree", "-r", str(capture))))
    errors = {name.split()[0]: count for name, count in counts.items() if name.strip().startswith("0x")}
    assert errors == {"0x1001": 1, "0x7003": 1}


def test_services_have_the_names_of_the_edition(tshark: Tshark, tmp_path: Path) -> None:
    """0xE0 to 0xEF are DISC in IF02, and reserved in ECODRIVE03."""
    (tmp_path / "disc.txt").write_text("command 16>3 E3 01\n")
    (tmp_path / "disc.pcapng").write_bytes(Scenario(tmp_path / "disc.txt").capture())
    command = ("-q", "-z", "sis,tree", "-r", str(tmp_path / "disc.pcapng"))
    assert ("  DISC service 0xe3", 1) in tree(tshark.output(*command))
    assert ("  Reserved service 0xe3", 1) in tree(tshark.output(*command, "-o", "sis.edition:ECODRIVE03"))


# line, station, device, parameter, name, unit; reads, writes, errors; first, last, least, greatest, bytes; written by,
# where
ACCESSES = """
1 |3   |5 |P-0-0012 |Limit |Nm |2 |3 |2 |5.00 Nm     |-3.00 Nm    |-3.00 Nm |7.50 Nm |0 |17 |18
1 |3   |5 |S-0-0047 |Position command value |   |1 |1 |0 |01 02 03 04 |05 02 03 04 |         |        |2 |16 |28
1 |3   |6 |S-0-0047 |Position command value |   |0 |1 |0 |11 22 33 44 |11 22 33 44 |         |        |1 |16 |32
1 |3   |5 |S-0-0048 |Additive position command value |   |1 |1 |0 |       |            |         |        |0 |16 |34
1 |4/8 |0 |P-0-0012 | | |0 |1 |0 |01 00 |01 00 | | |1 |16 |38
1 |4/8 |0 |S-0-0047 |Position command value |   |0 |0 |1 |            |            |         |        |0 |  |
"""


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("|")]


def parameters(text: str) -> list[list[str]]:
    """Read the list of parameters, without its first row."""
    return [cells(line.rstrip("|")) for line in text.splitlines() if re.match(r"\d+ +\|", line)]


@pytest.mark.parametrize("passes", [[], ["-2"]], ids=["one_pass", "two_passes"])
def test_parameters(passes: list[str], tshark: Tshark) -> None:
    text = tshark.output("-q", *passes, "-z", "sis,parameters", "-r", str(CAPTURE.with_name("accesses.pcapng")))
    assert parameters(text) == [cells(line) for line in ACCESSES.strip().splitlines()]
    assert re.search(r"^All +(\| +){6}4 \| +7 \| +3 \|([^|]*\|){4} +4 \|", text, re.MULTILINE)


# One pass learns the attribute after the first values; the second pass knows it.
LATE = {
    (): "1|3|5|S-0-0040|Velocity feedback value 1||3|1|0|f4 01|60.0|25.00|60.0|2|16|4",
    ("-2",): "1|3|5|S-0-0040|Velocity feedback value 1|Nm|3|1|0|5.00 Nm|60.0 Nm|-10.00 Nm|60.0 Nm|0|16|4",
}


@pytest.mark.parametrize("passes", LATE, ids=["one_pass", "two_passes"])
def test_values_from_before_their_attribute(passes: tuple[str, ...], tshark: Tshark) -> None:
    """None is left out of least and greatest without a word."""
    text = tshark.output("-q", *passes, "-z", "sis,parameters", "-r", str(CAPTURE.with_name("accesses-late.pcapng")))
    never = "1|3|5|S-0-0047|Position command value||1|0|0|01 02 03 04|01 02 03 04|||1||"
    assert parameters(text) == [cells(LATE[passes]), cells(never)]


def test_parameters_with_a_filter(tshark: Tshark) -> None:
    """What was written is known, though its command does not pass the filter."""
    asked = "sis,parameters,frame.number == 18"
    text = tshark.output("-q", "-z", asked, "-r", str(CAPTURE.with_name("accesses.pcapng")))
    assert parameters(text) == [cells("1|3|5|P-0-0012|Limit|Nm|0|1|0" + "|-3.00 Nm" * 4 + "|0|17|18")]


def test_more_parameters_than_rows(tshark: Tshark, tmp_path: Path) -> None:
    """10000 rows: idents beyond them are counted in the first row only."""
    idents = [number.to_bytes(2, "little") for number in range(10_002)]
    telegrams = [
        build(0x10, 16, 3, (b"\0" if reaction else b"") + b"\x3c\x05" + (b"\x01\x00" if reaction else b"\0" + ident),
              reaction=reaction)
        for ident in idents
        for reaction in (False, True)
    ]  # fmt: skip
    bad_input.write(tmp_path / "many.pcapng", telegrams)
    text = tshark.output("-q", "-z", "sis,parameters", "-r", str(tmp_path / "many.pcapng"))
    assert len(parameters(text)) == 10_000
    assert re.search(r"^All +(\| +){3}\|more parameters than rows \| +\|10002 \| +0 \| +0 \|", text, re.MULTILINE)


def test_load_of_more_than_64_lines_is_their_mean(tshark: Tshark, tmp_path: Path) -> None:
    """Every line is busy from the first character to the last: a load of 100 %."""
    lines = 70
    settings = LineSettings(9600, 8, "E", 2)
    sent = build(0x12, 16, 3)
    intervals = [0] + [settings.character_ns] * (len(sent) - 1)
    time_ns = 1_700_000_000_000_000_000
    blocks = [pcapng.section_header("test", "")]
    for line in range(lines):
        blocks.append(pcapng.interface_description(pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, f"{line}")))
    for line in range(lines):
        flags = bytes([Flag.INTERVAL_UNKNOWN]) + bytes(len(sent) - 1)
        record = Record(time_ns, Type.FRAME, 0, settings, sent, intervals, flags, 0)
        blocks.append(pcapng.enhanced_packet(line, time_ns, pcapng.upper_pdu("sertap", record.pack())))
    capture = tmp_path / "lines.pcapng"
    capture.write_bytes(b"".join(blocks))
    assert table(tshark.output("-q", "-z", "sis,bus", "-r", str(capture)))["All"][8] == "100.0"
