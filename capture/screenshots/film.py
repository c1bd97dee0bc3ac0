#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Takes the moving picture of the top README: twenty seconds of the demo bus in Wireshark, then a filter.

It goes into build/screenshots; --readme puts it where the README shows it.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import take
from screen import Screen
from user import Broken, User

FILE = "capture/pictures/live.gif"
SECONDS, FILTER_AT, SIZE = 20, 12, (1280, 480)  # the least width that shows all columns
MOST_BYTES = 2_000_000
FILTER = ("key ctrl+slash", "type --delay 40 sis.tza.verdict==1", "key Return")
LIVE = take.Picture(FILE, f"-k -i {take.DEMO_BUS}", "^Capturing from", *SIZE)


def frames(user: User, screen: Screen, folder: Path) -> None:
    """Take a picture a second; half-way a filter is typed."""
    hidden = ("-o", f"capture.devices_hide:{take._others(user)}")
    wireshark = user.start(["wireshark", "-C", "SIS", *hidden, *LIVE.arguments.split()])
    window = take._go(screen, LIVE)
    begin = time.monotonic()
    for second in range(SECONDS):
        if second == FILTER_AT:
            for words in FILTER:
                screen.do(words)
        time.sleep(max(0.0, begin + second - time.monotonic()))
        (folder / f"{second:02}.png").write_bytes(screen.picture(window))
    user.stop(wireshark)


def main() -> int:
    """Make the moving picture; return the exit code."""
    target = take.REPOSITORY / FILE if "--readme" in sys.argv else take.OUTPUT / Path(FILE).name
    folder = take.OUTPUT / "film"
    folder.mkdir(parents=True, exist_ok=True)
    try:
        take._check()
        with User() as user:
            take._install(user)
            frames(user, Screen(user), folder)
    except (Broken, OSError) as error:
        print(f"film: {error}", file=sys.stderr)
        return 1
    pictures = sorted(map(str, folder.glob("*.png")))
    shrink = ["-resize", "900x", "+dither", "-colors", "32", "-layers", "OptimizePlus"]
    subprocess.run(["/usr/bin/convert", "-delay", "100", "-loop", "0", *pictures, *shrink, str(target)], check=True)
    print(f"{target}: {target.stat().st_size} bytes")
    return 0 if target.stat().st_size < MOST_BYTES else 1


if __name__ == "__main__":
    sys.exit(main())
