# SPDX-License-Identifier: GPL-2.0-or-later
"""Our master at a real line: what it waits for, what it accepts as a reaction, when it repeats."""

from __future__ import annotations

import os
import select
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from portable import terminals
from test_bus import BUS, TIMEOUT_S, octets, running

from sisbus.playing.characters import Played
from sisbus.playing.conducting import Script, conduct, repeating
from sisbus.playing.player import Times
from sisbus.wires.talking import UNASKED, RealLine
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.telegram import build

TIMES = Times(trs=50, tza=5, tmas=500)
TWM_NS = 60_000_000
COMMAND = build(0x12, 16, 3)
REACTION = build(0x12, 16, 3, b"\x00\x04", reaction=True)

Reads = Sequence[bytes]


class ScriptedPort:
    """For each command, what is read after it, one after the other; what is there before a command is asked for."""

    def __init__(self, *answers: Reads) -> None:
        self.settings = LineSettings(115200)
        self.sent: list[tuple[float, bytes]] = []
        self.waiting = b""  # what came when nobody listened
        self._answers = list(answers)
        self._reads: list[bytes] = []

    def write(self, data: bytes) -> None:
        self.sent.append((time.monotonic(), data))
        self._reads = list(self._answers.pop(0)) if self._answers else []

    def drain(self) -> None:
        """All was sent."""

    def read(self, timeout_s: float) -> bytes:
        if not timeout_s:
            data, self.waiting = self.waiting, b""
            return data
        if self._reads:
            return self._reads.pop(0)
        time.sleep(timeout_s)
        return b""

    def change(self, settings: LineSettings) -> None:
        self.settings = settings


def ask(port: ScriptedPort, *asked: bytes, repeats: int = 0) -> tuple[list[bytes | None], list[Played]]:
    """Ask; return the reactions and all that was sent and heard."""
    reactions: list[bytes | None] = []

    def script() -> Script:
        for command in asked:
            reactions.append((yield command))

    line = RealLine(port, TIMES)  # type: ignore[arg-type]
    return reactions, list(conduct(line, {16: repeating_and_noting(script(), repeats)}))


def repeating_and_noting(script: Script, repeats: int) -> Script:
    return repeating(script, repeats, TWM_NS)


SWAPPED = build(0x12, 3, 16, b"\x00\x04", reaction=True)
OF_ANOTHER = build(0x12, 16, 4, b"\x00\x04", reaction=True)
OTHER_SERVICE = build(0x00, 16, 3, b"\x00\x04", reaction=True)
DAMAGED = REACTION[:-1] + b"\x05"


@pytest.mark.parametrize(
    ("reads", "reaction"),
    [
        ([REACTION], REACTION),
        ([REACTION[:1], REACTION[1:5], REACTION[5:]], REACTION),
        ([COMMAND + REACTION], REACTION),  # an adapter that hears itself
        ([b"\xff\x00" + REACTION], REACTION),  # noise of the transmitters
        ([SWAPPED], SWAPPED),  # a device may swap the addresses
        ([], None),
        ([DAMAGED], None),
        ([REACTION[:-1]], None),
        ([COMMAND], None),
        ([OF_ANOTHER], None),
        ([OTHER_SERVICE], None),
    ],
)
def test_what_is_taken_for_the_reaction(reads: Reads, reaction: bytes | None) -> None:
    reactions, played = ask(ScriptedPort(reads), COMMAND)
    assert reactions == [reaction]
    heard = b"".join(reads).replace(COMMAND, b"")
    assert b"".join(one.sent for one in played) == COMMAND + heard  # nothing is lost
    assert [one.sent for one in played if not one.marks] == [COMMAND, *([reaction] if reaction else [])]


def test_with_a_number_the_reaction_has_the_same() -> None:
    command = build(0x12, 16, 3, number=5)
    for number, taken in ((5, True), (4, False)):
        said = build(0x12, 16, 3, b"\x00\x04", reaction=True, number=number)
        reactions, _ = ask(ScriptedPort([said]), command)
        assert reactions == [said if taken else None]


def test_what_is_not_answered_is_sent_again_after_trs_and_twm() -> None:
    port = ScriptedPort([], [DAMAGED], [REACTION])
    reactions, _ = ask(port, COMMAND, repeats=2)
    assert reactions == [REACTION]
    assert [data for _, data in port.sent] == [COMMAND] * 3
    times = [when for when, _ in port.sent]
    assert times[1] - times[0] >= 0.05 + 0.06


def test_it_gives_up() -> None:
    port = ScriptedPort()
    reactions, _ = ask(port, COMMAND, repeats=1)
    assert reactions == [None]
    assert len(port.sent) == 2


def test_to_all_is_not_sent_again() -> None:
    port = ScriptedPort()
    ask(port, build(0x03, 16, 255, b"\x00\xff"), repeats=3)
    assert len(port.sent) == 1


def test_what_came_too_late_is_noted_and_answers_nothing() -> None:
    port = ScriptedPort([], [REACTION])
    reactions: list[bytes | None] = []

    def script() -> Script:
        reactions.append((yield COMMAND))
        port.waiting = REACTION
        reactions.append((yield COMMAND))

    played = list(conduct(RealLine(port, TIMES), {16: script()}))  # type: ignore[arg-type]
    assert reactions == [None, REACTION]
    assert [(one.sent, one.marks) for one in played] == [
        (COMMAND, []),
        (REACTION, [UNASKED]),
        (COMMAND, []),
        (REACTION, []),
    ]


def test_it_goes_with_the_rate_that_the_bus_was_told() -> None:
    told = build(0x03, 16, 255, octets("00 07 02"))  # 38400 Bd
    accept = build(0x03, 16, 255, octets("00 FF"))
    port = ScriptedPort()
    ask(port, told)
    assert port.settings.baud == 115200
    port = ScriptedPort()
    ask(port, told, accept)
    assert port.settings.baud == 38400


# -- Through a pseudo terminal ----------------------------------------------------------------------------------------


@contextmanager
def slave(react: Callable[[bytes], bytes]) -> Iterator[str]:
    """A station at the other end of a port, in a few lines of its own."""
    ours, theirs = os.openpty()
    done, stop = os.pipe()

    def answer() -> None:
        heard = b""
        while done not in select.select([ours, done], [], [])[0]:
            heard += os.read(ours, 300)
            while len(heard) >= 8 and len(heard) >= 8 + heard[3]:
                command, heard = heard[: 8 + heard[3]], heard[8 + heard[3] :]
                os.write(ours, react(command))

    thread = threading.Thread(target=answer)
    thread.start()
    try:
        yield os.ttyname(theirs)
    finally:
        os.write(stop, b".")
        thread.join()
        for descriptor in (ours, theirs, done, stop):
            os.close(descriptor)


@terminals
def test_over_a_pseudo_terminal(tmp_path: Path) -> None:
    scenario = tmp_path / "x.toml"
    scenario.write_text(
        'title = ""\n[line]\ntrs_ms = 500\n[[master]]\naddress = 16\nrepeats = 1\n'
        'script = [{ phase = "read", station = 3 }, { phase = "read", station = 4 }, { phase = "read", station = 3 }]'
    )
    log = tmp_path / "log"
    with slave(lambda command: REACTION if command == COMMAND else b"") as port:
        options = [str(scenario), "--port", port, "--transmit", "--log", str(log)]
        done = subprocess.run([*BUS, *options], capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (
        0,
        "4 commands, 2 reactions, 2 commands not answered\n",
        "",
    )
    to_4 = build(0x12, 16, 4)
    said = [octets(line.split()[1]) for line in log.read_text().splitlines()[1:]]
    assert said == [COMMAND, REACTION, to_4, to_4, COMMAND, REACTION]


@terminals
def test_a_line_whose_other_end_goes_away(tmp_path: Path) -> None:
    with running("drives") as (bus, port):
        command = [*BUS, "master", "--port", port, "--transmit", "--log", str(tmp_path / "log")]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as master:
            while not (tmp_path / "log").exists() or (tmp_path / "log").read_text().count("\n") < 3:
                assert master.poll() is None
            bus.kill()
            output, errors = master.communicate(timeout=TIMEOUT_S)
    assert master.returncode == 1
    assert errors.count("\n") == 1
    assert "connect it and start again" in errors
    assert "commands" in output
