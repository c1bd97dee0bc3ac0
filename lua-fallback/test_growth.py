# SPDX-License-Identifier: GPL-2.0-or-later
"""The work for one telegram does not grow with the number of earlier ones: in sis.lua, and over TCP in the plugin."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import parity
from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.sis.telegram import build
from test_exchange import check_many_connections, check_many_routes
from test_packed import COMMAND, MOST_BYTES, written
from test_sequence import OPEN, endless


@pytest.mark.attack("commands through thousands of routers, in sis.lua", "each costs the same")
@pytest.mark.thorough
@pytest.mark.timeout(120)
def test_many_commands_wait_for_their_routers(script: Tshark, tmp_path: Path) -> None:
    """Searching all of them for every command would take minutes."""
    check_many_routes(script, 30_000, tmp_path / "many.pcapng")


@pytest.mark.thorough
def test_a_connection_costs_little(script: Tshark, tmp_path: Path) -> None:
    """Its tables hold only what is there."""
    check_many_connections(script, 15, tmp_path)


@pytest.mark.thorough
def test_transfers_that_nobody_ends_are_forgotten(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """As in the plugin, the oldest is dropped."""
    (tmp_path / "open.txt").write_text(f"{endless(OPEN + 10)}\ncommand 16>3 1F 3C 05 01 00 00 03 04")
    capture = tmp_path / "open.pcapng"
    capture.write_bytes(Scenario(tmp_path / "open.txt").capture())
    parity.check(plugin, script, capture)


@pytest.mark.thorough
def test_a_packet_that_is_too_long_ends_as_bytes(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    long = build(0x60, 16, 3, bytes(240))
    capture = written(tmp_path, long * (MOST_BYTES // len(long) + 3))
    assert len(parity.packets(script, capture, "-Y", "sis.telegrams.many")) == 1
    parity.check(plugin, script, capture)


ENDLESS = bytes.fromhex("02 00 FF FF")  # seems to begin a telegram of 263 characters
SEGMENTS = 4


def write_segments(capture: Path, *payloads: bytes) -> Path:
    """Write TCP segments that follow one another."""
    lines = [f"segment > {payload.hex(' ')}" for payload in payloads]
    capture.with_suffix(".txt").write_text("\n".join(["@link tcp", *lines]))
    capture.write_bytes(Scenario(capture.with_suffix(".txt")).capture())
    return capture


@pytest.mark.attack("TCP segments full of telegrams that seem to begin", "each byte is dissected once")
@pytest.mark.parametrize(
    "noise",
    [
        pytest.param(ENDLESS * 365, id="endless"),
        pytest.param((ENDLESS + COMMAND) * 120, id="good_between"),
        pytest.param(b"\x02" * 1459, id="short", marks=pytest.mark.thorough),
    ],
)
def test_tcp_hands_over_each_byte_once(noise: bytes, plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """Otherwise a few segments take minutes: bytes that were waited for in vain are dissected from the first one."""
    capture = write_segments(tmp_path / "noise.pcapng", COMMAND, *[noise] * SEGMENTS)
    for tshark in (plugin, script):
        shown = tshark.output("-r", str(capture), "-T", "fields", "-e", "tcp.pdu.size")
        sizes = [int(size) for size in re.split(r"[,\s]+", shown.strip())]
        assert len(COMMAND) + (SEGMENTS - 1) * len(noise) < sum(sizes) <= len(COMMAND) + SEGMENTS * len(noise)
    parity.check(plugin, script, capture)


@pytest.mark.parametrize(("dissector", "seconds"), [("plugin", 1), ("script", 3)])
def test_noise_over_tcp_is_quick(
    dissector: str, seconds: float, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    """77 kB; processor time."""
    tshark: Tshark = request.getfixturevalue(dissector)
    capture = write_segments(tmp_path / "noise.pcapng", COMMAND, *[ENDLESS * 365] * 50)
    assert tshark.usage(["-r", str(capture)]).seconds < seconds


def test_many_telegrams_in_a_record_are_quick(script: Tshark, tmp_path: Path) -> None:
    """The time of each was counted from the first character of the record."""
    (tmp_path / "many.txt").write_text(f"telegram {(COMMAND * 4000).hex()}\n" * 4)
    capture = tmp_path / "many.pcapng"
    capture.write_bytes(Scenario(tmp_path / "many.txt").capture())
    assert script.usage(["-r", str(capture)]).seconds < 3
