# SPDX-License-Identifier: GPL-2.0-or-later
"""tshark with the C plugin that was built, and with sis.lua instead."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "test-captures"), str(HERE.parent / "capture")]

from parity import SCRIPT  # noqa: E402
from sistap.wireshark.tshark import Tshark  # noqa: E402


@pytest.fixture(scope="session")
def plugin() -> Iterator[Tshark]:
    """Run tshark with the C plugin that was built."""
    with Tshark() as tshark:
        plugins = tshark.output("-G", "plugins")
        assert "sis.so" in plugins, "tshark does not load sis.so; ./bootstrap test sets WIRESHARK_PLUGIN_DIR"
        assert "sis.lua" not in plugins, "a sis.lua is installed; these tests bring their own"
        yield tshark


@pytest.fixture(scope="session")
def script(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tshark]:
    """Run tshark with sis.lua, and without the C plugin."""
    folder = tmp_path_factory.mktemp("script")
    shutil.copy(SCRIPT, folder)
    with Tshark(plugins=folder) as tshark:
        plugins = tshark.output("-G", "plugins")
        assert "sis.lua" in plugins, "tshark does not load sis.lua; was it built without Lua?"
        assert "sis.so" not in plugins, "sis.so is installed; sis.lua would leave everything to it"
        yield tshark
