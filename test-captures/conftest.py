# SPDX-License-Identifier: GPL-2.0-or-later
"""tshark with the plugin that was built, for all tests here."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from sharkd import Sharkd  # noqa: E402
from sistap.tshark import Tshark  # noqa: E402


@pytest.fixture(scope="session")
def tshark() -> Iterator[Tshark]:
    """Run tshark; it has really loaded the plugin (as root it would skip it without a word)."""
    with Tshark() as program:
        plugins = program.output("-G", "plugins")
        assert "sis.so" in plugins, "tshark does not load sis.so; ./bootstrap test sets WIRESHARK_PLUGIN_DIR"
        yield program


@pytest.fixture(scope="session")
def sharkd(tshark: Tshark) -> Iterator[Sharkd]:
    """Run sharkd, with the plugins that tshark was found to load."""
    with Sharkd() as program:
        yield program
