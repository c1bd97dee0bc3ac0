# SPDX-License-Identifier: GPL-2.0-or-later
"""A virtual screen, and the windows on it."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable
from contextlib import suppress

from user import PATIENCE_S, Broken, User

SIZE = "1600x1000x24"
COLOURS = 128  # of a picture: text stays sharp, and the file small
_BETWEEN_SHOTS_S = 0.2
_A_SECOND = 5  # number of looks in a second
_ATTEMPTS = 10


class Screen:
    """The screen of a user, with a window manager, so that windows have titles and get keys."""

    def __init__(self, user: User) -> None:
        """Start both; the user's programs appear on it from now on. May raise Broken."""
        self._user = user
        reading, writing = os.pipe()
        with open(reading) as display:
            with open(writing, "w"):
                user.start(
                    ["Xvfb", "-displayfd", str(writing), "-screen", "0", SIZE, "-nolisten", "tcp"], keep=[writing]
                )
            number = display.readline().strip() if select.select([display], [], [], PATIENCE_S)[0] else ""
        if not number:
            raise Broken(f"Xvfb does not start: {user.last_words('Xvfb')}")
        user.environment["DISPLAY"] = f":{number}"
        user.start(["openbox"])

    def window(self, title: str, patience_s: float = PATIENCE_S) -> str:
        """Wait for a window whose title matches; return its number when it has the focus. May raise Broken."""
        search = ("xdotool", "search", "--sync", "--onlyvisible", "--limit", "1", "--name", title)
        try:
            window = self._user.run(*search, patience_s=patience_s).decode().strip()
        except Broken:
            raise Broken(f"no window '{title}'; wireshark says: {self._user.last_words('wireshark')}") from None
        self.do(f"windowactivate --sync {window}")
        return window

    def window_after(self, words: str, title: str) -> str:
        """Repeat an action until a window appears: a busy program ignores keys. May raise Broken."""
        for _ in range(_ATTEMPTS - 1):
            self.do(words)
            with suppress(Broken):
                return self.window(title, PATIENCE_S / _ATTEMPTS)
        self.do(words)
        return self.window(title, PATIENCE_S / _ATTEMPTS)

    def do(self, words: str) -> None:
        """Do what xdotool can: keys, mouse, windows. May raise Broken."""
        self._user.run("xdotool", *words.split())

    def until_steady(self, window: str, unlike: bytes = b"") -> bytes:
        """Wait until a window has changed and then been steady for a second; return its pixels. May raise Broken.

        The second is the period of a blinking cursor.
        """
        shots: list[bytes] = []

        def is_steady() -> bool:
            shots.append(self._pixels(window))
            return len(shots) > _A_SECOND and shots[-1 - _A_SECOND] == shots[-1] != unlike

        self.until(is_steady, "the window does not change, or does not come to rest,")
        return shots[-1]

    def until(self, condition: Callable[[], bool], what_else: str) -> None:
        """Wait until a condition holds. May raise Broken."""
        deadline = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > deadline:
                raise Broken(f"{what_else} within {PATIENCE_S} s")
            time.sleep(_BETWEEN_SHOTS_S)

    def picture(self, window: str) -> bytes:
        """Take a picture of a window with its frame, or of `root`, the whole screen; return a PNG."""
        colours = ["+dither", "-colors", str(COLOURS), "-strip", "-define", "png:compression-level=9"]
        return self._user.run("import", "-silent", "-frame", "-window", window, *colours, "PNG8:-")

    def _pixels(self, window: str) -> bytes:
        return self._user.run("import", "-silent", "-window", window, "RGB:-")
