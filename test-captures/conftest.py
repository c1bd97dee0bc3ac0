# SPDX-License-Identifier: GPL-2.0-or-later
"""tshark with the plugin that was built, for all tests here."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "capture" / "tests"), str(HERE.parent / "plugin" / "protocol")]

from sharkd import Sharkd  # noqa: E402

from sistap.dissected.wireshark.tshark import Tshark  # noqa: E402


@pytest.fixture(scope="session")
def tshark() -> Iterator[Tshark]:
    """Run tshark; check that it has loaded the plugin, which it would silently skip as root."""
    with Tshark() as program:
        plugins = program.output("-G", "plugins")
        assert "sis.so" in plugins, "tshark does not load sis.so; ./bootstrap test sets WIRESHARK_PLUGIN_DIR"
        yield program


@pytest.fixture(scope="session")
def sharkd() -> Iterator[Sharkd]:
    """Run sharkd, which must have the plugin."""
    with Sharkd() as program:
        assert program.has_field("sis.start"), "./bootstrap test sets WIRESHARK_PLUGIN_DIR"
        yield program
