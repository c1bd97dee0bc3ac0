# SPDX-License-Identifier: GPL-2.0-or-later
"""Text from elsewhere appears as visible escapes, wherever sistap shows it.

So a terminal obeys none of it, a page shows every line in its place, and JSON stays valid.
"""

from __future__ import annotations

import json
import os
import sys
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path

import pytest
from commands import run
from logs import PHASE
from report_capture import BUS, Sent, records, write

from sistap.commands import doctor
from sistap.commands.extcap import interfaces
from sistap.commands.extcap.interfaces import plain
from sistap.tap import ports as command
from sistap.tap.files import pcapng
from sistap.tap.line import ports
from sistap.tap.line.ports import Adapter
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Event, event
from sistap.tap.sis.telegram import build
from sistap.tap.terminal.console import Console, visible

# A title for the window of a terminal, C1 controls, what turns the direction round, what nobody sees, what ends lines,
# and what a page, a picture and a format take for their own.
ODD = "\x1b]0;x\x07\r\n\t\x7f\x85\x9b\xad\u061c\u200b\u2028\u202e\u2066\ufeff"
HOSTILE = f"<b>&\"'${ODD}$ %s {{0}}"


of_others = pytest.mark.attack(
    "control characters, Unicode direction marks, bad UTF-8: in markers, comments, logs, adapter and interface names",
    "visible escapes; HTML and JSON stay valid",
)


def odd_ones(text: str, keep: str = "\n") -> set[str]:
    """Return the characters that a user would not see."""
    return {character for character in text if not character.isprintable() and character not in keep}


@pytest.mark.thorough
def test_what_cannot_be_seen_is_shown() -> None:
    assert visible("Motor läuft, 12 µs → °C 😀") == "Motor läuft, 12 µs → °C 😀"
    assert visible("\x1b[31m") == r"\x1b[31m"
    assert visible("a\r\nb\tc\x85\u202e\U000e0001") == r"a\r\nb\tc\x85\u202e\U000e0001"
    assert visible(os.fsdecode(b"x\xff")) == r"x\xff"
    assert visible("\ud800") == r"\ud800"
    assert visible("a\tb\n", keep="\t") == "a\tb\\n"
    assert not odd_ones(visible("".join(map(chr, range(sys.maxunicode + 1)))), keep="")


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    """Make a capture whose name, comment, interface and events are hostile."""
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, HOSTILE, HOSTILE, 9600, HOSTILE, HOSTILE)
    blocks = [pcapng.section_header(HOSTILE, HOSTILE), pcapng.interface_description(interface)]
    made = records(BUS)
    marker = event(made[-1].time_ns + 1, 0, LineSettings(), Event.MARKER, HOSTILE)
    cut = marker._replace(data=marker.data + b"\xe2\x80\xff\0")
    blocks += [
        pcapng.enhanced_packet(0, record.time_ns, pcapng.upper_pdu("sertap", record.pack()))
        for record in (*made, marker, cut, marker._replace(event=Event.ADAPTER_LOST))
    ]
    path = tmp_path / os.fsdecode(f"{ODD.replace('/', '')}.pcapng".encode() + b"\xff")
    path.write_bytes(b"".join(blocks))
    return path


@pytest.mark.thorough
@of_others
@pytest.mark.parametrize("kind", ["text", "html", "json"])
def test_a_report(capture: Path, tmp_path: Path, kind: str) -> None:
    done = run(tmp_path, "report", capture, "--format", kind, "-o", "-")
    assert done.returncode == 0, done.stderr
    assert not odd_ones(done.stdout + done.stderr)
    assert r"\u202e" in done.stdout.lower()
    if kind == "json":
        json.loads(done.stdout, parse_constant=pytest.fail)


@pytest.mark.thorough
@of_others
@pytest.mark.parametrize(
    "words",
    [
        "parameters CAPTURE",
        "parameters --csv CAPTURE",
        "parameters --csv --wide CAPTURE",
        "parameters --changes CAPTURE",
        "compare CAPTURE other.pcapng",
        "compare other.pcapng CAPTURE",
        "compare CAPTURE other.pcapng --format html",
        "compare CAPTURE other.pcapng --format json",
        "tables -o tables CAPTURE",
    ],
)
def test_tables_of_a_capture(capture: Path, tmp_path: Path, words: str) -> None:
    accepted = Sent(build(0x1F, 16, 3, bytes.fromhex("00 3C 03"), reaction=True))
    for path, value in ((tmp_path / "other.pcapng", 2), (capture, 3)):
        written = [Sent(build(0x1F, 16, 3, bytes([0x3C, 3, 0, 0x28, 0, step, value]))) for step in (1, 2)]
        write(path, [telegram for command in written for telegram in (command, accepted)])
    done = run(tmp_path, *(capture.name if word == "CAPTURE" else word for word in words.split()))
    assert done.returncode == 0, done.stderr
    assert not odd_ones(done.stdout + done.stderr)


@of_others
def test_a_capture_as_a_log(capture: Path, tmp_path: Path) -> None:
    done = run(tmp_path, "log", capture)
    assert done.returncode == 0, done.stderr
    assert r"\u202e" in done.stdout.lower()
    assert not odd_ones(done.stdout + done.stderr)


@pytest.mark.thorough
@of_others
def test_an_explained_log(tmp_path: Path) -> None:
    """The text output is the unchanged log, with safe lines between; the page is safe as a whole."""
    log = tmp_path / os.fsdecode(f"{ODD}.txt".encode() + b"\xff")
    beside = ODD.replace("\n", "").replace("\r", "")
    text = f"{beside} 12:00:00.000 {PHASE.hex(' ')}\n{HOSTILE}\n"
    log.write_text(text, newline="")
    shown = run(tmp_path, "annotate", log)
    assert shown.returncode == 0, shown.stderr
    said = [line for line in shown.stdout.split("\n") if line not in text.split("\n")]
    assert said and not odd_ones("".join(said) + shown.stderr, keep="\n\t")
    page = run(tmp_path, "annotate", log, "--format", "html", "-o", "-")
    assert page.returncode == 0, page.stderr
    assert not odd_ones(page.stdout + page.stderr, keep="\n\t")
    assert r"\u202e" in page.stdout


NAMED = {
    "report": ["report", "FILE"],
    "annotate": ["annotate", "FILE"],
    "log": ["log", "FILE"],
    "import": ["import", "FILE", "-w", "out"],
    "import, out": ["import", "FILE", "-w", "FILE"],
    "replay": ["replay", "FILE"],
    "bus": ["bus", "FILE"],
    "bus, out": ["bus", "-w", "FILE/x"],
    "capture": ["capture", "-i", "FILE"],
    "capture, out": ["capture", "-i", "/dev/ptmx", "-w", "FILE/x"],
    "doctor": ["doctor", "-i", "FILE"],
    "an option": ["ports", "FILE"],
    "a command": ["FILE"],
    "install": ["install", "--plugin", "FILE"],
}


@pytest.mark.thorough
@pytest.mark.attack("the same in names of files", "visible escapes, in one line")
@pytest.mark.parametrize("there", [False, True])
@pytest.mark.parametrize("command", NAMED.values(), ids=NAMED)
def test_names_of_files_in_what_is_refused(tmp_path: Path, command: list[str], there: bool) -> None:
    """Names as a shell makes them of `*`."""
    name = os.fsdecode(ODD.encode() + b"\xff")
    if there:
        (tmp_path / name).write_bytes(b"no such thing")
    done = run(tmp_path, *(word.replace("FILE", name) for word in command), PYTHONIOENCODING="utf-8:strict")
    assert done.returncode in (1, 2, 3)
    said = done.stdout + done.stderr
    assert not odd_ones(said)
    assert visible(ODD) in said


@of_others
def test_an_adapter_that_somebody_has_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A USB device states its own name."""
    monkeypatch.setattr(ports, "found", lambda: [("/dev/ttyUSB0", Adapter(name=HOSTILE))])
    shown: list[Callable[[], object]] = [
        lambda: command.run(Namespace(json=False)),
        lambda: print(*interfaces.found()),
        lambda: print(*doctor._pyserial()),
    ]
    for show in shown:
        show()
        out = capsys.readouterr().out
        assert r"\u202e" in out and not odd_ones(out)
    assert plain("{\n}") == "( )"


@of_others
def test_what_a_capture_says(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Console, "shows_progress", True)
    tells: list[Callable[[str], None]] = [Console().say, Console().alarm, Console().progress]
    for tell in tells:
        tell(HOSTILE)
        said = capfd.readouterr().err.removeprefix("\r\x1b[K").removesuffix("\n")
        assert r"\u202e" in said and not odd_ones(said, keep="")
