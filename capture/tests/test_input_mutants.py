# SPDX-License-Identifier: GPL-2.0-or-later
"""Damaged input of every kind but captures: one clear line, never a traceback, and what comes before it is taken.

Seeded: a mutant that fails has its number in the message. Those of `import` are in test_import_mutants.
"""

from __future__ import annotations

import random
import struct
import threading
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from logs import LOGS
from test_import_mutants import PIECES, damaged_bytes

from sisbus import scenarios
from sistap import cli
from sistap.commands.extcap.toolbar import Toolbar
from sistap.commands.install.ledger import Ledger
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.terminal import state
from sistap.tap.terminal.exits import DONE, FAILED, USAGE, Refusal
from sistap.tap.wire import protocol
from sistap.tap.wire.protocol import Decoder, Hello

PATIENCE_S = 60
ONE_LINE, MANY_LINES = 1, 10**6
FEW = {"log": 1, "scenario": 8, "ledger": 50, "wire": 200, "toolbar": 10}  # mutants: what a second allows
HELLO = Hello(10**18, "virtual bus", "uncertainty 1 ms")
WIRE = [
    protocol.pack_hello(HELLO),
    protocol.pack_settings(LineSettings()),
    protocol.pack_read(Read(1, 10**18, b"abc", bytes(3), 5)),
    protocol.pack_time(10**18 + 1),
]
TOOLBAR = [
    struct.pack(">cBHBB", b"T", 0, len(text) + 2, control, command) + text
    for control, command, text in [(0, 0, b""), *((1, 1, b"marker %d" % number) for number in range(20)), (0, 1, b"9")]
]


class Subject(NamedTuple):
    """A kind of input: a whole one, and what a person sees when it is read from a file."""

    whole: bytes
    read: Callable[[Path], int]  # return an exit code, and say why not
    most_lines: int = ONE_LINE  # of standard error


def annotated(path: Path) -> int:
    """Explain a log."""
    return cli.main(["annotate", str(path), "-o", str(path.with_suffix(".out"))])


def played(path: Path) -> int:
    """Play a scenario, for a while."""
    return cli.main(["bus", str(path), "--duration", "0.5", "-w", str(path.with_suffix(".pcapng"))])


def listed(path: Path) -> int:
    """Read the list of what was installed."""
    (state.folder() / "installed.json").parent.mkdir(parents=True, exist_ok=True)
    (state.folder() / "installed.json").write_bytes(path.read_bytes())
    try:
        assert isinstance(Ledger(for_all=False).files, list)
    except Refusal as error:
        assert "\n" not in str(error)
        return FAILED
    return DONE


def heard(path: Path) -> int:
    """Hear what another sistap says over a socket: nothing but ValueError refuses it."""
    content = path.read_bytes()
    decoder = Decoder()
    try:
        for place in range(0, len(content), 5):
            decoder.feed(content[place : place + 5])
    except ValueError as error:
        assert "\n" not in str(error)
        assert str(error).isprintable()
        return FAILED
    return DONE


class Asked:
    """A capture that checks what it is asked for."""

    settings = None

    def mark(self, text: str) -> None:
        assert text.strip()

    def set_rate(self, baud: int | None) -> None:
        assert baud is None or baud > 0


def asked(path: Path) -> int:
    """Take what a toolbar says, to its end."""
    ended = threading.Event()
    toolbar = Toolbar(str(path), None)
    toolbar.when_left(ended.set)
    with toolbar:
        assert ended.wait(PATIENCE_S)
        toolbar.attend(Asked())  # type: ignore[arg-type]
    return DONE


SCENARIO = (Path(scenarios.__file__).parent / "drives.toml").read_bytes()
SUBJECTS = {
    "log": Subject("".join(LOGS["docklight"][0] for _ in range(4)).encode(), annotated, MANY_LINES),
    "scenario": Subject(SCENARIO, played, 3),
    "ledger": Subject(b'{"files": {"/a/sis.so": "00ff", "/b/sistap": "11"}, "folders": ["/a", "/b"]}', listed, 0),
    "wire": Subject(b"".join(WIRE), heard, 0),
    "toolbar": Subject(b"".join(TOOLBAR), asked, MANY_LINES),
}


def damaged(chance: random.Random, whole: bytes) -> bytes:
    """Damage bytes anywhere, or put something into a text."""
    if chance.random() < 0.5:
        return damaged_bytes(chance, whole)
    start, end = sorted(chance.randrange(len(whole)) for _ in range(2))
    piece = chance.choice(PIECES).encode(errors="surrogateescape")
    return whole[:start] + piece + whole[chance.choice((start, start + 1, end)) :]


@pytest.mark.attack(
    "damaged logs, scenarios, lists of installed files, messages from sockets and toolbars",
    "an error message, or ignored",
)
@pytest.mark.parametrize("share", [1, pytest.param(20, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("kind", SUBJECTS)
def test_damaged_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], kind: str, share: int
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(state, "is_root", lambda: False)
    subject = SUBJECTS[kind]
    for seed in range(share * FEW[kind]):
        path = tmp_path / f"{seed}.toml"
        path.write_bytes(damaged(random.Random(seed), subject.whole))
        code = subject.read(path)
        _, said = capfd.readouterr()
        assert code in (DONE, FAILED, USAGE), f"seed {seed}"
        assert "Traceback" not in said, f"seed {seed}"
        assert len(said.splitlines()) <= subject.most_lines, f"seed {seed}: {said}"


@pytest.mark.parametrize("seed", range(20))
def test_what_comes_before_the_damage_is_heard(seed: int) -> None:
    chance = random.Random(seed)
    place = chance.randrange(1, len(WIRE))
    sound = Decoder().feed(b"".join(WIRE[:place]))
    assert len(sound) == place
    content = b"".join(WIRE[:place]) + damaged_bytes(chance, b"".join(WIRE[place:]))
    messages, decoder = [], Decoder()
    try:
        for byte in content:
            messages += decoder.feed(bytes([byte]))
    except ValueError:
        pass
    assert messages[:place] == sound
