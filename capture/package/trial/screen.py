# SPDX-License-Identifier: GPL-2.0-or-later
"""A virtual screen, on which programs of several users appear, one after the other."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path
from types import TracebackType

SIZE = "1366x768x24"
PATIENCE_S = 90
SETTLE_S = 8  # for complaints, which come after the window
LEAVE_S = 10  # a live capture asks whether to save, and is killed then


class Screen:
    """The screen. Its pictures go into a folder. Use it in a `with`."""

    def __init__(self, pictures: Path) -> None:
        """Start it."""
        pictures.mkdir(exist_ok=True)
        self._pictures = pictures
        self._number = 0
        self._environment = os.environ | {"DISPLAY": ":7"}
        self._server = subprocess.Popen(["Xvfb", ":7", "-screen", "0", SIZE, "-ac", "-nolisten", "tcp"])
        while not Path("/tmp/.X11-unix/X7").exists():
            if self._server.poll() is not None:
                raise RuntimeError("Xvfb does not start")
            time.sleep(0.1)
        self._manager = subprocess.Popen(["openbox"], env=self._environment, stderr=subprocess.DEVNULL)

    def __enter__(self) -> Screen:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._manager.kill()
        self._server.kill()

    def show(self, user: str, line: str, title: str) -> None:
        """Run a command as a user until a window with this title is there, then close it as a user does.

        RuntimeError if there is no such window, or another one, which is a complaint.
        """
        begun = time.monotonic()
        home = f"/home/{user}"
        environment = f"DISPLAY=:7 HOME={home} XDG_RUNTIME_DIR={home} LC_ALL=C.UTF-8 PATH=/usr/bin:/bin"
        rights = ["setpriv", f"--reuid={user}", f"--regid={user}", "--init-groups", "--reset-env"]
        program = subprocess.Popen(
            [*rights, "env", *environment.split(), "bash", "-c", line],
            cwd=home,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            window = self._do("search", "--sync", "--onlyvisible", "--limit", "1", "--name", title).strip()
            seconds = time.monotonic() - begun
            time.sleep(SETTLE_S)
            titles = self._titles()
            self._number += 1
            picture = self._pictures / f"{self._number:02}-{re.sub('[^a-z]+', '-', title.lower()).strip('-')}.png"
            subprocess.run(["import", "-silent", "-window", "root", picture], env=self._environment, check=True)
            if len(titles) != 1 or title not in titles[0]:
                raise RuntimeError(f"{user}: {line}: there are the windows {titles}; see {picture}")
            self._do("windowactivate", "--sync", window, "key", "--clearmodifiers", "ctrl+q")
            with suppress(subprocess.TimeoutExpired):
                program.wait(LEAVE_S)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(program.pid, signal.SIGKILL)
            program.wait()
        print(f"good  {seconds:5.0f} s  {user}: {line}", flush=True)

    def _titles(self) -> list[str]:
        """Return the titles of all visible windows that a user sees."""
        windows = self._do("search", "--onlyvisible", "--name", ".+").split()
        names = [self._do("getwindowname", window).strip() for window in windows]
        return [name for name in names if name and not name.startswith(("Openbox", "openbox"))]

    def _do(self, *words: str) -> str:
        """Do what xdotool can. RuntimeError if it fails, or takes too long."""
        try:
            done = subprocess.run(
                ["xdotool", *words],
                env=self._environment,
                capture_output=True,
                text=True,
                timeout=PATIENCE_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise RuntimeError(f"xdotool {' '.join(words)}: nothing within {PATIENCE_S} s") from None
        return done.stdout
