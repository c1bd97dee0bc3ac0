# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap log`: a capture as a log, and back."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from commands import refused, run
from independent import records
from portable import NO_TSHARK, WINDOWS, posix
from report_capture import BUS, READ, Sent, write
from specification import TELEGRAMS

from sistap.tap.records.record import Type

CAPTURES = Path(__file__).parents[2] / "test-captures"
ZONE = "CET-1CEST,M3.5.0,M10.5.0/3"  # central Europe, with rules that need no file


def telegrams(path: Path) -> list[tuple[int, int, bytes]]:
    """Time in ns, line, and bytes of all frames of a capture."""
    return [(record.time_ns, record.line, record.data) for record in records(path) if record.type == Type.FRAME]


def test_a_log(tmp_path: Path) -> None:
    capture = write(
        tmp_path / "x.pcapng",
        [Sent(TELEGRAMS["8-20"]), Sent(TELEGRAMS["8-21"]), Sent(READ), Sent(READ), Sent(b"A03\r", type=Type.OTHER)],
    )
    done = run(tmp_path, "log", capture, TZ=ZONE)
    assert (done.returncode, done.stderr) == (0, "")
    read, indent = READ.hex(" ").upper(), " " * 36 + "^-- "
    # Each character takes 11 bits at 9600 Bd, the silence before each is 25 ms; 1,700,000,000 s are 22:13:20 UTC.
    assert done.stdout.splitlines() == [
        '^-- 2023-11-14 23:13:20.000000000+0100  Capture started: test <b>adapter</b> & "quotes"',
        "2023-11-14 23:13:20.025000000+0100  02 6C 00 00 00 92 00 00",
        f"{indent}0 -> 0  Command  Read phase (SYNAX)",
        "2023-11-14 23:13:20.058020831+0100  02 56 02 02 10 92 00 00 00 02",
        f"{indent}0 -> 0  Reaction  Read phase (SYNAX): phase 2 (parameter mode)  25.000 ms after the command",
        f"2023-11-14 23:13:20.093333328+0100  {read}",
        f"{indent}16 -> 3  Command  [no reaction]  Read parameter S-0-0040 (Velocity feedback value 1)",
        f"2023-11-14 23:13:20.132083324+0100  {read}",
        f"{indent}16 -> 3  Command  [repeat]  Read parameter S-0-0040 (Velocity feedback value 1)",
        "2023-11-14 23:13:20.170833320+0100  41 30 33 0D",
        f'{indent}4 other characters  41 30 33 0d  "A03\\r"',
    ]


def test_what_was_told_before_the_capture_is_not_traffic(tmp_path: Path) -> None:
    """It is told in words alone, so whoever reads the log does not count it."""
    assert run(tmp_path, "log", CAPTURES / "told-before.pcapng", "-o", "x.txt", TZ=ZONE).returncode == 0
    assert run(tmp_path, "annotate", "x.txt", "-w", "y.pcapng", TZ=ZONE).returncode == 0
    assert telegrams(tmp_path / "y.pcapng") == telegrams(CAPTURES / "told-before.pcapng")


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["specification", "statistics", "repeats", "duplex", "sequences", "phases-routed"])
def test_a_log_is_read_back_to_the_same_telegrams_and_times(tmp_path: Path, name: str) -> None:
    assert run(tmp_path, "log", CAPTURES / f"{name}.pcapng", "-o", "x.txt", TZ=ZONE).returncode == 0
    # Wherever the log is read: its times have their zone.
    assert run(tmp_path, "annotate", "x.txt", "-w", "y.pcapng", TZ="EST5").returncode == 0
    assert telegrams(tmp_path / "y.pcapng") == telegrams(CAPTURES / f"{name}.pcapng")


def test_a_capture_of_a_log_without_times_is_a_log_without_times(tmp_path: Path) -> None:
    (tmp_path / "x.txt").write_text("02 6C 00 00 00 92 00 00\n")
    assert run(tmp_path, "annotate", "x.txt", "-w", "x.pcapng").returncode == 0
    assert run(tmp_path, "log", "x.pcapng").stdout.splitlines() == [
        "^-- Capture started: made from x.txt by sistap annotate",
        "02 6C 00 00 00 92 00 00",
        "^-- 0 -> 0  Command  Read phase (SYNAX)",
    ]


@pytest.mark.thorough
def test_a_capture_that_is_cut_is_a_log_up_to_there(tmp_path: Path) -> None:
    capture = write(tmp_path / "x.pcapng", BUS)
    whole = run(tmp_path, "log", capture).stdout.splitlines()
    capture.write_bytes(capture.read_bytes()[:-40])
    done = run(tmp_path, "log", capture)
    assert done.returncode == 0
    assert done.stdout.splitlines() == whole[:-2]
    assert "cut short" in done.stderr
    assert done.stderr.count("\n") == 1


def test_telegrams_without_records(tmp_path: Path) -> None:
    """They have no direction."""
    bare = write(tmp_path / "x.pcapng", [Sent(TELEGRAMS["8-20"])], dissector="sis")
    lines = run(tmp_path, "log", bare, TZ="UTC0").stdout.splitlines()
    assert [line.partition("+0000  ")[2] for line in lines[::2]] == ["02 6C 00 00 00 92 00 00"]
    assert lines[1].endswith("^-- 0 -> 0  Command  Read phase (SYNAX)")


def test_messages_that_import_made(tmp_path: Path) -> None:
    """TX are the master's."""
    (tmp_path / "x.csv").write_text("1.5,M,0082 000C 0002\n1.75,S,0082 000C 0002\n")
    assert run(tmp_path, "import", "x.csv", "-w", "x.pcapng", "--dissector", "synaxpk").returncode == 0
    done = run(tmp_path, "log", "x.pcapng", TZ="UTC0")
    assert (done.returncode, done.stderr) == (0, "")
    indent = " " * 40 + "^-- "
    assert done.stdout.splitlines() == [
        "1970-01-01 00:00:01.500000000+0000  TX  00 82 00 0C 00 02",
        f"{indent}Master, format not defined, channel write",
        "1970-01-01 00:00:01.750000000+0000  RX  00 82 00 0C 00 02",
        f"{indent}Slave, format not defined, channel write",
    ]


def test_a_network(tmp_path: Path) -> None:
    """Each packet with its bytes, parts of telegrams too; TX goes to the server. What comes before is counted.

    So are the four of a connection in which nothing but Decode As finds a telegram.
    """
    done = run(tmp_path, "log", CAPTURES / "tcp-telnet.pcapng", TZ="UTC0")
    assert done.returncode == 0
    assert done.stderr.endswith("7 packets without SIS are not in the log\n")
    lines = done.stdout.splitlines()
    assert lines[10:14:2] == [
        "2023-11-14 22:13:20.200000000+0000  TX  02 D4 03 03 00 03 10 03 FF",
        "2023-11-14 22:13:20.225000000+0000  TX  FF 07 08 FF",
    ]
    assert lines[13].endswith("^-- 16 -> 3  Command  Set baud rate: 115200")
    assert lines[8] == "2023-11-14 22:13:20.175000000+0000  RX  02 C7 03 03 10 03 10 03 00 04 07"
    assert lines[9].endswith("^-- 3 -> 16  Reaction  Set baud rate  50.000 ms after the command")


def test_what_has_no_sis(tmp_path: Path) -> None:
    refused(run(tmp_path, "log", CAPTURES / "udp.pcapng"), 2, "6 packets without SIS", "Decode As", "sistap import")


@pytest.mark.thorough
def test_what_cannot_be_opened(tmp_path: Path) -> None:
    capture = write(tmp_path / "x.pcapng", BUS)
    (tmp_path / "junk").write_bytes(b"this is no capture at all, just a text\n" * 9)
    refused(run(tmp_path, "log", "junk"), 2, "junk is not a capture")
    refused(run(tmp_path, "log", "nothing"), 2, "cannot read nothing")
    refused(run(tmp_path, "log", capture, "-o", "no/folder.txt"), 2, "cannot write no/folder.txt", "-o")
    refused(run(tmp_path, "log", capture, "-o", capture), 2, "is the capture itself")
    refused(run(tmp_path, "log", capture, PATH=str(tmp_path)), 1, *NO_TSHARK)
    (tmp_path / "plugins").mkdir()
    refused(run(tmp_path, "log", capture, WIRESHARK_PLUGIN_DIR="plugins"), 1, "no dissector for SIS")


def test_a_tshark_that_is_no_program_is_named(tmp_path: Path) -> None:
    program = tmp_path / ("tshark.exe" if WINDOWS else "tshark")
    program.write_bytes(b"\0")
    program.chmod(0o755)
    refused(run(tmp_path, "log", CAPTURES / "told-before.pcapng", PATH=str(tmp_path)), 1, f"cannot start {program}: ")


@posix("it has no devices in folders")
@pytest.mark.attack("`sistap log` of a device without an end, or of a pipe", "refused in one line")
@pytest.mark.parametrize("name", ["/dev/zero", "pipe"])
def test_what_is_no_file(tmp_path: Path, name: str) -> None:
    """As root it was copied for tshark, until the disk was full."""
    os.mkfifo(tmp_path / "pipe")
    refused(run(tmp_path, "log", name), 2, f"{name} is not a file: it is read twice")
