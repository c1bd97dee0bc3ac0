# SPDX-License-Identifier: GPL-2.0-or-later
"""Verdicts on what really went through sistap: the virtual bus sets its limits itself, the truth is what it sent."""

from __future__ import annotations

import itertools
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from random import Random
from threading import Thread

import pytest

from adapter import EXCEEDED, OK, UNRESOLVED, Adapter, seen
from sisbus.playing.characters import Faults
from sisbus.scenarios.scenario import DEFAULT, Playing, load
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.wire import protocol
from tables import shown

SISTAP = [sys.executable, "-m", "sistap"]
TIMEOUT_S = 30
MS = 1_000_000
HELLO = protocol.Hello(0, "virtual bus", "as the bus says")
LINE = LineSettings()  # 9600 8E1: the bus sets TzA 5 ms and TrS 50 ms
CYCLES = 4
ACCEPT = bytes.fromhex("02 E9 02 02 00 03 10 FF 00 FF")  # fig. 6-24
FIELDS = "checksum tza.limit tza.verdict trs.limit trs.verdict"


def record(port: str, capture: Path) -> None:
    """Capture until the bus ends, which is exit code 1: an unplugged adapter."""
    command = [*SISTAP, "capture", "-q", "-i", port, "-w", str(capture)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert done.returncode == 1, done.stderr


def telegrams(tshark: Tshark, capture: Path) -> list[dict[str, str]]:
    """Return what tshark says of the telegrams."""
    return [cells for cells in shown(tshark, capture, FIELDS).values() if "checksum" in cells]


def judge(found: Sequence[dict[str, str]], sent: Sequence[bytes], paused: Sequence[bool]) -> list[tuple[int, int]]:
    """Check who has limits, and that no verdict is against the truth; return each verdict of TzA with the true one."""
    accepted_at = sent.index(ACCEPT)
    verdicts = []
    for number, (cells, telegram, pause) in enumerate(zip(found, sent, paused, strict=True)):
        # Set for each drive, accepted by all: nothing is known of what is for all.
        limited = number > accepted_at and telegram != ACCEPT
        assert cells.get("tza.limit") == ("0.005000000" if limited else None), number
        reaction = limited and telegram[4] & 0x17 == 0x10  # and not routed
        assert cells.get("trs.limit") == ("0.050000000" if reaction else None), number
        if reaction:
            assert int(cells["trs.verdict"]) in (OK, UNRESOLVED), number  # all come 6 to 11 ms after their command
        if limited:
            true, verdict = EXCEEDED if pause else OK, int(cells["tza.verdict"])
            assert verdict in (true, UNRESOLVED), f"telegram {number}: verdict {verdict}, true is {true}"
            verdicts.append((verdict, true))
    return verdicts


@contextmanager
def running(*options: str) -> Iterator[str]:
    """Run `sistap bus`; return its name."""
    process = subprocess.Popen([*SISTAP, "bus", *options], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


@pytest.mark.thorough
@pytest.mark.parametrize("most", [1, 10])
def test_the_virtual_bus(most: int, tshark: Tshark, tmp_path: Path) -> None:
    """Its log marks each pause inside a telegram: one and a half times TzA at least, all else is far below it."""
    log, capture = tmp_path / "log", tmp_path / "bus.pcapng"
    options = ["--fast", "--cycles", str(CYCLES), "--reads", str(most), "--faults", "pause=0.01", "--log", str(log)]
    with running("--listen", str(tmp_path / "bus"), *options) as port:
        record(port, capture)
    entries = [line.split() for line in log.read_text().splitlines() if line[0] != "#" and "ascii" not in line]
    sent, paused = [bytes.fromhex(entry[1]) for entry in entries], [len(entry) > 2 for entry in entries]
    verdicts = judge(telegrams(tshark, capture), sent, paused)
    assert {true for _, true in verdicts} == {OK, EXCEEDED}
    if most == 1:  # then every time is exact
        assert all(verdict == true for verdict, true in verdicts)
    assert {verdict for verdict, _ in verdicts} >= {OK, EXCEEDED}


@contextmanager
def tapped(reads: Sequence[Read]) -> Iterator[str]:
    """Be a bus at a socket that delivers these reads to the first tap; return its name."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def deliver() -> None:
            connection, _ = listener.accept()
            with connection:
                connection.sendall(protocol.pack_hello(HELLO))
                connection.recv(64)  # the tap's line settings
                connection.sendall(b"".join(map(protocol.pack_read, reads)))
                connection.shutdown(socket.SHUT_WR)
                while connection.recv(64):
                    pass

        thread = Thread(target=deliver, daemon=True)
        thread.start()
        yield f"bus://127.0.0.1:{listener.getsockname()[1]}"
        thread.join(TIMEOUT_S)


ADAPTERS = {
    "1 ms": (Adapter(MS, 100_000), {OK, EXCEEDED}),
    "16 ms": (Adapter(16 * MS, 300_000), {UNRESOLVED}),
    "a reader that stalls": (Adapter(MS, 100_000, stall_ns=90 * MS), {OK, EXCEEDED, UNRESOLVED}),
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", ADAPTERS)
def test_coarse_reads(name: str, tshark: Tshark, tmp_path: Path) -> None:
    """Reads bring ends and beginnings of telegrams together, whole exchanges after a stall."""
    adapter, needed = ADAPTERS[name]
    everything = list(load(DEFAULT).play(LINE, Playing(1, CYCLES, Faults(pause=0.01))))
    arrived = [character for played in everything for character in played.characters]
    start_ns = 1_700_000_000_000_000_000
    characters = seen([start_ns + character.time_ns for character in arrived], adapter, Random(name))
    reads = []
    for time_ns, group in itertools.groupby(zip(characters, arrived, strict=True), key=lambda pair: pair[0].time_ns):
        pairs = list(group)
        values, flags = (bytes(values) for values in zip(*((one.value, one.flags) for _, one in pairs), strict=True))
        reads.append(Read(0, time_ns, values, flags, max(tap.uncertainty_ns for tap, _ in pairs)))
    with tapped(reads) as port:
        record(port, tmp_path / "bus.pcapng")
    said = [played for played in everything if "ascii" not in played.marks]
    found = telegrams(tshark, tmp_path / "bus.pcapng")
    verdicts = judge(found, [played.sent for played in said], [bool(played.marks) for played in said])
    assert {verdict for verdict, _ in verdicts} >= needed
