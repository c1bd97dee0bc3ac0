# SPDX-License-Identifier: GPL-2.0-or-later
"""The lessons of the course, for the page in a browser. README.md says what is where."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
COURSE = HERE.parent / "course"
sys.path[:0] = [str(HERE.parent), *(str(HERE.parents[1] / "capture" / folder) for folder in ("", "tests"))]
