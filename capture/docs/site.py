#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the site: the documents as they lie beside the code, put together by Sphinx.

site.py OUT: the documents are first copied into build/site, with an index. Every warning is an error, so every link
leads somewhere.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from generate import FOLDERS, HOUSE, files  # noqa: E402 - beside this

SOURCE = HOUSE / "build" / "site"
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
COPIED = (".md", ".png", ".gif", ".svg", ".pdf")

# The chapters, and the pages of each in their order.
CHAPTERS = {
    "Begin": "capture/docs/start capture/docs/wiring capture/docs/troubleshooting test-captures/pages/glossary",
    "Record": "capture/README capture/docs/record capture/docs/wireshark capture/docs/recorder capture/docs/values"
    " capture/docs/remote capture/docs/analyser capture/docs/framings capture/docs/times capture/docs/line-errors"
    " capture/docs/files capture/docs/windows capture/docs/bus",
    "Analyse": "capture/docs/report capture/docs/kinds capture/docs/analyse capture/docs/logs capture/docs/import"
    " capture/docs/usb capture/sistap/commands/tables/README",
    "Wireshark": "plugin/README plugin/docs/filters plugin/docs/statistics plugin/docs/verdicts plugin/docs/telegrams"
    " plugin/docs/exchanges plugin/docs/synax200 plugin/docs/synax200-objects plugin/docs/record plugin/docs/rows"
    " lua-fallback/README lua-fallback/page/README",
    "Reference": "plugin/REFERENCE capture/docs/commands capture/docs/commands/*"
    " capture/sisbus/scenarios/README capture/sisbus/devices/sets/README"
    " capture/docs/library",
    "Learn": "test-captures/README test-captures/course/*",
    "Teach": "test-captures/teacher test-captures/course/solutions/*",
    "Change it": "CONTRIBUTING SECURITY CHANGELOG */DEVELOP */FILES capture/benchmark/README capture/bundle/README"
    " capture/drivers/README capture/launcher/README capture/sisbus/README capture/windows/README"
    " capture/tests/real-captures/README test-captures/fuzz/README test-captures/pages/README",
}


def chapter(name: str, pages: str) -> str:
    """Return the table of contents of a chapter, which only the menu shows."""
    found: list[str] = []
    for pattern in pages.split():
        there = sorted(path.relative_to(SOURCE).with_suffix("").as_posix() for path in SOURCE.glob(f"{pattern}.md"))
        assert there, f"no page {pattern}"
        found += there
    return f"```{{toctree}}\n:caption: {name}\n:hidden:\n\n" + "\n".join(found) + "\n```\n"


def linked(text: str, path: Path) -> str:
    """Return a document whose links to sources are plain words: the site has no sources."""

    def link(found: re.Match[str]) -> str:
        place = found[3].partition("#")[0]
        target = (path.parent / place).resolve()
        stays = "://" in found[3] or not place or (target.suffix in COPIED and target.is_file())
        return found[0] if stays else found[2]

    return LINK.sub(link, text)


def documents() -> Iterator[str]:
    """Return the documents and pictures that git knows, and those that it will."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=HOUSE, check=True, capture_output=True, text=True).stdout.splitlines()
    return (name for name in sorted(set(names)) if Path(name).suffix in COPIED and (HOUSE / name).is_file())


def copy() -> None:
    """Copy the documents into build/site, and add what only the site has."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    for name in documents():
        place = SOURCE / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if place.suffix == ".md":
            place.write_text(linked((HOUSE / name).read_text("utf-8"), HOUSE / name), "utf-8")
        else:
            shutil.copyfile(HOUSE / name, place)
    for folder in FOLDERS:
        (SOURCE / folder / "FILES.md").write_text(files(folder), "utf-8")
    (SOURCE / "capture/package/README.index.md").unlink()  # of the package index
    readme = SOURCE / "README.md"
    index = readme.read_text("utf-8") + "\n" + "\n".join(chapter(name, pages) for name, pages in CHAPTERS.items())
    (SOURCE / "index.md").write_text(index, "utf-8")
    readme.unlink()
    for path in SOURCE.rglob("*.md"):  # links to the first page
        up = os.path.relpath(SOURCE / "README.md", path.parent)
        path.write_text(path.read_text("utf-8").replace(f"]({up}", f"]({up.replace('README', 'index')}"), "utf-8")


def main() -> int:
    """Make the site; return the exit code."""
    out = Path(sys.argv[1]).resolve()
    copy()
    shutil.rmtree(out, ignore_errors=True)
    sphinx = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-E", "-d", str(HOUSE / "build" / "doctrees")]
    made = subprocess.run([*sphinx, "-c", str(Path(__file__).parent), str(SOURCE), str(out)], check=False)
    (out / ".buildinfo").unlink(missing_ok=True)
    return made.returncode


if __name__ == "__main__":
    sys.exit(main())
