# SPDX-License-Identifier: GPL-2.0-or-later
"""The work of sis.lua for one telegram does not grow with the number of earlier ones."""

from __future__ import annotations

from pathlib import Path

import pytest

import parity
from make import Scenario
from sistap.sis.telegram import build
from sistap.wireshark.tshark import Tshark
from test_exchange import check_many_routes
from test_packed import MOST_BYTES, written
from test_sequence import OPEN, endless


@pytest.mark.attack("commands through thousands of routers, in sis.lua", "each costs the same")
@pytest.mark.thorough
@pytest.mark.timeout(120)
def test_many_commands_wait_for_their_routers(script: Tshark, tmp_path: Path) -> None:
    """Searching all of them for every command would take minutes."""
    check_many_routes(script, 30_000, tmp_path / "many.pcapng")


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
