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
from sistap.tap.sis.telegram import build

CAPTURE = Path(__file__).parent / "statistics.pcapng"


def tree(text: str) -> list[tuple[str, int]]:
    """Read the counts of a statistics tree in its order, names as they are indented less one."""
    counts = re.findall(r"^( *)(\S.*?) {2,}(\d+) {2,}", text, re.MULTILINE)
    return [(indent + name, int(count)) for indent, name, count in counts]


PAGE = (CAPTURE.parents[1] / "plugin" / "docs" / "statistics.md").read_text("utf-8")
TITLES = {
    "conv,sis": "SIS Conversations",
    "endpoints,sis": "SIS Endpoints",
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
            (" By station", 11),
            ("  Station 16", 6),
            ("   Longest interval (us)", 6),
            ("   TzA exceeded", 1),
            ("   Silences above 200 ms", 1),
            ("   Characters with line errors", 1),
            ("  Station 3", 4),
            ("   Longest interval (us)", 4),
            ("   Cycles above 100 ms", 1),
            ("  Station 4", 1),
            ("   Longest interval (us)", 1),
            ("   Repeats", 1),
            ("   Unanswered", 1),
            (" Reactions by status", 5),
            ("  Transmission error-free", 4),
            ("  Phase switching error", 1),
            (" Errors", 1),
            ("  0xd007 Phase switch not allowed while the master axis turns", 1),
            (" Damaged", 1),
        ]
    )


def test_longest_intervals(statistics: dict[str, str]) -> None:
    """Average, least and greatest of the telegrams: 12 ms once, and 1.146 ms else."""
    found = re.findall(
        r"^   Longest interval \(us\) +\d+ +([\d.]+) +(\d+) +(\d+)", statistics["sis,tree"], re.MULTILINE
    )
    assert sorted(found) == [("1146.00", "1146", "1146"), ("1146.00", "1146", "1146"), ("2955.00", "1146", "12000")]


def silences(tshark: Tshark, capture: Path) -> int:
    return sum(
        count for name, count in tree(tshark.output("-q", "-z", "sis,tree", "-r", str(capture))) if "Silences" in name
    )


def test_silences_longer_than_an_interval_can_be(tshark: Tshark, tmp_path: Path) -> None:
    """300 s before packet 2; at least 4.29 s in packet 7, and before the only telegram of another file; 12 s by the
    times of two packets, in a file of another program that does not flag the largest number.
    """
    assert silences(tshark, CAPTURE.with_name("timing-silences.pcapng")) == 7
    later = tmp_path / "later.txt"
    lines = CAPTURE.with_name("timing-silences.txt").read_text().splitlines()
    later.write_text(next(line for line in lines if line.startswith("record")))
    later.with_suffix(".pcapng").write_bytes(Scenario(later).capture())
    assert silences(tshark, later.with_suffix(".pcapng")) == 1
    later.write_text("command 16>3 12\nsilence 4294.967295\nclock 7705.032705\nreaction 16>3 12 00 04")
    later.with_suffix(".pcapng").write_bytes(Scenario(later).capture())
    assert silences(tshark, later.with_suffix(".pcapng")) == 1


@pytest.mark.parametrize(("first", "exact"), [(1, 0), (6, 4)])
def test_intervals_without_exact_times(first: int, exact: int, tshark: Tshark, tmp_path: Path) -> None:
    """All eight characters of a telegram in one read, or the last three: then four intervals of 1.146 ms come before,
    and one that is neither.
    """
    text = "command 16>3 12\n" + "".join(f"flag {n} 0x01\n" for n in range(first + 1, 9))
    (tmp_path / "read.txt").write_text(text)
    (tmp_path / "read.pcapng").write_bytes(Scenario(tmp_path / "read.txt").capture())
    counts = dict(tree(tshark.output("-q", "-z", "sertap,tree", "-r", str(tmp_path / "read.pcapng"))))
    assert counts["Characters"] == 8 and counts[" In the same read as the one before"] == 8 - first
    assert counts["Interval inside a frame (us)"] == counts[" 1000-1999"] == exact


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


def test_a_command_without_a_reaction_counts_for_its_own_station(tshark: Tshark, tmp_path: Path) -> None:
    """The next one went to another."""
    (tmp_path / "none.txt").write_text("command 16>3 12\ncommand 16>4 12\nreaction 16>4 12 00 02\n")
    (tmp_path / "none.pcapng").write_bytes(Scenario(tmp_path / "none.txt").capture())
    found = tree(tshark.output("-q", "-z", "sis,tree", "-r", str(tmp_path / "none.pcapng")))
    place = found.index(("   Unanswered", 1))
    assert next(name for name, _ in reversed(found[:place]) if name.startswith("  Station")) == "  Station 3"


def test_services_have_the_names_of_the_edition(tshark: Tshark, tmp_path: Path) -> None:
    """0xE0 to 0xEF are DISC in IF02, and reserved in ECODRIVE03."""
    (tmp_path / "disc.txt").write_text("command 16>3 E3 01\n")
    (tmp_path / "disc.pcapng").write_bytes(Scenario(tmp_path / "disc.txt").capture())
    command = ("-q", "-z", "sis,tree", "-r", str(tmp_path / "disc.pcapng"))
    assert ("  DISC service 0xe3", 1) in tree(tshark.output(*command))
    assert ("  Reserved service 0xe3", 1) in tree(tshark.output(*command, "-o", "sis.edition:ECODRIVE03"))
