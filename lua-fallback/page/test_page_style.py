# SPDX-License-Identifier: GPL-2.0-or-later
"""ESLint and TypeScript find nothing in the scripts of the page."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest


@pytest.mark.style
def test_scripts(npm: Path) -> None:
    """ESLint: eslint.config.mjs says what it looks for."""
    program = npm / "node_modules" / "eslint" / "bin" / "eslint.js"
    words = ["node", str(program), "--max-warnings", "0", "."]
    here, environment = Path(__file__).parent, {**os.environ, "NPM": str(npm)}
    done = subprocess.run(words, cwd=here, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.style
def test_types(npm: Path) -> None:
    """TypeScript understands the page: tsconfig.json says which files."""
    program = npm / "node_modules" / "typescript" / "bin" / "tsc"
    words = ["node", str(program), "--project", str(Path(__file__).parent)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
