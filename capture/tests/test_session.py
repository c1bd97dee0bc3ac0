# SPDX-License-Identifier: GPL-2.0-or-later
"""Logs of terminal programs with the ASCII protocol: plain text, with and without times in front."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import run

from sistap.commands.annotate.session import SessionReader, is_session
from sistap.commands.annotate.textlog import lines

# A typed session: the drive echoes, and its prompt stands in front of the next command.
TYPED = "BCD:21\nE21:>S-0-0051,7,R\n12.3456\nE21:>P-0-4006,7,W,>\n?1.0000\n?<\nE21:>S-0-0051,7,W,1\n#7004\nE21:>"
EXPLAINED = [
    "^-- Open drive 21",
    "^-- Prompt of drive 21",
    "^-- Read parameter S-0-0051",
    "^-- Answer S-0-0051",
    "^-- Prompt of drive 21",
    "^-- Write parameter P-0-4006, a list",
    "^-- Asks for a list element P-0-4006",
    "^-- List element P-0-4006 = 1.0000",
    "^-- Asks for a list element P-0-4006",
    "^-- End of list P-0-4006",
    "^-- Prompt of drive 21",
    "^-- Write parameter S-0-0051",
    "^-- Error S-0-0051",
    "^-- What to do: ",
    "^-- Prompt of drive 21",
]
TIMED = """\
[2024-05-06 12:00:01.100] TX: BCD:21
[2024-05-06 12:00:01.150] RX: E21:>
[2024-05-06 12:00:02.000] TX: S-0-0051,7,R
[2024-05-06 12:00:02.020] RX: S-0-0051,7,R
[2024-05-06 12:00:02.040] RX: 12.3456
[2024-05-06 12:00:02.050] RX: E21:>
"""


def explanations(text: str) -> list[str]:
    return [line.strip() for line in text.splitlines() if "^--" in line]


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_typed_session(tmp_path: Path, end: str) -> None:
    log = tmp_path / "typed.txt"
    log.write_bytes(TYPED.replace("\n", end).encode())
    done = run(tmp_path, "annotate", "--framing", "ascii", str(log))
    assert done.returncode == 0
    found = explanations(done.stdout)
    assert len(found) == len(EXPLAINED)
    assert all(one.startswith(expected) for one, expected in zip(found, EXPLAINED, strict=True))
    assert "= 12.3456" in found[3]
    assert "0x7004 Operating data cannot be changed" in found[12]


def test_a_session_with_times(tmp_path: Path) -> None:
    log = tmp_path / "timed.txt"
    log.write_text(TIMED)
    found = explanations(run(tmp_path, "annotate", "--framing", "ascii", str(log)).stdout)
    assert found[1] == "^-- Prompt of drive 21  50 ms after the command"
    assert found[3].startswith("^-- Echo")
    assert found[4].endswith("= 12.3456  40 ms after the command")


def test_a_session_as_a_page_and_as_a_capture(tmp_path: Path) -> None:
    log, capture = tmp_path / "typed.txt", tmp_path / "x.pcapng"
    log.write_text(TYPED)
    page = run(tmp_path, "annotate", "--framing", "ascii", "--format", "html", str(log))
    assert page.returncode == 0
    assert "Open drive 21" in page.stdout
    assert 'title="Drive: 21">21</b>' in page.stdout
    assert run(tmp_path, "annotate", "--framing", "ascii", str(log), "-w", str(capture)).returncode == 0
    assert capture.stat().st_size > 0


@pytest.mark.parametrize(
    ("text", "data"),
    [
        ("S-0-0051,7,R", b"S-0-0051,7,R\r\n"),
        ("12:00:01 S-0-0051,7,R", b"S-0-0051,7,R\r\n"),
        ("12:00:01.250 <- 12.3456", b"12.3456\r\n"),
        ("12.3456", b"12.3456\r\n"),  # no time
        ("  2.5", b"  2.5\r\n"),
        ("E21:>", b"E21:>"),  # a prompt has no end
        ("?", b"?"),
        ("°C", b"\xb0C\r\n"),
        ("", b""),
    ],
)
def test_lines(text: str, data: bytes) -> None:
    (line,) = lines([f"{text}\n".encode()])
    assert b"".join(piece.run.data for piece in SessionReader().contents(line).pieces) == data


def test_a_log_in_hexadecimal_is_no_session(tmp_path: Path) -> None:
    assert is_session(TYPED.encode())
    assert not is_session(b"42 43 44 3A 32 31 0D 0A\n")
    log = tmp_path / "hex.txt"
    log.write_text("42 43 44 3A 32 31 0D 0A\n45 32 31 3A 3E\n")
    assert len(explanations(run(tmp_path, "annotate", "--framing", "ascii", str(log)).stdout)) == 2
