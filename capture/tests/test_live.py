# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap capture` without -w: what `sistap log` says of the same records, while they come."""

from __future__ import annotations

import os
import pty
import signal
import time
from pathlib import Path

import pytest

from sistap import cli
from sistap.dissected.captures.reading import records
from sistap.dissected.explain import live
from sistap.dissected.explain.live import IN_COLOUR, PLAIN, LiveText, colours
from sistap.dissected.explain.running import Running
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.records.record import Record, Type

PATIENCE_S = 60
LINE = {0: Interface(252, "a line of a test")}


@pytest.fixture(autouse=True)
def _busy_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(live, "PATIENCE_S", PATIENCE_S)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("live") / "x.pcapng"
    assert cli.main(["bus", "late-reaction", "-w", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def traffic(capture: Path) -> list[Record]:
    return list(records(capture))


def logged(path: Path, capture: Path) -> list[str]:
    """Return what `sistap log` writes, without events, and without what only a later telegram tells."""
    assert cli.main(["log", str(capture), "-o", str(path)]) == 0
    lines = path.read_text().splitlines()
    return [line.replace("  [no reaction]", "") for line in lines if not line.startswith("^-- ")]


@pytest.mark.thorough
def test_it_shows_what_log_shows(tmp_path: Path, tshark: Tshark, capture: Path, traffic: list[Record]) -> None:
    path = tmp_path / "live.txt"
    output = Output(str(path))
    text = LiveText(output, tshark, LINE, lambda said: pytest.fail(said))
    text.begin(traffic[0])
    for record in traffic[1:]:
        assert text.write(record) == (record.type != Type.EVENT)
    text.end(0)
    output.close()
    assert path.read_text().splitlines() == logged(tmp_path / "log.txt", capture)


def test_each_record_is_shown_when_it_has_come(tmp_path: Path, tshark: Tshark, traffic: list[Record]) -> None:
    path = tmp_path / "live.txt"
    output = Output(str(path))
    text = LiveText(output, tshark, LINE, lambda said: pytest.fail(said))
    text.begin(traffic[0])
    for number, record in enumerate(traffic[1:6], 1):
        text.write(record)
        end_s = time.monotonic() + PATIENCE_S
        while path.read_text().count("\n") < 2 * number:
            assert time.monotonic() < end_s
            text.look(0)
    text.close()
    output.close()


@pytest.mark.thorough
def test_without_tshark_it_goes_on(
    tmp_path: Path, tshark: Tshark, traffic: list[Record], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The bytes are there, each record once, whatever happens to tshark."""
    path = tmp_path / "live.txt"
    output = Output(str(path))
    said: list[str] = []
    started: list[Running] = []

    class Watched(LiveText):
        def _start(self, token: bytes | None) -> Running:
            started.append(super()._start(token))
            return started[-1]

    text = Watched(output, tshark, LINE, said.append)
    text.begin(traffic[0])
    text.write(traffic[1])
    os.kill(started[0].pid, signal.SIGKILL)
    for record in traffic[2:]:
        text.write(record)
    text.end(0)
    output.close()
    lines = [line for line in path.read_text().splitlines() if "^-- " not in line]
    assert [bytes.fromhex(line.rpartition("  ")[2]) for line in lines] == [record.data for record in traffic[1:]]
    assert any("tshark has ended" in line for line in said)


@pytest.mark.parametrize(
    ("environment", "expected"),
    [
        ({"TERM": "xterm"}, IN_COLOUR),
        ({"TERM": "xterm", "NO_COLOR": ""}, IN_COLOUR),
        ({"TERM": "xterm", "NO_COLOR": "1"}, PLAIN),
        ({"TERM": "dumb"}, PLAIN),
        ({}, PLAIN),
    ],
)
def test_a_terminal_has_colours(environment: dict[str, str], expected: object) -> None:
    master, slave = pty.openpty()
    try:
        assert colours(slave, environment, "linux") == expected
    finally:
        os.close(master)
        os.close(slave)


def test_a_pipe_has_none() -> None:
    reading, writing = os.pipe()
    try:
        assert colours(writing, {"TERM": "xterm"}, "linux") == PLAIN
    finally:
        os.close(reading)
        os.close(writing)


def test_what_is_wrong_has_its_own_colour(tmp_path: Path, tshark: Tshark, traffic: list[Record]) -> None:
    path = tmp_path / "live.txt"
    output = Output(str(path))
    text = LiveText(output, tshark, LINE, lambda said: pytest.fail(said), IN_COLOUR)
    text.begin(traffic[0])
    for record in traffic[1:]:
        text.write(record)
    text.end(0)
    output.close()
    explained = [line for line in path.read_text().splitlines() if "^-- " in line]
    assert {("TrS exceeded" in line or "repeat" in line) == (IN_COLOUR.trouble in line) for line in explained} == {True}
    for colour, what in ((IN_COLOUR.command, "  Command  "), (IN_COLOUR.reaction, "  Reaction  ")):
        assert all(what in line for line in explained if colour in line) and any(colour in line for line in explained)
