# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report` as a command: what it writes where, and one line with the cure for everything that is wrong."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from commands import refused, run, run_anew
from portable import NO_TSHARK, SIGNALS, WINDOWS, fifos, posix
from report_capture import BUS, write

from sistap import cli
from sistap.commands.report import running

TOLD = Path(__file__).parents[2] / "test-captures" / "timing-told.pcapng"


def report(folder: Path, *arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    return run(folder, "report", *arguments, **environment)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("command") / "bus.pcapng", BUS)


@pytest.mark.thorough
def test_the_page_is_written_into_this_folder(tmp_path: Path, capture: Path) -> None:
    done = report(tmp_path, capture)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "sistap: report.html written\n")
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "beginning"), [("x.svg", b"<?xml"), ("x.JSON", b"{"), ("x.txt", b"NOT OK, ")])
def test_the_ending_says_what_to_write(tmp_path: Path, capture: Path, name: str, beginning: bytes) -> None:
    assert report(tmp_path, capture, "-o", name).returncode == 0
    assert (tmp_path / name).read_bytes().startswith(beginning)


def test_text_and_json_go_to_standard_output(tmp_path: Path, capture: Path) -> None:
    assert json.loads(report(tmp_path, capture, "--format", "json").stdout)["capture"] == "bus.pcapng"
    text = report(tmp_path, capture, "--format", "text").stdout
    assert "frame.number in {10}" in text
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_limits_told_to_the_report_go_before_those_of_the_bus(tmp_path: Path, capture: Path) -> None:
    arguments = (capture, "--tza", "8", "--trs", "100")
    figures = json.loads(report(tmp_path, *arguments, "--format", "json").stdout)
    assert {name: figures["limits"][name]["limits_s"] for name in ("tza", "trs")} == {"tza": [0.008], "trs": [0.1]}
    text = report(tmp_path, *arguments, "--format", "text").stdout
    assert "Judged by TzA = 8 ms, TrS = 100 ms" in text


def test_limits_told_to_the_capture_are_named(tmp_path: Path) -> None:
    text = report(tmp_path, TOLD, "--format", "text").stdout
    assert "The limits TzA = 8 ms, TrS = 40 ms were given for this capture" in text


LOG = """\
14.03.2013 08:21:14.641 [TX] - 02 6C 00 00 00 92 00 00
14.03.2013 08:21:14.677 [RX] - 02 56 02 02 10 92 00 00 00 02
"""


def test_a_log_has_no_intervals(tmp_path: Path) -> None:
    """Nobody knows when each character came: there are neither zeros nor bounds of them, but of the reaction."""
    (tmp_path / "log.txt").write_text(LOG)
    assert run(tmp_path, "annotate", "log.txt", "-w", "log.pcapng").returncode == 0
    text = report(tmp_path, "log.pcapng", "--format", "text").stdout
    assert "16 of 16 intervals in telegrams: their length is not known" in text
    assert "by place" not in text and "by talker" not in text and "0.000 ms" not in text
    figures = json.loads(report(tmp_path, "log.pcapng", "--format", "json").stdout)
    assert figures["clock"]["intervals_in_one_read"] == 16
    assert (figures["tza_by_talker"], figures["tza_by_character"], figures["intervals"]) == ([], [], {"count": 0})
    assert [one["longest_pause_s"] for one in figures["stations"]] == [None]
    assert [one["reaction_times"]["longest_s"] for one in figures["stations"]] == [0.036]


@pytest.mark.thorough
def test_a_title_and_a_note_stand_above(tmp_path: Path, capture: Path) -> None:
    words = ("--title", "Press <4>", "--note", "Stops at night\nsince May")
    assert report(tmp_path, capture, *words).returncode == 0
    page = (tmp_path / "report.html").read_text()
    assert "<h1>Press &lt;4&gt;</h1>" in page and "<p>Stops at night</p><p>since May</p>" in page
    text = report(tmp_path, capture, *words, "--format", "text").stdout
    assert text.startswith("Press <4>\n\nStops at night\nsince May\n\nNOT OK, ")


@posix("arguments are UTF-16")
@pytest.mark.parametrize("kind", ["html", "text"])
def test_a_title_as_a_shell_passes_it_on(tmp_path: Path, capture: Path, kind: str) -> None:
    name = os.fsdecode(b"M\xfcller\x1b[31m")
    done = report(tmp_path, capture, "--title", name, "--note", name, "--format", kind, "-o", "-")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(r"M\xfcller\x1b[31m") >= 2


def test_a_capture_that_is_cut_is_reported_up_to_there(tmp_path: Path, capture: Path) -> None:
    cut = tmp_path / "cut.pcapng"
    cut.write_bytes(capture.read_bytes()[:-40])
    done = report(tmp_path, cut, "--format", "json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["packets"] == len(BUS)  # and the event, less the last one
    assert "cut short" in json.loads(done.stdout)["warning"]
    assert done.stderr.count("\n") == 1
    assert "cut short" in done.stderr
    assert "/sistap-" not in done.stderr + done.stdout  # the copy that is read as root


@pytest.mark.thorough
@pytest.mark.parametrize("block", [1, 12])
def test_a_capture_that_is_damaged_is_reported_up_to_there(tmp_path: Path, capture: Path, block: int) -> None:
    data = bytearray(capture.read_bytes())
    at = 0
    for _ in range(block):
        at += int.from_bytes(data[at + 4 : at + 8], "little")
    data[at + 4 : at + 8] = b"\x07\0\0\0"  # no block is 7 bytes long
    (tmp_path / "damaged.pcapng").write_bytes(data)
    done = report(tmp_path, "damaged.pcapng", "--format", "json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["packets"] == max(block - 2, 0)  # section and interface come first
    assert done.stderr.count("\n") == 1
    assert "before the damage" in done.stderr


@pytest.mark.thorough
@pytest.mark.parametrize("data", [b"", None])
def test_a_capture_without_packets_is_an_honest_page(tmp_path: Path, data: bytes | None) -> None:
    empty = tmp_path / "empty.pcapng"
    if data is None:
        write(empty, [], dissector="sis")
    else:
        empty.write_bytes(data)
    for kind in ("html", "svg", "text"):
        assert report(tmp_path, empty, "--format", kind, "-o", "x", "--force").returncode == 0
    assert "The capture has no packets." in (tmp_path / "x").read_text()


def test_what_is_no_capture(tmp_path: Path) -> None:
    (tmp_path / "junk").write_bytes(b"this is no capture at all, just a text\n" * 9)
    refused(report(tmp_path, "junk"), 2, "junk is not a capture")
    refused(report(tmp_path, "nothing"), 2, "cannot read nothing")
    refused(report(tmp_path, "."), 2, ". has no captures")
    if WINDOWS:
        return
    os.mkfifo(tmp_path / "pipe")
    refused(report(tmp_path, "pipe"), 2, "pipe is not a file", "save the capture first")


def classic(capture: bytes) -> bytes:
    """Return the head of a pcap file: another program's, under the name of ours."""
    return bytes.fromhex("d4c3b2a1 0200 0400 00000000 00000000 00000400 fc000000") + bytes(16)


# What lies among the captures of a folder, made of a good one, and why it is left out.
AMONG = {
    "text": (lambda _: b"this is no capture at all, just a text\n" * 9, "is not a pcapng file"),
    "pcap": (classic, "is not a pcapng file"),
    "nothing": (lambda _: b"", "has no packets"),
    "section": (lambda whole: whole[:100], "has no packets"),
    "damaged": (lambda whole: whole[:4] + b"\x07" + whole[5:], "is damaged"),
    "other order": (lambda whole: whole[:8] + whole[8:12][::-1] + whole[12:], "is damaged"),
}


@pytest.mark.parametrize(("make", "why"), AMONG.values(), ids=AMONG)
def test_a_folder_is_judged_without_what_cannot_be_read(
    tmp_path: Path, capture: Path, make: Callable[[bytes], bytes], why: str
) -> None:
    folder = tmp_path / "night"
    folder.mkdir()
    for name, content in (("a", capture.read_bytes()), ("b", make(capture.read_bytes()))):
        (folder / f"{name}.pcapng").write_bytes(content)
    alone = json.loads(report(tmp_path, folder / "a.pcapng", "--format", "json").stdout)
    done = report(tmp_path, folder, "--format", "json")
    assert done.returncode == 0, done.stderr
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"sistap: left out: {folder / 'b.pcapng'} {why}")
    told = json.loads(done.stdout)
    assert told.pop("left_out") == [line.removeprefix("sistap: ")]
    assert told == {name: value for name, value in alone.items() if name != "left_out"}
    page = report(tmp_path, folder, "--format", "html", "-o", "-").stdout
    assert f"<li>left out: {folder / 'b.pcapng'} {why}" in page


def test_a_folder_in_which_nothing_can_be_read(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.pcapng").write_bytes(b"just a text\n" * 9)
    refused(report(tmp_path, ".", "-o", "x.txt"), 2, "a.pcapng is not a capture")


@fifos
def test_a_pipe_in_a_folder_is_not_waited_for(tmp_path: Path, capture: Path) -> None:
    (tmp_path / "a.pcapng").write_bytes(capture.read_bytes())
    os.mkfifo(tmp_path / "b.pcapng")
    done = report(tmp_path, ".", "--format", "text")
    assert done.returncode == 0 and "left out: b.pcapng is not a file" in " ".join(done.stdout.split())


def test_where_nothing_can_be_written(tmp_path: Path, capture: Path) -> None:
    refused(report(tmp_path, capture, "-o", "no/folder.txt"), 2, "cannot write no/folder.txt", "-o")
    refused(report(tmp_path, capture, "-o", "x.pdf"), 2, "x.pdf", "--format")
    before = capture.read_bytes()
    refused(report(tmp_path, capture, "-o", capture, "--format", "text"), 2, "is the capture itself")
    assert capture.read_bytes() == before


@pytest.fixture
def handlers() -> Iterator[None]:
    before = [(number, signal.getsignal(number)) for number in SIGNALS]
    yield
    for number, handler in before:
        signal.signal(number, handler)


@pytest.mark.usefixtures("handlers")
@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_ends_it_and_no_file_stays(
    tmp_path: Path, capture: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    def reading(*_: object, **__: object) -> None:
        signal.raise_signal(number)
        pytest.fail("the signal did not end it")

    monkeypatch.setattr(running, "gather", reading)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # where root has a copy of the capture
    assert cli.main(["report", str(capture), "-o", str(tmp_path / "x.txt")]) == 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_no_home_is_no_matter(tmp_path: Path, capture: Path) -> None:
    """Nothing is kept there."""
    (tmp_path / "file").touch()
    nowhere = {"HOME": str(tmp_path / "file"), "XDG_CONFIG_HOME": "", "XDG_CACHE_HOME": ""}
    done = run_anew(tmp_path, "report", capture, **nowhere)
    assert (done.returncode, done.stderr) == (0, "sistap: report.html written\n")


def test_a_window_that_is_none(tmp_path: Path, capture: Path) -> None:
    done = report(tmp_path, capture, "--window", "5")
    assert done.returncode == 2
    assert "'5' is not START+SECONDS, for example 12.5+0.2" in done.stderr


def test_without_tshark_or_its_plugin(tmp_path: Path, capture: Path) -> None:
    refused(report(tmp_path, capture, "--format", "text", PATH=str(tmp_path)), 1, *NO_TSHARK)
    (tmp_path / "plugins").mkdir()
    refused(
        report(tmp_path, capture, "--format", "text", WIRESHARK_PLUGIN_DIR="plugins"),
        1,
        "no dissector for SIS",
        "WIRESHARK_PLUGIN_DIR",
    )
