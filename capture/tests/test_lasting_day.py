# SPDX-License-Identifier: GPL-2.0-or-later
"""The benchmark of a day, made short: what comes while the recorder is unplugged, ended and killed is all there."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

DAY = Path(__file__).parent.parent / "benchmark" / "day.py"


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux", reason="it looks into /proc")
def test_a_short_day() -> None:
    done = subprocess.run(
        [sys.executable, str(DAY), "--characters", "60000", "--seed", "2"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "everything else is in exactly one file" in done.stdout
    ends = [line.split()[1] for line in done.stdout.splitlines()[1:-2]]
    assert sorted(ends) == ["ended", "ended", "killed"]
