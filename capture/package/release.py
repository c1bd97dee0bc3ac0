# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts what somebody without the sources needs into build/release. `./bootstrap release` has made the packages before.

Every file is the same each time: the bus of the example has a seed, and files in zips have one time.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

HOUSE = Path(__file__).resolve().parents[2]
BUILD, RELEASE = HOUSE / "build", HOUSE / "build" / "release"
sys.path[:0] = [str(HOUSE / "capture"), str(HOUSE / "capture" / "bundle")]

import contents  # noqa: E402 - of the checkout

from sistap import __version__  # noqa: E402

SCENARIO, SEED = "demo", "3"
FAULTS = "checksum=0.015,pause=0.001,parity=0.001"
SECONDS = "60"
# What was made before, and how to get what is missing.
MADE = {
    f"plugin/sistap_{__version__}*.deb": "the .deb: install dpkg-dev, file and help2man",
    f"dist/sistap-{__version__}-*.whl": "the wheel",
    "sis.html": "the page: ./bootstrap page",
    f"windows/sistap-{__version__}-windows.zip": "the zip for Windows: capture/bundle/build says what it needs",
    f"windows/sistap-{__version__}-setup.exe": "the installer for Windows: capture/bundle/build says what it needs",
}


def sistap(*arguments: str) -> None:
    """Run a command of this checkout. May raise CalledProcessError."""
    subprocess.run([sys.executable, "-m", "sistap", *arguments], cwd=HOUSE / "capture", check=True)


def notes() -> str:
    """Return what is new: the first part of the CHANGELOG. Links to other documents are plain words here."""
    first = re.split(r"^## .*\n", (HOUSE / "CHANGELOG.md").read_text("utf-8"), flags=re.MULTILINE)[1]
    words = re.sub(r"\[([^\]]*)\]\((?!https?:)[^)]*\)", r"\1", first.strip())
    return f"# sistap {__version__}\n\n{words}\n"


def sums() -> str:
    """Return the sums of all files, as sha256sum writes and checks them."""
    files = sorted(path for path in RELEASE.iterdir() if path.is_file())
    return "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files)


def copied() -> bool:
    """Copy what was made before; say what is missing. Return whether all is there."""
    complete = True
    for pattern, cure in MADE.items():
        found = sorted(BUILD.glob(pattern))
        for path in found:
            shutil.copyfile(path, RELEASE / path.name)
        if not found:
            print(f"release: without {cure}", file=sys.stderr)
            complete = False
    return complete


def main() -> int:
    """Fill the folder; return the exit code, 77 if something is missing."""
    shutil.rmtree(RELEASE, ignore_errors=True)
    RELEASE.mkdir(parents=True)
    complete = copied()
    shutil.copyfile(HOUSE / "lua-fallback" / "sis.lua", RELEASE / "sis.lua")
    contents.write_zip(RELEASE / "SIS.zip", ((f"SIS/{file.name}", file) for file in contents.profile()))
    handbook = BUILD / "docs"  # in the zip, too: the page looks for docs beside itself
    pages = ((f"docs/{path.relative_to(handbook).as_posix()}", path) for path in contents.modules(handbook))
    contents.write_zip(RELEASE / f"sistap-{__version__}-handbook.zip", pages)
    demo = RELEASE / "demo.pcapng"
    sistap("bus", SCENARIO, "--seed", SEED, "--faults", FAULTS, "--duration", SECONDS, "-w", str(demo))
    sistap("report", str(demo), "-o", str(RELEASE / "report.html"))
    (RELEASE / "NOTES.md").write_text(notes(), "utf-8")
    for path in RELEASE.iterdir():  # a capture is private, but this one is of a simulated bus
        path.chmod(0o644)
    (RELEASE / "SHA256SUMS").write_text(sums(), "utf-8")
    print((RELEASE / "SHA256SUMS").read_text("utf-8"), end="")
    return 0 if complete else 77


if __name__ == "__main__":
    sys.exit(main())
