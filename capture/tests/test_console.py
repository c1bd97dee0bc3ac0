# SPDX-License-Identifier: GPL-2.0-or-later
"""What is said on a terminal."""

from __future__ import annotations

import os
import pty
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest
from portable import descriptors

from sistap.tap.terminal.console import Console

pytestmark = pytest.mark.tap


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    """Yield both ends of a terminal, first that of whoever watches."""
    ends = pty.openpty()
    yield ends
    for descriptor in ends:
        os.close(descriptor)


def shows(master: int, expected: bytes) -> bool:
    """Read as much from the terminal, which may come in pieces, and compare."""
    read = b""
    while len(read) < len(expected):
        read += os.read(master, len(expected) - len(read))
    return read == expected


def test_progress_is_cut_to_the_columns(terminal: tuple[int, int]) -> None:
    master, slave = terminal
    termios.tcsetwinsize(slave, (24, 10))
    Console(slave).progress("0123456789abc")
    assert shows(master, b"\r\x1b[K012345678")


def test_without_a_width_progress_is_whole(terminal: tuple[int, int]) -> None:
    master, slave = terminal
    Console(slave).progress("0123456789abc")
    assert shows(master, b"\r\x1b[K0123456789abc")


def test_a_line_takes_the_place_of_the_progress(terminal: tuple[int, int]) -> None:
    master, slave = terminal
    console = Console(slave)
    console.progress("a")
    console.say("b")
    console.say("c")
    assert shows(master, b"\r\x1b[Ka\r\x1b[Ksistap: b\r\nsistap: c\r\n")


@pytest.mark.parametrize(("term", "can"), [("xterm", True), ("dumb", False)])
def test_progress_needs_a_terminal_that_can(
    terminal: tuple[int, int], monkeypatch: pytest.MonkeyPatch, term: str, can: bool
) -> None:
    monkeypatch.setenv("TERM", term)
    assert Console(terminal[1]).shows_progress == can


def test_no_progress_in_a_file() -> None:
    with open(os.devnull, "wb") as file:
        assert not Console(file.fileno()).shows_progress


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="nothing tells which descriptors are open")
def test_nothing_stays_open(terminal: tuple[int, int]) -> None:
    before = descriptors()
    Console(terminal[1]).say("done")
    assert descriptors() <= before
