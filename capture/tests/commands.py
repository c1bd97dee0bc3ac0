# SPDX-License-Identifier: GPL-2.0-or-later
"""A command of sistap as a process of its own, and how it refuses."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path


def run(folder: Path, *arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run `sistap` in a folder; never a traceback."""
    done = subprocess.run(
        [sys.executable, "-m", "sistap", *map(str, arguments)],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert "Traceback" not in done.stderr
    return done


def refused(done: subprocess.CompletedProcess[str], code: int, *words: str) -> None:
    """It said one line, with these words, and nothing else."""
    assert done.returncode == code
    assert done.stdout == ""
    assert done.stderr.startswith("sistap: ")
    assert done.stderr.count("\n") == 1
    assert all(word in done.stderr for word in words)
