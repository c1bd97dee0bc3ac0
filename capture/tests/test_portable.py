# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of tests that Windows cannot run are skipped there, with the reason."""

from __future__ import annotations

from pathlib import Path

import pytest
from portable import lacking


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("import os, sistap.tap.line.ports\nfrom sistap.tap.line.reader import open_reader, pyserial", ""),
        ("from no_such_module import x", "needs no_such_module: No module named 'no_such_module'"),
        ("import os.no_such", "needs os.no_such: "),
        ("from sistap.tap.line import no_such", "needs sistap.tap.line: "),
    ],
)
def test_what_windows_lacks(tmp_path: Path, text: str, reason: str) -> None:
    file = tmp_path / "test_x.py"
    file.write_text(text)
    assert lacking(file, "win32").startswith(reason)
    assert bool(lacking(file, "win32")) == bool(reason)
    assert lacking(file, "linux") == ""
