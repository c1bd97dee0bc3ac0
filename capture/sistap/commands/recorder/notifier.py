# SPDX-License-Identifier: GPL-2.0-or-later
"""Starts a command with the name of a kept file, without waiting for it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from sistap.dissected.explain.running import ordinary_children

MOST = 20  # running at the same time


class Notifier:
    """The commands that were started."""

    def __init__(self, command: str | None, say: Callable[[str], None]) -> None:
        """Start `command`, a shell line, followed by the name of a file; None: nothing."""
        self._command = command
        self._say = say
        self._running: list[tuple[subprocess.Popen[bytes], Path]] = []

    def notify(self, path: Path) -> None:
        """Start it."""
        if not self._command:
            return
        self.reap()
        if len(self._running) >= MOST:
            self._say(f"--on-keep was not started for {path}: {MOST} earlier ones are still running")
            return
        shell = sys.platform == "win32"
        line = f'{self._command} "{path}"' if shell else ["/bin/sh", "-c", f'{self._command} "$@"', "sh", str(path)]
        try:
            with ordinary_children():
                process = subprocess.Popen(
                    line, shell=shell, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, start_new_session=True
                )
        except OSError as error:
            self._say(f"--on-keep cannot be started for {path}: {error.strerror}")
            return
        self._running.append((process, path))

    def reap(self) -> None:
        """Report which have failed."""
        for process, path in self._running:
            if process.poll():
                self._say(f"--on-keep ended with exit code {process.returncode} for {path}")
        self._running = [(process, path) for process, path in self._running if process.returncode is None]
