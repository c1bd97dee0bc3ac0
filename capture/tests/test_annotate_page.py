# SPDX-License-Identifier: GPL-2.0-or-later
"""The log as a page: the same text, and the meaning of each byte."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from html import escape
from html.parser import HTMLParser
from itertools import combinations
from pathlib import Path

import pytest
from logs import LOGS
from portable import WINDOWS

from sistap.commands.annotate import page

NAME = "a & c.txt" if WINDOWS else "a <b> & c.txt"

# Fig. 6-14 and 8-21, byte by byte, by hand.
SET_RATE = [
    ("02", "frame", "Start character"),
    ("D7", "frame", "Checksum: 0xd7 [correct]"),
    ("03", "frame", "Data length: 3"),
    ("03", "frame", "Data length repetition: 3"),
    ("00", "control", "Telegram control: 0x00 (command, SEND)"),
    ("03", "service", "Initialization of the SIS communication (0x03)"),
    ("10", "address", "Sender address: 16"),
    ("03", "address", "Receiver address: 3"),
    ("04", "object", "Device address: 4"),
    ("07", "service", "Set baud rate (0x07)"),
    ("00", "data", "9600"),
]
PHASE = [
    ("02", "frame", "Start character"),
    ("56", "frame", "Checksum: 0x56 [correct]"),
    ("02", "frame", "Data length: 2"),
    ("02", "frame", "Data length repetition: 2"),
    ("10", "control", "Kind: Reaction telegram"),
    ("92", "service", "Read phase (SYNAX) (0x92)"),
    ("00", "address", "Sender address: 0"),
    ("00", "address", "Receiver address: 0"),
    ("00", "status", "Transmission error-free (0x00)"),
    ("02", "data", "Phase: 2"),
]


class Page(HTMLParser):
    """What is in the page: the text of the log, its marks, and its explanations."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.text = ""
        self.marks: list[tuple[str, str, str]] = []
        self.explanations: list[str] = []
        self.tags: list[str] = []
        self._attributes: dict[str, str | None] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "br"):
            self.tags.append(tag)
        self._attributes = dict(attributes)
        for name, value in attributes:
            assert name not in ("src", "href") and "http" not in (value or "")  # nothing else is needed

    def handle_endtag(self, tag: str) -> None:
        assert self.tags.pop() == tag

    def handle_data(self, data: str) -> None:
        if "pre" not in self.tags:
            return
        if self.tags[-1] == "i":
            self.explanations.append(data)
            self.text = self.text.rstrip(" \t")[:-1]  # and the end of the line in front of it
            return
        if self.tags[-1] == "b":
            self.marks.append((data, str(self._attributes["class"]), str(self._attributes["title"])))
        self.text += data


def made(folder: Path, log: bytes) -> Page:
    (folder / NAME).write_bytes(log)
    command = [sys.executable, "-m", "sistap", "annotate", NAME, "--format", "html"]
    done = subprocess.run(command, cwd=folder, capture_output=True, check=True, env=os.environ)
    text = done.stdout.decode()
    assert f"<h1>{escape(NAME)}</h1>" in text
    return Page(text)


def same(marks: list[tuple[str, str, str]], expected: list[tuple[str, str, str]]) -> None:
    assert [mark[:2] for mark in marks] == [mark[:2] for mark in expected]
    assert all(words in title for (_, _, title), (_, _, words) in zip(marks, expected, strict=True))


def test_each_byte_has_its_field(tmp_path: Path) -> None:
    log = LOGS["docklight"][0]
    found = made(tmp_path, log.encode())
    assert found.tags == []
    same(found.marks[: len(SET_RATE)], SET_RATE)  # over two lines
    same(found.marks[-len(PHASE) :], PHASE)
    assert found.explanations[-1].endswith("phase 2 (parameter mode)  36 ms after the command")
    assert found.text.strip("\n") == log.replace("\r\n", "\n").strip("\n")


@pytest.mark.thorough
def test_foreign_text_is_text(tmp_path: Path) -> None:
    log = '<script>alert("&amp;")</script> \x00 \x1b[31m é\nRX <02><56><02><02><10><92><00><00><00><02> <b title="x">\n'
    found = made(tmp_path, log.encode("latin-1"))
    assert found.text.strip("\n") == log.strip("\n").replace("\x00", "␀").replace("\x1b", "␛")
    assert len(found.explanations) == 1


@pytest.mark.thorough
def test_what_is_no_telegram_and_what_is_damaged(tmp_path: Path) -> None:
    found = made(tmp_path, b"41 42 43 44\n02 57 02 02 10 92 00 00 00 02\n")
    assert found.marks[0] == ("41 42 43 44", "other", "no telegram")
    assert "incorrect, should be 0x56" in found.marks[2][2]
    assert "  [wrong checksum]  " in found.explanations[1]


@pytest.mark.thorough
def test_long_data_put_together_from_pieces_has_its_own_bytes(tmp_path: Path) -> None:
    captures = Path(__file__).parents[2] / "test-captures"
    log = subprocess.run(
        [sys.executable, "-m", "sistap", "log", captures / "sequences.pcapng"], capture_output=True, check=True
    ).stdout
    senders = [mark for mark in made(tmp_path, log).marks if mark[2].startswith("Sender address: ")]
    assert len(senders) > 3
    for shown, kind, title in senders:
        assert kind == "address"
        assert int(shown, 16) == int(re.findall(r"\d+", title)[0])


def _luminance(colour: tuple[float, ...]) -> float:
    """WCAG 2: relative luminance of sRGB, 0 to 1."""
    linear = [value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour]
    return sum(part * value for part, value in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def _rgb(text: str) -> tuple[float, ...]:
    return tuple(int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))


@pytest.mark.parametrize("theme", [0, 1])
def test_text_can_be_read_on_all_colours_in_both_themes(theme: int) -> None:
    roles = [dict(re.findall(r"--(\w+): (#\w{6})", rule)) for rule in re.findall(r":root \{(.*?)\}", page._STYLE)]
    paper, ink = _rgb(roles[theme]["paper"]), _rgb(roles[theme]["ink"])
    share = int(page._TINT, 16) / 255
    for _, colour, _ in page.KINDS.values():
        ground = tuple(share * over + (1 - share) * under for over, under in zip(_rgb(colour), paper, strict=True))
        light, dark = sorted((_luminance(ink), _luminance(ground)), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 4.5
    for role in ("faint", "bad"):
        light, dark = sorted((_luminance(_rgb(roles[theme][role])), _luminance(paper)), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 4.5


def test_kinds_differ_in_more_than_their_hue() -> None:
    """Kinds with the same stroke also differ much in brightness."""
    for (_, one, stroke), (_, other, other_stroke) in combinations(page.KINDS.values(), 2):
        assert stroke != other_stroke or abs(_luminance(_rgb(one)) - _luminance(_rgb(other))) > 0.03
