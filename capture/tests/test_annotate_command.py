# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap annotate` as a command, with tshark: what it explains, in files and pipes, and what it refuses."""

from __future__ import annotations

import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from commands import run_with
from independent import packets
from logs import LOGS, MARKED, PHASE, READ_PHASE, SET_RATE
from portable import NO_TSHARK, posix
from report_capture import ACCEPT, READ, SET_TRS
from report_capture import ANSWER as READ_ANSWER

from sistap import cli
from sistap.commands.annotate import command
from sistap.commands.annotate.annotating import LONGEST_LINE
from sistap.commands.annotate.explaining import WholeCapture
from sistap.commands.annotate.sources import from_pipe
from sistap.dissected.episodes.rules import Thresholds
from sistap.dissected.explain.fields import Fields
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.records.record import Record, Type

ANNOTATE = [sys.executable, "-m", "sistap", "annotate"]

# What the specification says of figures 6-14, 8-20 and 8-21, in the words of the dissector.
SET_RATE_TEXT = "16 -> 3  Command  Set baud rate: 9600"
READ_PHASE_TEXT = "0 -> 0  Command  Read phase (SYNAX)"
PHASE_TEXT = "0 -> 0  Reaction  Read phase (SYNAX): phase 2 (parameter mode)"


def run(
    folder: Path, *arguments: str | Path, stdin: bytes = b"", **environment: str
) -> subprocess.CompletedProcess[bytes]:
    return run_with(folder, stdin, "annotate", *arguments, **environment)


WRITTEN = b"sistap: written to x.pcapng; open it with: wireshark -C SIS x.pcapng\n"


def refused(done: subprocess.CompletedProcess[bytes], code: int, *words: str) -> None:
    said = done.stderr.decode()
    assert done.returncode == code
    assert said.startswith("sistap: ")
    assert said.count("\n") == 1
    assert all(word in said for word in words)


def records(path: Path) -> list[tuple[int, Record]]:
    """All records of a capture but its event, and the numbers of their interfaces."""
    found = [(packet.interface, packet.record) for packet in packets(path)]
    assert found[0][1].type == Type.EVENT
    return found[1:]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "docklight.txt"
    path.write_bytes(LOGS["docklight"][0].encode())
    return path


def test_a_file(log: Path) -> None:
    done = run(log.parent, log)
    assert (done.returncode, done.stderr) == (0, b"")
    heading, empty, *lines = LOGS["docklight"][0].splitlines()
    assert done.stdout.decode().split("\r\n") == [
        heading,
        empty,
        *lines[:2],
        f"^-- (lines 3 to 4) {SET_RATE_TEXT}",
        lines[2],
        f"{' ' * 31}^-- {READ_PHASE_TEXT}",
        lines[3],
        f"{' ' * 31}^-- {PHASE_TEXT}  36 ms after the command",
        "",
    ]


@pytest.mark.parametrize("form", ["text", pytest.param("html", marks=pytest.mark.thorough)])
def test_what_is_written_to_a_log_meanwhile_is_left_out(
    log: Path, form: str, monkeypatch: pytest.MonkeyPatch, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    """A log that is still being written may grow by any number of lines, here before the first answer of tshark."""
    assert cli.main(["annotate", str(log), "--format", form]) == 0
    before = capfdbinary.readouterr().out

    class Growing(WholeCapture):
        def __init__(self, tshark: Tshark, fields: Fields, capture: Path, thresholds: Thresholds) -> None:
            with log.open("ab") as file:
                file.write(b"\r\n" + f"{PHASE.hex(' ')}\r\n".encode() * 1000)
            super().__init__(tshark, fields, capture, thresholds)

    monkeypatch.setattr(command, "WholeCapture", Growing)
    assert cli.main(["annotate", str(log), "--format", form]) == 0
    assert capfdbinary.readouterr() == (before, b"")


def test_a_log_of_another_protocol_says_so(log: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    """USS begins with 02 and a length, too. The log has no times."""
    log.write_text("02 0E 01 64 E0 00 00 00 00 00 00 00 00 00 00 89\n" * 6)
    assert cli.main(["annotate", str(log)]) == 0
    *_, last = capfdbinary.readouterr().out.decode().splitlines()
    assert last.startswith("^-- No SIS: none of ") and "another protocol, rate or format? It may be" in last


# Of USS: the third line and half of the fourth have equal lengths, and a wrong checksum of SIS.
USS = """\
02 0E 01 64 E0 00 00 00 00 00 00 00 00 00 00 89
02 0E 01 16 4E 00 00 00 00 02 0C 06 07 00 00 4A
02 06 04 04 7C 20 00 58
02 06 04 06 07 00 00 01
02 0C 03 20 0A 00 00 00 00 04 7F 10 00 4F
"""


@pytest.mark.parametrize("name", ["x", "-"])
def test_a_log_of_another_protocol_accuses_nobody(tmp_path: Path, name: str) -> None:
    (tmp_path / "x").write_text(USS)
    done = run(tmp_path, name, stdin=USS.encode())
    said = {text.partition("^-- ")[2] for text in done.stdout.decode().splitlines() if "^-- " in text}
    assert all("other characters" in text or text.startswith("No SIS: ") for text in said)
    refused(done, 0, "has 62 bytes, but no telegram of SIS")


def test_the_notation_is_named_if_it_is_not_usual(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("-> 2-108-0-0-0-146-0-0\n<- 2-86-2-2-16-146-0-0-0-2\n")
    done = run(tmp_path, "x")
    assert done.stderr == b"sistap: x: bytes: decimal, separated by dashes\n"
    assert done.stdout.decode().count("Read phase") == 2


@pytest.mark.parametrize(
    ("log", "told"), [("[2, 108, 0, 0, 0, -110, 0, 0]\n" * 2, 2), ("2\n108\n0\n0\n0\n146\n0\n0\n" * 3, 2)]
)
def test_a_pipe_in_another_notation(tmp_path: Path, log: str, told: int) -> None:
    """It is chosen when its first telegram is complete. Lines before that one are not read again."""
    done = run(tmp_path, "-", stdin=log.encode())
    assert done.stdout.decode().count("Read phase") == told
    assert b"bytes: decimal" in done.stderr


def test_a_log_with_faults_ends_with_what_happened(log: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    """Its checksum is wrong; the last line has no ending, and what is added does not change that."""
    damaged = PHASE[:-1] + bytes([PHASE[-1] ^ 1])
    times = (f"2026-03-14 03:12:0{second}.000 " for second in range(9))
    lines = (f"{time}{data.hex(' ')}" for time, data in zip(times, (READ_PHASE, damaged), strict=False))
    log.write_text("\n".join(lines), newline="\n")
    assert cli.main(["annotate", str(log)]) == 0
    *told, last = capfdbinary.readouterr().out.decode().splitlines(keepends=True)
    assert told[-4] == "^-- OK, 03:12:00 to 03:12:01.\n"
    assert last == "^-- Limits: 1 damaged telegram (its checksum is wrong, 03:12:01)."


@pytest.mark.thorough
def test_a_pipe_knows_only_what_came(log: Path) -> None:
    # The first command is in vain, and only the second tells.
    log.write_text(f"{READ_PHASE.hex(' ')}\n{SET_RATE.hex(' ')}\n{READ_PHASE.hex(' ')}\n{PHASE.hex(' ')}\n")
    done = run(log.parent, "-", stdin=log.read_bytes())
    assert (done.returncode, done.stderr) == (0, b"")
    again = [READ_PHASE_TEXT.replace("  Read", f"  [{mark}]  Read") for mark in ("no reaction", "repeat")]
    told = [again[0], SET_RATE_TEXT, again[1], PHASE_TEXT]
    found = [line[4:] for line in run(log.parent, log).stdout.decode().splitlines() if line.startswith("^-- ")]
    assert [text for text in found if not text.startswith("What to do: ")] == told
    live = [line[4:] for line in done.stdout.decode().splitlines() if line.startswith("^-- ")]
    assert [text for text in live if not text.startswith("What to do: ")] == [
        text.replace("  [no reaction]", "") for text in told
    ]


DO_DAMAGED = (
    "What to do: Look at line errors and losses at this packet. Check cable, termination, ground and baud rate."
)
DO_UNRESOLVED = "Unresolved, whether a limit was kept. Make the times more exact: "


@pytest.mark.parametrize("form", ["text", "html", "pipe"])
def test_the_first_telegram_with_a_fault_says_what_to_do(log: Path, form: str) -> None:
    damaged = PHASE[:-1] + bytes([PHASE[-1] ^ 1])
    log.write_text("\n".join(data.hex(" ") for data in (READ_PHASE, damaged, PHASE, damaged)))
    arguments = {"text": [str(log)], "html": ["--format", "html", str(log)], "pipe": ["-"]}[form]
    shown = run(log.parent, *arguments, stdin=log.read_bytes()).stdout.decode()
    assert shown.count(DO_DAMAGED) == 1
    assert 0 < shown.index("[wrong checksum]") < shown.index(DO_DAMAGED) < shown.rindex("[wrong checksum]")
    (line,) = (line for line in shown.splitlines() if DO_DAMAGED in line)
    assert line.strip() in (f"^-- {DO_DAMAGED}", f"<i>{DO_DAMAGED}</i>")


def test_a_log_too_coarse_for_a_verdict_says_what_to_do(log: Path) -> None:
    """TrS is 50 ms. The stamps have steps of 0.1 s, so nobody knows whether 0.1 s were less."""
    sent = [(0.0, SET_TRS), (0.1, ACCEPT), (1.0, READ), (1.1, READ_ANSWER), (2.0, READ), (2.1, READ_ANSWER)]
    log.write_text("".join(f"2026-03-14 03:12:0{second:.1f} {data.hex(' ')}\n" for second, data in sent))
    shown = run(log.parent, log).stdout.decode()
    assert shown.count(DO_UNRESOLVED) == 1
    assert shown.splitlines()[8].strip().startswith(f"^-- {DO_UNRESOLVED}")


@contextmanager
def running(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    with subprocess.Popen([*ANNOTATE, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        watchdog = threading.Timer(60, process.kill)  # a test that waits in vain fails
        watchdog.start()
        try:
            yield process
        finally:
            watchdog.cancel()
            process.kill()


def test_each_explanation_comes_before_the_next_line_is_written() -> None:
    with running("-") as process:
        assert process.stdin
        assert process.stdout
        for telegram, text in [(READ_PHASE, READ_PHASE_TEXT), (PHASE, PHASE_TEXT)]:
            line = f"{telegram.hex(' ')}\n".encode()
            process.stdin.write(line)
            process.stdin.flush()
            assert process.stdout.readline() == line
            assert process.stdout.readline().decode() == f"^-- {text}\n"
        # Text, too, and the beginning of a telegram: nobody knows when the rest comes.
        for line in (b"waiting\n", b"02 56 02 02\n"):
            process.stdin.write(line)
            process.stdin.flush()
            assert process.stdout.readline() == line
        process.stdin.write(b"10 92 00 00 00 02")
        process.stdin.close()
        assert process.stdout.read().decode() == f"10 92 00 00 00 02\n^-- (lines 4 to 5) {PHASE_TEXT}"
        assert process.wait() == 0


@posix("no signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it(number: signal.Signals) -> None:
    with running("-") as process:
        assert process.stdin
        assert process.stdout
        process.stdin.write(b"waiting\n")
        process.stdin.flush()
        assert process.stdout.readline() == b"waiting\n"
        process.send_signal(number)
        assert process.wait() == 0


@pytest.mark.thorough
@posix("no signals")
def test_a_reader_who_does_not_read_does_not_hold_up_a_stop(log: Path) -> None:
    """annotate LOG | less, and then Ctrl-C."""
    log.write_bytes(f"{PHASE.hex(' ')}\n".encode() * 1500)
    ours, theirs = os.pipe()
    with subprocess.Popen([*ANNOTATE, str(log)], stdout=theirs, stderr=subprocess.PIPE) as process:
        assert process.stderr
        while select.select([], [theirs], [], 0)[1]:
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
        assert process.stderr.read() == b""
    os.close(ours)
    os.close(theirs)


@pytest.mark.thorough
@posix("no pipes in folders")
@pytest.mark.attack("a pipe that delivers a log faster than it is explained", "it waits: memory stays as it is")
def test_a_pipe_is_not_read_ahead(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    writer = os.open(tmp_path / "pipe", os.O_RDWR | os.O_NONBLOCK)
    batches, written, lines = from_pipe(str(tmp_path / "pipe")), 0, b"12:00:00 02 D9\n" * 4000
    os.write(writer, lines)
    next(batches)
    while written < 100_000_000 and select.select([], [writer], [], 0.5)[1]:
        written += os.write(writer, lines)
    os.close(writer)
    assert written < 50_000_000


@posix("no pipes in folders")
def test_a_named_pipe_is_read_once(tmp_path: Path, log: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    writer = threading.Thread(target=fifo.write_bytes, args=(log.read_bytes(),))
    writer.start()
    assert run(tmp_path, fifo).stdout == run(tmp_path, "-", stdin=log.read_bytes()).stdout
    writer.join()


def test_a_capture(log: Path) -> None:
    done = run(log.parent, log, "-w", "x.pcapng")
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", WRITTEN)
    found = records(log.parent / "x.pcapng")
    expected = LOGS["docklight"][1]
    assert [(number, record.line, record.data) for number, record in found] == [
        (each.line, each.line, each.data) for each in expected
    ]
    times = [record.time_ns - found[0][1].time_ns for _, record in found]
    assert times == [round((each.time_ms or 0) * 1e6) for each in expected]


def test_a_capture_through_a_pipe_is_the_same(log: Path) -> None:
    run(log.parent, log, "-w", "x.pcapng")
    (log.parent / "y.pcapng").write_bytes(run(log.parent, "-", "-w", "-", stdin=log.read_bytes()).stdout)
    assert records(log.parent / "x.pcapng") == records(log.parent / "y.pcapng")


def test_an_own_form_by_a_regular_expression(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("a;>;02D7030300031003040700\nb;>;026C000000920000\nc;<;02560202109200000002\n")
    assert run(tmp_path, "x.csv", "--regex", "^.;(?<dir>.);(?<data>.*)$", "-w", "x.pcapng").returncode == 0
    assert [(record.data, record.line) for _, record in records(tmp_path / "x.pcapng")] == [
        (each.data, each.line) for each in MARKED
    ]
    done = run(tmp_path, "x.csv", "--regex", "(?<time>.*)")
    assert done.returncode == 2
    assert b"has no group (?<data>...)" in done.stderr.splitlines()[-1]


# An S5 reads S-0-0237 of axis 2 from a PPC, which answers 7 (chapter 8): STX, DLE, block, DLE; BCC worked out by hand.
FETCH, ANSWER = "00 00 45 44 00 00 00 01 FF FF 00 02 02 00 00 ED 10 03 FE", "00 00 00 00 00 07 10 03 14"
SAID_3964R = (
    "STX  asks to send",
    "DLE  ready to receive",
    "Block, 16 bytes  FETCH DB 0, 1 word: Read S-0-0237, axis 2",
    "DLE  block received",
    "STX  asks to send",
    "DLE  ready to receive",
    "Block, 6 bytes  Reaction: S-0-0237, axis 2, 2 bytes: 00 07",
    "DLE  block received",
)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "lines",
    [
        ("TX: 02", "RX: 10", f"TX: {FETCH}", "RX: 10", "RX: 02", "TX: 10", f"RX: {ANSWER}", "TX: 10"),
        ("02 10", FETCH, f"10 02 10 {ANSWER}", "10"),
    ],
    ids=["two_directions", "shared"],
)
def test_a_log_of_procedure_3964r(tmp_path: Path, lines: tuple[str, ...]) -> None:
    log = "".join(f"10:00:00.{i}00 {line}\n" for i, line in enumerate(lines))
    (tmp_path / "x").write_text(log)
    done = run(tmp_path, "x", "--framing", "3964r")
    assert (done.returncode, done.stderr) == (0, b"")
    said = [line.partition("^-- ")[2] for line in done.stdout.decode().splitlines() if "^--" in line]
    assert [text for text in said if text] == list(SAID_3964R)
    page = run(tmp_path, "x", "--framing", "3964r", "--format", "html").stdout.decode()
    for meaning in ("Command: FETCH (0x45)", "Axis: 2", "Block check character: 0xfe [correct]"):
        assert meaning in page


def test_a_log_of_another_protocol(tmp_path: Path) -> None:
    """Two frames of Modbus RTU, a second apart."""
    (tmp_path / "x").write_text("10:00:00.0 01 03 00 00 00 0A C5 CD\n10:00:01.0 01 03 00 00 00 0A C5 CD\n")
    done = run(tmp_path, "x", "--framing", "silence:10", "-w", "x.pcapng")
    assert (done.returncode, done.stderr) == (0, WRITTEN)
    assert [record.data.hex() for _, record in records(tmp_path / "x.pcapng")] == ["01030000000ac5cd"] * 2


def test_a_log_without_blocks(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("01 03 00 00 00 0A C5 CD\n")
    refused(run(tmp_path, "x", "--framing", "3964r"), 0, "x has 8 bytes, but no frame")


def test_what_cannot_be_read_is_named_and_the_rest_counted(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("rx 025602021092000000020\n" * 23 + f"rx {PHASE.hex()}\n")
    done = run(tmp_path, "x")
    assert done.returncode == 0
    said = done.stderr.decode().splitlines()
    assert said[0] == "sistap: line 1: an odd number of hexadecimal digits (21)"
    assert said[9] == "sistap: line 10: an odd number of hexadecimal digits (21)"
    assert said[10:] == ["sistap: 13 more lines could not be read"]
    assert PHASE_TEXT.encode() in done.stdout


# A session of the ASCII protocol as a terminal program shows it: as text, in hexadecimal, and with SIS between.
SESSION = "BCD:21\r\nE21:>S-0-0051,7,R\r\n12.3456\r\nE21:>\r\n"


@pytest.mark.parametrize(
    ("log", "code"),
    [
        ("S-0-0051,7,R\n", 2),
        ("P-0-4006.0.2,7,w,>\n", 2),
        (SESSION, 2),
        (f"{SESSION.encode().hex(' ')}\n", 0),
        (f"{PHASE.hex(' ')}\n{SESSION.encode().hex(' ')}\n", 0),
    ],
)
def test_a_log_of_the_ascii_protocol(log: str, code: int, tmp_path: Path) -> None:
    (tmp_path / "x").write_text(log)
    done = run(tmp_path, "x")
    said = done.stderr.decode().splitlines()
    assert said[-1] == "sistap: x has lines of the ASCII protocol of drives: explain them with --framing ascii"
    assert done.returncode == code
    assert b"ASCII protocol" not in run(tmp_path, "x", "--framing", "ascii").stderr


@pytest.mark.thorough
def test_a_log_without_bytes_or_without_telegrams(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(b"nothing to see here\n")
    done = run(tmp_path, "x")
    assert done.stdout == b"nothing to see here\n"
    refused(done, 2, "no bytes were found in x", "--regex")
    (tmp_path / "x").write_text("01 03 00 00 00 0A C5 CD\n")
    done = run(tmp_path, "x")
    refused(done, 0, "x has 8 bytes, but no telegram of SIS")
    assert done.stdout.decode().splitlines()[1].startswith("^-- 8 other characters")


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("RX 02D703030003100304070", "line 1: an odd number of hexadecimal digits (21)"),
        ("RX <STX>l<NUL><NUL>", "line 1: characters are shown as text, which loses most of them: log in hexadecimal"),
    ],
)
def test_a_log_in_which_nothing_could_be_read_says_why(tmp_path: Path, line: str, why: str) -> None:
    (tmp_path / "x").write_text(f"{line}\n" * 5)
    refused(run(tmp_path, "x"), 2, f"no bytes were found in x: {why}\n")


def test_telegrams_in_the_middle_of_a_log_are_found(tmp_path: Path) -> None:
    """In a notation that is not read without a choice, and after more lines than are looked at together."""
    boot = "".join(f"boot step {step} ok\n" for step in range(1300))
    (tmp_path / "x").write_text(boot + "2;108;0;0;0;146;0;0\n" * 30 + boot)
    done = run(tmp_path, "x")
    assert done.stderr == b"sistap: x: bytes: decimal, separated by semicolons\n"
    assert done.stdout.count(b"Read phase") == 30


def test_a_damaged_telegram_is_one_wherever_it_stands_in_a_log_with_right_ones(tmp_path: Path) -> None:
    """What stood in front of it, bytes of something else, says nothing."""
    damaged = "02 D6 03 03 00 03 10 03 04 07 00"
    (tmp_path / "x").write_text(f"RX {'55 ' * 14}\nRX {damaged}\n" + f"RX {SET_RATE.hex(' ')}\n" * 9)
    assert run(tmp_path, "x").stdout.decode().count("[wrong checksum]") == 1


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (bytes.fromhex("0a0d0d0a1c000000"), "x is a capture, not a log: `sistap log x` explains it"),
        (b"MZ\x90\0\x03\0\0\0", "x is no text, and its bytes are no telegrams: name a log that an editor can show"),
    ],
)
def test_a_file_of_bytes_is_no_log(tmp_path: Path, content: bytes, words: str) -> None:
    (tmp_path / "x").write_bytes(content)
    refused(run(tmp_path, "x"), 2, words)


@pytest.mark.thorough
@pytest.mark.attack("a log with an endless line", "the first million characters are explained")
def test_a_line_has_a_longest_length(tmp_path: Path) -> None:
    """Its beginning is explained; the whole line is copied."""
    telegram = "02 56 02 02 10 92 00 00 00 02 "
    text = f"RX {telegram * (LONGEST_LINE // len(telegram) + 100)}\nRX {telegram}\n"
    (tmp_path / "x").write_text(text)
    done = run(tmp_path, "x", "-w", "x.pcapng")
    done.stderr = done.stderr.replace(WRITTEN, b"")
    refused(done, 0, "line 1: longer than 1,000,000 characters")
    telegrams = [record for _, record in records(tmp_path / "x.pcapng") if record.type == Type.FRAME]
    assert len(telegrams) == (LONGEST_LINE - 3) // len(telegram) + 1


@pytest.mark.attack("dates that no capture can hold", "left out")
@pytest.mark.parametrize("year", [1400, 2260, 2999, 9999])
def test_of_a_year_that_a_capture_cannot_have_the_clock_holds(tmp_path: Path, year: int) -> None:
    line = f"{year}-12-31 23:59:59.{{}} RX 02 56 02 02 10 92 00 00 00 02\n"
    (tmp_path / "x").write_text(line.format(2) + line.format(5))
    done = run(tmp_path, "x", "-w", "x.pcapng")
    assert done.returncode == 0
    (_, first), (_, second) = records(tmp_path / "x.pcapng")
    assert second.time_ns - first.time_ns == 300_000_000


@pytest.mark.thorough
@pytest.mark.attack("a `--regex` that never ends", "stopped after two seconds")
@pytest.mark.skipif(sys.platform == "win32", reason="needs a timer of POSIX")
def test_an_expression_that_never_ends_is_given_up(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("02 " * 40 + "!\n")
    done = run(tmp_path, "x", "--regex", r"(?<data>(([0-9 ]+)*)*)$")
    refused(done, 2, "line 1: the expression takes longer than 2 s; make it simpler")


@pytest.mark.thorough
def test_an_empty_log(tmp_path: Path) -> None:
    (tmp_path / "x").touch()
    done = run(tmp_path, "x")
    assert done.stdout == b""
    refused(done, 2, "no bytes were found in x")
    assert run(tmp_path, "-").returncode == 2


def test_what_cannot_be_opened(tmp_path: Path, log: Path) -> None:
    refused(run(tmp_path, "nothing"), 2, "cannot read nothing: ", "name a log")
    refused(run(tmp_path, "."), 2, "cannot read .: Is a directory")
    refused(run(tmp_path, log, "-o", "no/folder.txt"), 2, "cannot write no/folder.txt", "-o")
    refused(run(tmp_path, log, "-w", "no/folder.pcapng"), 2, "no/folder.pcapng cannot be written", "-w")
    before = log.read_bytes()
    for option in ("-o", "-w"):
        refused(run(tmp_path, log, option, log), 2, "is the log itself", option)
    assert log.read_bytes() == before
    assert run(tmp_path, log, "-w", "x", "-o", "y").returncode == 2
    assert run(tmp_path, log, "-w", "x", "--format", "html").returncode == 2


def test_without_tshark_or_its_plugin(tmp_path: Path, log: Path) -> None:
    """Known before a line is read: the last one would be reported."""
    (tmp_path / "plugins").mkdir()
    with log.open("ab") as file:
        file.write(b"0" * 19)
    for name, stdin in ((log, b""), ("-", log.read_bytes())):
        refused(run(tmp_path, name, stdin=stdin, PATH=str(tmp_path)), 1, *NO_TSHARK)
        refused(run(tmp_path, name, stdin=stdin, WIRESHARK_PLUGIN_DIR="plugins"), 1, "no dissector for SIS")
    # A capture needs neither.
    assert run(tmp_path, log, "-w", "x.pcapng", PATH=str(tmp_path)).returncode == 0


@pytest.mark.thorough
def test_who_reads_only_the_beginning_is_no_failure_to_speak_of(log: Path) -> None:
    log.write_bytes(log.read_bytes() * 200)
    with subprocess.Popen([*ANNOTATE, str(log)], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stderr
        assert process.stdout.readline().startswith(b"Docklight")
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait() == 1


def test_the_user_may_have_other_columns(tmp_path: Path, log: Path) -> None:
    folder = tmp_path / "home" / ".config" / "wireshark"
    folder.mkdir(parents=True)
    (folder / "preferences").write_text('gui.column.format: "No.", "%m"\n')
    (tmp_path / "home").chmod(0o755)
    assert PHASE_TEXT.encode() in run(tmp_path, log, HOME=str(tmp_path / "home")).stdout


@pytest.mark.thorough
def test_no_file_stays(tmp_path: Path, log: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o777)
        for kind in ("text", "html"):
            for name in (str(log), "-"):
                done = run(tmp_path, name, "--format", kind, stdin=log.read_bytes(), TMPDIR=folder)
                assert done.returncode == 0
        assert list(Path(folder).iterdir()) == []


def test_the_help_is_a_page() -> None:
    page = subprocess.run([*ANNOTATE, "--help"], capture_output=True, text=True, check=True).stdout
    for word in ("LOG", "--format", "-w FILE", "-o FILE", "--regex", "examples:", "exit status:"):
        assert re.search(re.escape(word), page)


@pytest.mark.thorough
@pytest.mark.parametrize("piece", [" ", "\x1b[1m"])
def test_a_file_of_one_long_line_comes_to_an_end(tmp_path: Path, piece: str) -> None:
    """Within minutes, though a naive search would look at the rest of the line again and again."""
    (tmp_path / "long.txt").write_text(piece * (300_000 // len(piece)))
    assert run(tmp_path, "long.txt").stderr.startswith(b"sistap: no bytes were found in long.txt: ")
