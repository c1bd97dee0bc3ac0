# SPDX-License-Identifier: GPL-2.0-or-later
"""A user with an empty home, for whom programs run: an ordinary user, also if root runs this."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any

NOBODY = 65534
PATIENCE_S = 30  # longest wait for a program
FAREWELL_S = 5

Program = subprocess.Popen[bytes]


class Broken(Exception):
    """Something does not run or does not appear; the text is the line to show."""


class User:
    """A home in `folder`, and the programs started there. Everything is removed after the `with`."""

    def __init__(self) -> None:
        """Make the home."""
        self.folder = Path(tempfile.mkdtemp(prefix="sistap-screenshots-"))
        self.home = self.folder / "home"
        self.environment = {
            "HOME": str(self.home),
            "PATH": os.environ["PATH"],
            "TMPDIR": str(self.folder),
            "XDG_RUNTIME_DIR": str(self.folder),
            "LC_ALL": "C.UTF-8",
            "TZ": "UTC",
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        self._programs: list[Program] = []
        self.home.mkdir()
        self.owns(self.folder)

    def __enter__(self) -> User:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop what still runs, the last first; remove the home."""
        while self._programs:
            self.stop(self._programs[-1])
        shutil.rmtree(self.folder, ignore_errors=True)

    @contextmanager
    def in_a_copy_of_home(self) -> Iterator[None]:
        """Let programs change only a copy of the home."""
        copy = self.folder / "copy"
        shutil.copytree(self.home, copy)
        self.owns(copy)
        self.environment["HOME"] = str(copy)
        try:
            yield
        finally:
            self.environment["HOME"] = str(self.home)
            shutil.rmtree(copy, ignore_errors=True)

    def owns(self, folder: Path) -> None:
        """Give a folder in the home, with its contents, to the user."""
        if os.geteuid() == 0:
            for path in (folder, *folder.rglob("*")):
                os.chown(path, NOBODY, NOBODY)

    def start(self, command: Sequence[str], *, stdout: int = subprocess.DEVNULL, keep: Sequence[int] = ()) -> Program:
        """Start a program as the leader of a process group. Its output goes into a file named after it."""
        rights: dict[str, Any] = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.geteuid() == 0 else {}
        with self.said(command[0]).open("wb") as said:
            program = subprocess.Popen(
                command,
                cwd=self.folder,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=stdout,
                stderr=said,
                pass_fds=keep,
                start_new_session=True,
                **rights,
            )
        self._programs.append(program)
        return program

    def stop(self, program: Program) -> None:
        """Stop a program with all its children."""
        with suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGTERM)
        with suppress(subprocess.TimeoutExpired):
            program.wait(FAREWELL_S)
        with suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)
        program.wait()
        if program.stdout:
            program.stdout.close()
        self._programs.remove(program)

    def run(self, *command: str, patience_s: float = PATIENCE_S) -> bytes:
        """Run a program to its end; return its stdout. Broken if it fails or does not end."""
        program = self.start(command, stdout=subprocess.PIPE)
        try:
            output, _ = program.communicate(timeout=patience_s)
        except subprocess.TimeoutExpired:
            raise Broken(f"`{' '.join(command)}` does not end within {patience_s:g} s") from None
        finally:
            self.stop(program)
        if program.returncode != 0:
            raise Broken(f"`{' '.join(command)}` failed: {self.last_words(command[0])}")
        return output

    def said(self, name: str) -> Path:
        """Return the file with a program's output."""
        return self.folder / f"{Path(name).name}.log"

    def last_words(self, name: str) -> str:
        """Return the last line of a program's output."""
        lines = self.said(name).read_text(errors="replace").strip().splitlines()
        return lines[-1] if lines else "it did not say why"
