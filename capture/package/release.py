# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts what somebody without the sources needs into build/release. `./bootstrap release` has made the packages before.

Every file is the same each time: the bus of the example has a seed, and files in zips have one time.
"""

from __future__ import annotations

import hashlib
import html
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

HOUSE = Path(__file__).resolve().parents[2]
BUILD, RELEASE = HOUSE / "build", HOUSE / "build" / "release"
sys.path[:0] = [str(HOUSE / "capture"), str(HOUSE / "capture" / "bundle")]

import contents  # noqa: E402 - of the checkout

from sistap import __version__  # noqa: E402

SCENARIO, SEED = "demo", "3"
FAULTS = "checksum=0.015,pause=0.001,parity=0.001"
SECONDS = "60"


class File(NamedTuple):
    """A row of START-HERE.html. `made` is the folder where it was made before; without one it is made here.

    If it was not made, `cure` says what makes it.
    """

    name: str
    whom: str
    how: str
    made: str = ""
    cure: str = ""


_BUNDLE = "capture/bundle/build says what it needs"
FILES = (
    File(
        f"sistap-{__version__}-setup.exe",
        "Windows",
        "Install Wireshark 4.0 or later, then double-click this. It needs no administrator rights and no network. "
        "Then: Start menu > SIS in Wireshark > Demo.",
        "build/windows",
        _BUNDLE,
    ),
    File(
        f"sistap-{__version__}-windows.zip",
        "Windows, in place of the installer",
        "Unpack it, and open README.html in it.",
        "build/windows",
        _BUNDLE,
    ),
    File(
        f"sistap_{__version__}+wireshark*.deb",
        "Debian with the Wireshark that the name says",
        "As root in this folder: apt-get install ./NAME. "
        "Then, not as root: wireshark -C SIS. Double-click SIS demo bus.",
        "build/plugin",
        "build/plugin/cpack.log says why",
    ),
    File(
        "sis.html",
        "Any computer where you may install nothing",
        "Open it in a browser. It reads captures and logs, and has the course.",
        "build",
        "./bootstrap page",
    ),
    File(
        f"sistap-{__version__}-py3-none-any.whl",
        "Other Linux, and macOS",
        "Type: pipx install NAME, then sistap install. The first needs the internet.",
        "build/dist",
        "build/dist.log says why",
    ),
    File(
        "sis.lua",
        "Any Wireshark 4.0 or later",
        "Copy it into the folder that Help > About Wireshark > Folders calls Personal Lua Plugins. Restart Wireshark.",
        "lua-fallback",
        "git checkout lua-fallback",
    ),
    File(
        "SIS.zip",
        "Users of sis.lua",
        "Columns, colours and filters: Edit > Configuration Profiles > Import > from zip file. Do not unpack it.",
    ),
    File("demo.pcapng", "A first look", "A minute of a simulated bus with faults: open it in Wireshark with SIS."),
    File("report.html", "A first look", "What sistap report says about that minute: open it in a browser."),
    File(f"sistap-{__version__}-handbook.zip", "Everybody", "Unpack it, and open docs/index.html in a browser."),
    File("NOTES.md", "Users of an earlier version", "What is new: open it with a text editor."),
)
PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Start here: SIS in Wireshark</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em }}
td, th {{ text-align: left; vertical-align: top; padding: .3em 1em .3em 0 }}
td:last-child {{ white-space: nowrap }}
</style>
</head>
<body>
<h1>Start here: SIS in Wireshark</h1>
<p>{product}</p>
<table>
<tr><th>For whom</th><th>File</th><th>How</th><th>Size</th></tr>
{rows}
</table>
<p>Are the files whole? On Linux type <code>sha256sum -c SHA256SUMS</code> in this folder.</p>
</body>
</html>
"""


def sistap(*arguments: str) -> None:
    """Run a command of this checkout. May raise CalledProcessError."""
    subprocess.run([sys.executable, "-m", "sistap", *arguments], cwd=HOUSE / "capture", check=True)


def notes() -> str:
    """Return what is new: the first part of the CHANGELOG. Its first section, of old names, comes last.

    Links to other documents are plain words here.
    """
    first = re.split(r"^## .*\n", (HOUSE / "CHANGELOG.md").read_text("utf-8"), flags=re.MULTILINE)[1]
    words = re.sub(r"\[([^\]]*)\]\((?!https?:)[^)]*\)", r"\1", first.strip())
    names, *news = re.split(r"\n\n(?=### )", words)
    return "\n\n".join([f"# sistap {__version__}", product(), "## What is new", *news, names]) + "\n"


def product() -> str:
    """Return what it is: the first paragraph of the README."""
    return " ".join((HOUSE / "README.md").read_text("utf-8").split("\n\n")[1].split())


def page() -> str:
    """Return START-HERE.html. Raise ValueError for a file of the folder that no row explains."""
    found = [(path, file) for file in FILES for path in sorted(RELEASE.glob(file.name))]
    if unexplained := set(RELEASE.iterdir()) - {path for path, _ in found}:
        raise ValueError(f"FILES lacks {unexplained}")
    return PAGE.format(product=html.escape(product()), rows="\n".join(row(*one) for one in found))


def row(path: Path, file: File) -> str:
    """Return what the page says of a file."""
    link = f'<a href="{html.escape(path.name)}">{html.escape(path.name)}</a>'
    how = html.escape(file.how.replace("NAME", path.name))
    kilobytes = path.stat().st_size / 1000
    size = f"{kilobytes / 1000:.1f} MB" if kilobytes > 100 else f"{kilobytes:.0f} kB"
    return f"<tr><td>{html.escape(file.whom)}</td><td>{link}</td><td>{how}</td><td>{size}</td></tr>"


def sums() -> str:
    """Return the sums of all files, as sha256sum writes and checks them."""
    files = sorted(path for path in RELEASE.iterdir() if path.is_file())
    return "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in files)


def copied() -> bool:
    """Copy what was made before; say what is missing. Return whether all is there."""
    complete = True
    for file in filter(lambda file: file.made, FILES):
        found = sorted((HOUSE / file.made).glob(file.name))
        for path in found:
            shutil.copyfile(path, RELEASE / path.name)
        if not found:
            print(f"release: not made: {file.name.replace('*', 'VERSION')}: {file.cure}", file=sys.stderr)
            complete = False
    return complete


def main() -> int:
    """Fill the folder; return the exit code, 77 if something is missing."""
    shutil.rmtree(RELEASE, ignore_errors=True)
    RELEASE.mkdir(parents=True)
    complete = copied()
    contents.write_zip(RELEASE / "SIS.zip", ((f"SIS/{file.name}", file) for file in contents.profile()))
    handbook = BUILD / "docs"  # in the zip, too: the page looks for docs beside itself
    pages = ((f"docs/{path.relative_to(handbook).as_posix()}", path) for path in contents.modules(handbook))
    contents.write_zip(RELEASE / f"sistap-{__version__}-handbook.zip", pages)
    demo = RELEASE / "demo.pcapng"
    sistap("bus", SCENARIO, "--seed", SEED, "--faults", FAULTS, "--duration", SECONDS, "-w", str(demo))
    sistap("report", str(demo), "-o", str(RELEASE / "report.html"))
    (RELEASE / "NOTES.md").write_text(notes(), "utf-8")
    (RELEASE / "START-HERE.html").write_text(page(), "utf-8")
    (RELEASE / "SHA256SUMS").write_text(sums(), "utf-8")
    for path in RELEASE.iterdir():  # a capture is private, but this one is of a simulated bus
        path.chmod(0o644)
    print((RELEASE / "SHA256SUMS").read_text("utf-8"), end="")
    return 0 if complete else 77


if __name__ == "__main__":
    sys.exit(main())
