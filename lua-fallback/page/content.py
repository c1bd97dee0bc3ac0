# SPDX-License-Identifier: GPL-2.0-or-later
"""Prints what the page takes from Python when it is built, as JSON: the course, and the styles of sistap's pages."""

from __future__ import annotations

import json
import sys
from pathlib import Path

TOP = Path(__file__).parents[2]
sys.path[:0] = [str(TOP / "test-captures"), str(TOP / "capture")]

from pages.content import content  # noqa: E402
from sistap.commands.compare import page as of_comparison  # noqa: E402
from sistap.commands.report import page as of_report  # noqa: E402

if __name__ == "__main__":
    json.dump(
        {"styles": [of_report.style(), of_comparison.STYLE], "course": content(TOP / "build" / "course")}, sys.stdout
    )
