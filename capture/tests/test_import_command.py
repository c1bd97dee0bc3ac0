# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap import` as a command: which files it takes, and one line with the cure for everything that is wrong."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from imported import run
from portable import NO_TSHARK
from specification import TELEGRAMS
from usb_captures import STATUS, ftdi

from sistap import cli
from sistap.commands.imports.convert import Conversion
from sistap.commands.imports.formats import NAMES
from sistap.dissected.wireshark.tshark import TsharkError
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.counters import Counters

COMMAND, REACTION = TELEGRAMS["2-12"], TELEGRAMS["2-13"]
TABLE = "Time [s],Value,Parity Error,Framing Error\n" + "".join(
    f"{i / 1000:.6f},0x{value:02X},,\n" for i, value in enumerate(COMMAND)
)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    source = tmp_path / "logic.csv"
    source.write_text(TABLE)
    return source


def refused(capfd: pytest.CaptureFixture[str], *words: str) -> None:
    """One line on stderr with these words, nothing on stdout."""
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("sistap: ")
    for word in words:
        assert word in err


def test_the_last_line_says_how_good_it_is(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """2 ms after the transfer before, and a frame: 3 ms; 16 ms by the latency timer, and a frame: 17 ms."""
    host = ftdi()
    host.receive(4, 30, STATUS + COMMAND)
    host.receive(30, 32, STATUS + b"A")
    assert run(host.save(tmp_path / "usb.pcap")).code == 0
    lines = capfd.readouterr().err.splitlines()
    assert lines[0].startswith("sistap: 1 telegrams, 0 of them damaged, 12 characters")
    assert lines[1].startswith(
        "sistap: 9600 Bd 8E1, as the adapter was set; times of USB transfers (FTDI: vendor 0403), latency timer 16 ms, "
        "and a USB frame: characters can have come up to 17 ms earlier; an interval that close to its limit"
    )
    host.receive(34, 36, STATUS + REACTION + REACTION)
    host.save(tmp_path / "usb.pcap")
    run(tmp_path / "usb.pcap")
    assert "up to 17 ms earlier (half of them 5 ms)" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--baud 19200", "19200 Bd 8E1, as given; the adapter was set to 9600 Bd 8E1;"),
        ("--format 8N1", "9600 Bd 8N1, as given; the adapter was set to 9600 Bd 8E1;"),
        ("--baud 9600 --format 8e1", "9600 Bd 8E1, as the adapter was set;"),
    ],
)
def test_what_the_user_says_wins(tmp_path: Path, options: str, said: str) -> None:
    host = ftdi()
    host.receive(4, 30, STATUS + COMMAND)
    done = run(host.save(tmp_path / "usb.pcap"), *options.split())
    assert str(done.records[0].settings) in said
    assert said in done.events[0]


@pytest.mark.parametrize("content", [b"", b"\n", b"what is this\n", bytes(range(256))])
def test_a_file_of_another_kind(tmp_path: Path, capfd: pytest.CaptureFixture[str], content: bytes) -> None:
    source = tmp_path / "other"
    source.write_bytes(content)
    assert run(source, "--baud", "9600").code == 2
    refused(capfd, "is none of the files that can be imported", "sistap annotate", *NAMES)


def test_a_capture_of_sistap_is_one_already(table: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(table, "--baud", "9600").code == 0
    capfd.readouterr()
    assert run(Path(f"{table}.imported")).code == 2
    refused(capfd, "is a capture that Wireshark reads as it is: `sistap log ")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "add it, such as --baud 9600"),
        (["--baud", "9600", "--format", "9X1"], "format '9X1' is not data bits"),
    ],
)
def test_options(table: Path, capfd: pytest.CaptureFixture[str], options: list[str], words: str) -> None:
    assert run(table, *options).code == 2
    refused(capfd, words)
    assert not Path(f"{table}.imported").exists()


@pytest.mark.parametrize("option", [["--baud", "0"], ["--samplerate", "x"], ["--baud", "99999999999"]])
def test_numbers(table: Path, option: list[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        run(table, *option)
    assert ended.value.code == 2


def test_files(table: Path, capfd: pytest.CaptureFixture[str]) -> None:
    arguments = ["--baud", "9600", "-w"]
    assert cli.main(["import", str(table.parent / "missing"), *arguments, "x"]) == 2
    refused(capfd, "cannot read", "No such file or directory")
    assert cli.main(["import", str(table.parent), *arguments, "x"]) == 2
    refused(capfd, "Is a directory")
    assert cli.main(["import", str(table), *arguments, str(table)]) == 2
    refused(capfd, "is FILE itself")
    assert table.read_text() == TABLE
    assert cli.main(["import", str(table), *arguments, str(table.parent / "no/x")]) == 2
    refused(capfd, "cannot be written")


def test_without_tshark(
    tmp_path: Path, table: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Texts need none."""
    monkeypatch.setenv("PATH", str(tmp_path))
    assert run(table, "--baud", "9600").code == 0
    capfd.readouterr()
    host = ftdi()
    host.receive(4, 30, STATUS + COMMAND)
    assert run(host.save(tmp_path / "usb.pcap")).code == 1
    refused(capfd, *NO_TSHARK)


def test_into_a_pipe(table: Path) -> None:
    command = [sys.executable, "-m", "sistap", "import", str(table), "--baud", "9600", "-w", "-"]
    done = subprocess.run(command, capture_output=True, check=True, timeout=60)
    assert run(table, "--baud", "9600").code == 0
    assert done.stdout == Path(f"{table}.imported").read_bytes()


class Endless:
    """A source that never ends, or fails after some characters."""

    lines: Mapping[int, str] = {0: "endless"}
    settings = LineSettings()
    settings_from = "as given"
    timing = "none"
    warning = ""

    def __init__(self, fails_after: int | None = None) -> None:
        self._fails_after = fails_after

    def reads(self) -> Iterator[Read]:
        number = 0
        while number != self._fails_after:
            yield Read(0, number * 2_000_000, bytes([COMMAND[number % len(COMMAND)]]), b"\0", 1000)
            number += 1
        raise TsharkError("gone")


def conversion(path: Path, source: Endless) -> tuple[Conversion, Counters]:
    counters = Counters()
    writer = PcapngWriter(Output(str(path)), {0: Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "x")}, counters)
    return Conversion(source, writer, counters, "x"), counters


def test_stopped_by_hand_what_came_is_saved(tmp_path: Path) -> None:
    made, counters = conversion(tmp_path / "out", Endless())
    answers = iter([False] * 15 + [True])
    made.run(lambda: next(answers), lambda _: None)
    assert (counters.characters, counters.telegrams, counters.accepted[0]) == (16, 1, 2)  # 11 and 5 others


def test_what_came_before_a_failure_is_saved(tmp_path: Path) -> None:
    made, counters = conversion(tmp_path / "out", Endless(fails_after=16))
    with pytest.raises(TsharkError):
        made.run(lambda: False, lambda _: None)
    assert (counters.characters, counters.telegrams, counters.accepted[0]) == (16, 1, 2)


def test_a_line_that_is_silent_for_long_does_not_hold_back_the_other(tmp_path: Path) -> None:
    """Line 1 begins a telegram at 0 and is silent; after a second it is no telegram, and line 2 need not wait."""

    class Two(Endless):
        lines: Mapping[int, str] = {1: "a", 2: "b"}  # noqa: RUF012

        def reads(self) -> Iterator[Read]:
            yield Read(1, 1, COMMAND[:5], bytes(5), 1000)
            for number in range(300):
                yield Read(2, number * 10_000_000 + 2, b"A", b"\0", 1000)

    made, counters = conversion(tmp_path / "out", Two())
    written: list[int] = []

    def note() -> bool:
        written.append(counters.accepted[1])
        return False

    made.run(note, lambda _: None)
    assert (written[90], written[130]) == (0, 1)
