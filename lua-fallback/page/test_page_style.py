# SPDX-License-Identifier: GPL-2.0-or-later
"""ESLint and TypeScript find nothing in the scripts of the page, and its parts have the licences that they name."""

from __future__ import annotations

import json
import os
import re
import subprocess
from pathlib import Path

import pytest

SPDX = {"GPLV2": "GPL-2.0-only"}  # what npm's packages say otherwise
PARTS = {"@goodtools/wiregasm": "wiregasm", "pyodide": "Pyodide"}  # as *About* names them


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


def test_licences() -> None:
    """*About* names version and licence of each package as the package does."""
    here = Path(__file__).parent
    packages = json.loads((here / "package-lock.json").read_text())["packages"]
    rows = re.findall(r'^  \["([^"]*)", "([^"]*)", "', (here / "src/front/dialogs.js").read_text(), re.MULTILINE)
    for name, shown in PARTS.items():
        package = packages[f"node_modules/{name}"]
        version, licence = package["version"], package["license"]
        (row,) = (row for row in rows if row[0].startswith(f"{shown} {version}"))
        assert SPDX.get(licence, licence) in row[1].split(", "), row
