# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes a PDF from a page in SVG, with chromium. It embeds the fonts."""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from chromium import program


def pdf(svg: str) -> bytes:
    """Return the PDF. Ends the program if there is no chromium."""
    browser = program()
    if browser is None:
        sys.exit("a PDF needs chromium: install the package chromium")
    size = re.search(r'width="([\d.]+mm)" height="([\d.]+mm)"', svg)
    assert size is not None, "the SVG has no size in millimetres"
    style = f"@page {{ size: {size[1]} {size[2]}; margin: 0 }} body {{ margin: 0 }} svg {{ display: block }}"
    with TemporaryDirectory() as folder:
        page, made = Path(folder) / "page.html", Path(folder) / "page.pdf"
        page.write_text(f"<!doctype html><meta charset=utf-8><style>{style}</style>{svg}")
        options = ["--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/profile"]
        options += ["--no-pdf-header-footer", f"--print-to-pdf={made}"]
        subprocess.run([browser, *options, page.as_uri()], check=True, stderr=subprocess.DEVNULL)
        return made.read_bytes()


def digest(svg: str) -> str:
    """Return the last line of the PDF: which SVG it was made from. Readers of PDF pass it over."""
    return f"% {hashlib.sha256(svg.encode()).hexdigest()}\n"
