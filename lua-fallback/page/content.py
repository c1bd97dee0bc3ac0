# SPDX-License-Identifier: GPL-2.0-or-later
"""Prints what the page takes from Python when it is built, as JSON: the course, and the style of reports."""

from __future__ import annotations

import json
import sys
from pathlib import Path

TOP = Path(__file__).parents[2]
sys.path[:0] = [str(TOP / "test-captures"), str(TOP / "capture")]

from pages.content import content  # noqa: E402
from sistap.report.page import style  # noqa: E402

if __name__ == "__main__":
    json.dump({"reportStyle": style(), "course": content(TOP / "build" / "course")}, sys.stdout)
