# SPDX-License-Identifier: GPL-2.0-or-later
"""The pages that come with sistap: the page for a browser, and the handbook."""

from __future__ import annotations

from pathlib import Path

PAGE = "sis.html"
HANDBOOK = "docs/index.html"

_TOP = Path(__file__).resolve().parents[4]  # the checkout, or the bundle for Windows
FOLDERS = (_TOP / "build", _TOP, Path("/usr/share/doc/sistap"))


def found(name: str) -> Path | None:
    """Return where a page is, if it is here."""
    return next((folder / name for folder in FOLDERS if (folder / name).is_file()), None)
