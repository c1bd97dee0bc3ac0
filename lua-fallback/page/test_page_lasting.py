# SPDX-License-Identifier: GPL-2.0-or-later
"""Long captures in the page: memory stays bounded, and what is saved is what was heard."""

from __future__ import annotations

import os
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from make import HERE as CAPTURES
from sistap.dissected.captures.reading import records
from sistap.tap.records.record import Type

HOURS = float(os.environ.get("SIS_PAGE_HOURS", "0.2"))  # what README.md says is of 8
MB = 1_000_000

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(600 + 600 * HOURS)]


def heard(capture: Path) -> bytes:
    """Return the characters of a capture."""
    return b"".join(record.data for record in records(capture) if record.type != Type.EVENT)


def test_hours_at_a_port(node: Callable[..., Any], tmp_path: Path) -> None:
    telegrams, out = tmp_path / "telegrams", tmp_path / "out.pcapng"
    telegrams.write_bytes(heard(CAPTURES / "accesses.pcapng"))
    found = node("hours.mjs", telegrams, str(HOURS), out)
    assert found["characters"] >= int(HOURS * 3600 * 19200 / 11)
    digest = sha256()
    for record in records(out):
        if record.type != Type.EVENT:
            digest.update(record.data)
    assert digest.hexdigest() == found["hash"]
    (python, script), *_, (python_later, script_later) = found["heaps"]
    assert python_later <= python + 8 * MB
    assert script_later <= script + 8 * MB
