# SPDX-License-Identifier: GPL-2.0-or-later
"""Which files of tests cannot run on this system, and why: a module that they import is not for it."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

# Those that import nothing special.
_REASONS = {"test_stop.py": "needs SIGHUP, which Windows has not"}


def lacking(file: Path, system: str = sys.platform) -> str:
    """Say what a file of tests needs and Windows has not; nothing if it can run. Elsewhere it is an error."""
    if system != "win32":
        return ""
    if file.name in _REASONS:
        return _REASONS[file.name]
    for module, name in _imported(file):
        try:
            loaded = importlib.import_module(module)
            if name and not hasattr(loaded, name):
                importlib.import_module(f"{module}.{name}")
        except ImportError as error:
            return f"needs {module}: {error}"
    return ""


def _imported(file: Path) -> Iterator[tuple[str, str]]:
    """Yield the modules that it imports at its beginning, each with a name that it takes from it."""
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)
