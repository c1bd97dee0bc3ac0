# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the pages of the course: python3 -m pages [FOLDER]."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path

from sharkd import Sharkd

from pages import COURSE, HERE, page, questions
from pages.dissection import capture, dissection
from sistap.wireshark.tshark import TsharkError

BUILD = HERE.parents[1] / "build"


def lessons() -> list[questions.Lesson]:
    """Read all lessons, in their order."""
    return [questions.read(path) for path in sorted(COURSE.glob("[0-9][0-9]-*.md"))]


def build(folder: Path) -> list[Path]:
    """Write all pages, and the papers for the wall that they link; return what was written."""
    folder.mkdir(parents=True, exist_ok=True)
    known = lessons()
    written = {folder / "index.html": page.index_page(known)}
    with Sharkd() as sharkd:
        if not sharkd.has_field("sis.start"):
            raise TsharkError("tshark does not load the plugin: run ./bootstrap demo, or set WIRESHARK_PLUGIN_DIR")
        for lesson in known:
            text = page.lesson_page(lesson, known, dissection(sharkd, lesson, capture(lesson, folder)))
            written[folder / f"{lesson.path.stem}.html"] = text
    for path, text in written.items():
        page.write(path, text)
    for name, _ in page.PAPERS:
        shutil.copyfile(COURSE / name, folder / name)
    return list(written)


def main() -> int:
    """Build, and say what to open."""
    parser = argparse.ArgumentParser(prog="python3 -m pages", description="Make the pages of the course.")
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        default=BUILD / "course",
        metavar="FOLDER",
        help="where to (default: build/course)",
    )
    arguments = parser.parse_args()
    if (plugin := BUILD / "wireshark").is_dir():
        os.environ.setdefault("WIRESHARK_PLUGIN_DIR", str(plugin))
    try:
        build(arguments.folder)
    except PermissionError as error:
        print(
            f"pages: cannot write {error.filename}: name a folder of yours: python3 -m pages ~/sis-course",
            file=sys.stderr,
        )
        return 1
    except (TsharkError, OSError, ValueError) as error:
        print(f"pages: {error}", file=sys.stderr)
        return 1
    print(f"Open {arguments.folder / 'index.html'} in a browser.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
