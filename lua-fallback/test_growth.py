# SPDX-License-Identifier: GPL-2.0-or-later
"""What sis.lua does for one telegram does not grow with how many it has seen."""

from __future__ import annotations

from pathlib import Path

import pytest

from sistap.wireshark.tshark import Tshark
from test_exchange import check_many_routes


@pytest.mark.thorough
@pytest.mark.timeout(120)
def test_many_commands_wait_for_their_routers(script: Tshark, tmp_path: Path) -> None:
    """Looking through all of them for every command would take minutes."""
    check_many_routes(script, 30_000, tmp_path / "many.pcapng")
