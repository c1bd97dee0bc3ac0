# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua beside the C plugin, beside a copy of itself, and in a Wireshark that is too old."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

import parity
from make import HERE
from parity import SCRIPT
from sistap.dissected.wireshark.tshark import Tshark

CAPTURE = HERE / "specification.pcapng"


def is_silent(tshark: Tshark) -> bool:
    """Tell whether there is one line and no more about a script that does nothing."""
    lines = tshark.run(["-r", str(CAPTURE)]).stderr.splitlines()
    return len(lines) == 1 and lines[0].endswith("is there already, so this copy does nothing")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a plugin folder with sis.lua."""
    made = tmp_path / "plugins"
    made.mkdir()
    shutil.copy(SCRIPT, made)
    return made


@pytest.mark.thorough
def test_beside_the_plugin(folder: Path, plugin: Tshark) -> None:
    shutil.copytree(os.environ["WIRESHARK_PLUGIN_DIR"], folder, dirs_exist_ok=True)
    with Tshark(plugins=folder) as both:
        plugins = both.output("-G", "plugins")
        assert "sis.so" in plugins
        assert "sis.lua" in plugins
        assert is_silent(both)
        parity.check(plugin, both, CAPTURE)


def test_beside_a_copy(folder: Path, script: Tshark) -> None:
    shutil.copy(SCRIPT, folder / "sis-copy.lua")
    with Tshark(plugins=folder) as both:
        assert is_silent(both)
        parity.check(script, both, CAPTURE)


def test_old_wireshark(folder: Path) -> None:
    (folder / "a.lua").write_text('function get_version() return "3.6.2" end')
    with Tshark(plugins=folder) as old:
        done = old.run(["-r", str(CAPTURE)])
    assert done.returncode == 0
    assert "sis.lua needs Wireshark 4.0 or later, this is 3.6.2" in done.stderr
    assert "Exported PDU" in done.stdout
