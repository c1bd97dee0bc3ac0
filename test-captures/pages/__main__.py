# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the pages of the course: python3 -m pages [FOLDER]."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

from sharkd import Sharkd

import sistap
from lesson import recording
from pages import COURSE, HERE, page, questions
from pages.dissection import dissection
from sistap.wireshark.tshark import TsharkError

SISTAP = Path(sistap.__file__).parent
BUILT = HERE.parents[1] / "build" / "course"


def lessons() -> list[questions.Lesson]:
    """Read all lessons, in their order."""
    return [questions.read(path) for path in sorted(COURSE.glob("[0-9][0-9]-*.md"))]


def captured(lesson: questions.Lesson, folder: Path) -> questions.Lesson:
    """Have the virtual bus write the capture of a lesson that has none beside it."""
    arguments = recording(lesson.path)
    if not arguments:
        return lesson
    capture = folder / lesson.capture.name
    arguments[arguments.index("-w") + 1] = str(capture.absolute())
    command = [sys.executable, "-m", "sistap", *arguments, "--force"]
    played = subprocess.run(command, cwd=SISTAP.parent, capture_output=True, text=True, check=False)
    if played.returncode:
        raise OSError(played.stderr.strip())
    capture.chmod(0o644)  # tshark may run as nobody
    return lesson._replace(capture=capture)


def build(folder: Path) -> list[Path]:
    """Write all pages, the captures that they need, and the poster that they link; return the pages."""
    folder.mkdir(parents=True, exist_ok=True)
    known = [captured(lesson, folder) for lesson in lessons()]
    written = {folder / "index.html": page.index_page(known)}
    with Sharkd() as sharkd:
        if not sharkd.has_field("sis.start"):
            raise TsharkError("tshark does not load the plugin: run ./bootstrap demo, or set WIRESHARK_PLUGIN_DIR")
        for lesson in known:
            text = page.lesson_page(lesson, known, dissection(sharkd, lesson))
            written[folder / f"{lesson.path.stem}.html"] = text
    for path, text in written.items():
        page.write(path, text)
    shutil.copyfile(COURSE / page.POSTER, folder / page.POSTER)
    return list(written)


def main() -> int:
    """Build, and say what to open."""
    parser = argparse.ArgumentParser(prog="python3 -m pages", description="Make the pages of the course.")
    parser.add_argument(
        "folder", nargs="?", type=Path, default=BUILT, metavar="FOLDER", help="where to (default: build/course)"
    )
    arguments = parser.parse_args()
    try:
        build(arguments.folder)
    except (TsharkError, OSError, ValueError) as error:
        print(f"pages: {error}", file=sys.stderr)
        return 1
    print(f"Open {arguments.folder / 'index.html'} in a browser.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
