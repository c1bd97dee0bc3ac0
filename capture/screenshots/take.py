#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Takes the pictures of Wireshark in the READMEs: what a user sees after `sistap install`."""

from __future__ import annotations

import argparse
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple, NoReturn

from screen import Screen
from user import Broken, User

DESCRIPTION = """\
Take pictures of Wireshark as a user sees it after `sistap install`, with the plugin from the build, into
build/screenshots. Fails if a window does not appear. Whether the pictures are good, a person must judge.

The telegrams are always the same: those of the virtual bus, with faults, in simulated time. A live capture differs.
"""

EPILOG = """\
exit status:
  0  done
  1  a window did not come up, or something is missing
  2  wrong usage
"""

REPOSITORY = Path(__file__).resolve().parents[2]
OUTPUT = REPOSITORY / "build/screenshots"
PROGRAMS = {  # and their packages
    "wireshark": "wireshark",
    "tshark": "tshark",
    "Xvfb": "xvfb",
    "openbox": "openbox",
    "xdotool": "xdotool",
    "import": "imagemagick",
}
PLUGIN = "build/plugin/plugin/sis.so"
INSTALLED_FROM = ("capture/sistap", "capture/sisbus", "lua-fallback/sis.lua", PLUGIN, "build/plugin/plugin/sis.version")
PYTHON = "/usr/bin/python3"  # every user may run it, and it has pyserial
DEMO_BUS = "sistap-demo"

DEMO = "demo.pcapng"
RECORDS = 1200  # 40 s of the bus
BUS = "--listen 127.0.0.1:0 --fast --seed 3 --faults checksum=0.015,pause=0.001,parity=0.001"
# A reaction with a value and too long a pause; with this seed, other faults follow it.
LATE = 'sis.tza.verdict == 1 && sis.control.reaction == 1 && sis.value contains "rpm"'

LIVE_BYTES = 45_000  # of a capture: about 9 s, when names and units are known

# In the tree: open the last protocol, SIS, and in it the last branch, Timing. Go to the item before, the value. Scroll
# to the end. Move the mouse away, because the item below it has another colour.
OPEN_TREE = (
    "mousemove --window {window} 300 820 click 1 key Home End Right End Right Up click --repeat 20 5 mousemove 0 0"
)
THE_GEAR = "mousemove --window {window} 53 78 click 1"


class Step(NamedTuple):
    """A window, and the action in it."""

    title: str  # a regular expression
    do: str  # words of xdotool; {window}: its number


class Picture(NamedTuple):
    """A picture of a window: how to get there, and how to show it."""

    file: str  # its path in the repository
    arguments: str  # of wireshark
    title: str
    width: int
    height: int
    way: tuple[Step, ...] = ()  # through other windows
    do: str = ""  # words of xdotool, before the picture is taken
    is_live: bool = False  # taken during a live capture


MAIN = f"^{DEMO}$"
CONVERSATIONS = Step(MAIN, "key Escape alt+s Down Down Down Return")
OPTIONS = (Step("^The Wireshark Network Analyzer$", "key ctrl+k"), Step("Capture Options", THE_GEAR))
PICTURES = (
    Picture("plugin/pictures/wireshark.png", f"-r {DEMO} -J '{LATE}'", MAIN, 1500, 900, do=OPEN_TREE),
    Picture("plugin/pictures/reactions.png", f"-r {DEMO} -z sis,srt", "SIS Service Response Time", 800, 300),
    Picture("plugin/pictures/conversations.png", f"-r {DEMO}", "Conversations", 1500, 400, (CONVERSATIONS,)),
    Picture("capture/pictures/graphs.png", f"-r {DEMO} -z io,stat", "I/O Graphs", 1000, 720),
    Picture("capture/pictures/live.png", f"-k -i {DEMO_BUS}", "^Capturing from", 1500, 620, is_live=True),
    Picture("capture/pictures/options.png", f"-i {DEMO_BUS}", "Interface Options", 640, 330, OPTIONS),
)


def main() -> int:
    """Take all pictures; return the exit code."""
    parser = argparse.ArgumentParser(
        description=DESCRIPTION, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--readme", action="store_true", help="put them where the READMEs show them")
    args = parser.parse_args()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _stop)
    try:
        _check()
        with User() as user:
            _install(user)
            _capture(user)
            screen = Screen(user)
            for picture in PICTURES:
                taken = _take(user, screen, picture)
                print(_save(REPOSITORY / picture.file if args.readme else OUTPUT / Path(picture.file).name, taken))
    except (Broken, OSError) as error:
        print(f"screenshots: {error}", file=sys.stderr)
        return 1
    return 0


def _stop(signum: int, frame: object) -> NoReturn:
    """End so that everything that was started is stopped."""
    sys.exit(128 + signum)


def _check() -> None:
    missing = [package for program, package in PROGRAMS.items() if shutil.which(program) is None]
    if missing:
        raise Broken(f"programs are missing: apt-get install {' '.join(missing)}")
    if not (REPOSITORY / PLUGIN).exists():
        raise Broken(f"{PLUGIN} is missing: `./bootstrap demo` builds it")


def _install(user: User) -> None:
    """Install as a user does, from a copy that this user may read."""
    checkout = user.folder / "checkout"
    for part in INSTALLED_FROM:
        (checkout / part).parent.mkdir(parents=True, exist_ok=True)
        copy = shutil.copytree if (REPOSITORY / part).is_dir() else shutil.copyfile
        copy(REPOSITORY / part, checkout / part)
    user.owns(checkout)
    user.environment["PYTHONPATH"] = str(checkout / "capture")
    if b"loads sis.so" not in user.run(PYTHON, "-m", "sistap", "install"):
        raise Broken(f"`sistap install` does not take {PLUGIN}: {user.last_words(PYTHON)}")


def _capture(user: User) -> None:
    """Capture the virtual bus."""
    bus = user.start([PYTHON, "-m", "sistap", "bus", *BUS.split()], stdout=subprocess.PIPE)
    assert bus.stdout is not None
    name = bus.stdout.readline().decode().strip()
    user.run(PYTHON, "-m", "sistap", "capture", "--force", "-i", name, "-w", DEMO, "-c", str(RECORDS))
    user.stop(bus)


def _take(user: User, screen: Screen, picture: Picture) -> bytes:
    """Start a fresh Wireshark, go to the window, and return the picture. Broken names the picture."""
    with user.in_a_copy_of_home():
        hidden = ("-o", f"capture.devices_hide:{_others(user)}")  # hide the interfaces of this computer
        wireshark = user.start(["wireshark", "-C", "SIS", *hidden, *shlex.split(picture.arguments)])
        try:
            window = _go(screen, picture)
            if picture.is_live:
                screen.until(lambda: _bytes_captured(user) > LIVE_BYTES, "not enough is captured")
            else:
                before = screen.until_steady(window)
                if picture.do:
                    screen.do(picture.do.format(window=window))
                    screen.until_steady(window, unlike=before)
            return screen.picture(window)
        except Broken as error:
            failed = _save(OUTPUT / "failed.png", screen.picture("root"))
            raise Broken(f"{picture.file}: {error}; {failed} is what the screen shows") from None
        finally:
            user.stop(wireshark)


def _go(screen: Screen, picture: Picture) -> str:
    """Go through other windows to that of a picture; return its number when it has its size."""
    titles = (*(step.title for step in picture.way), picture.title)
    window = screen.window(titles[0])
    for step, title in zip(picture.way, titles[1:], strict=True):
        window = screen.window_after(step.do.format(window=window), title)
    screen.do(f"windowsize --sync {window} {picture.width} {picture.height}")
    return window


def _save(file: Path, picture: bytes) -> Path:
    """Write a picture; return its name relative to the top folder."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(picture)
    return file.relative_to(REPOSITORY)


def _others(user: User) -> str:
    """Return the interfaces of this computer except the demo bus."""
    lines = user.run("tshark", "-D").decode().splitlines()
    return ",".join(name for name in (line.split()[1] for line in lines) if name != DEMO_BUS)


def _bytes_captured(user: User) -> int:
    """Return the size of the file into which Wireshark captures."""
    return sum(file.stat().st_size for file in user.folder.glob("wireshark_*.pcapng"))


if __name__ == "__main__":
    sys.exit(main())
