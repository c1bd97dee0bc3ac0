# SPDX-License-Identifier: GPL-2.0-or-later
"""What `sistap install` has put where, so that it and `uninstall` touch nothing else.

A file is ours as long as it is byte for byte what was put there. What somebody has changed since, or what was there
before, is left alone, with a line that says so.
"""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from pathlib import Path

from sistap import state


class LedgerError(Exception):
    """The list cannot be used; the text is the one line to show."""


class Ledger:
    """The list of the files and folders that were made; of this user, or as root of all users."""

    def __init__(self, *, for_all: bool) -> None:
        """Read the list, if there is one. LedgerError, OSError; RuntimeError if this user has no home."""
        self.path = state.folder() / ("installed-for-all.json" if for_all else "installed.json")
        self._files: dict[str, str] = {}  # path: SHA-256
        self._folders: list[str] = []  # in the order in which they were made
        self._left: set[Path] = set()  # folders out of which a file was removed
        if self.path.exists():
            self._load()

    def _load(self) -> None:
        try:
            entries = json.loads(self.path.read_text())
            self._files = {str(path): str(digest) for path, digest in entries["files"].items()}
            self._folders = [str(folder) for folder in entries["folders"]]
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            raise LedgerError(
                f"{self.path} is not what `sistap install` writes: delete it, then install again"
            ) from None

    @property
    def files(self) -> list[Path]:
        """What was put there and not removed yet."""
        return [Path(path) for path in self._files]

    def save(self) -> None:
        """Write the list; remove it when nothing is left. OSError."""
        if not self._files and not self._folders:
            self.path.unlink(missing_ok=True)
            with suppress(OSError):  # there are other results, or there never was a list
                self.path.parent.rmdir()
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        text = json.dumps({"files": self._files, "folders": self._folders}, indent=2) + "\n"
        _replace(self.path, text.encode(), executable=False)

    def put(self, file: Path, content: bytes, *, executable: bool = False) -> str:
        """Make a file what it should be, unless it is not ours; give the line that says what happened. OSError."""
        is_new = not file.exists()
        if not is_new and file.read_bytes() == content:  # it need not be ours: a package may have put it there
            return f"same     {file}"
        if not is_new and not self._is_ours(file):
            cure = "delete it and install again to have the one of this sistap"
            return f"kept     {file}: it was not put there by `sistap install`, or changed since; {cure}"
        self._make_folders(file.parent)
        _replace(file, content, executable=executable)
        self._files[str(file)] = _digest(content)
        return f"{'put' if is_new else 'renewed':8} {file}"

    def remove(self, file: Path) -> str:
        """Remove a file that is ours; give the line that says what happened. OSError, then it stays on the list."""
        if not file.exists():
            line = f"gone     {file}: somebody has removed it already"
        elif self._is_ours(file):
            file.unlink()
            line = f"removed  {file}"
        else:
            line = f"kept     {file}: it was changed since it was put there"
        del self._files[str(file)]
        self._left.add(file.parent)
        return line

    def remove_folders(self) -> list[str]:
        """Remove the folders that were made and are empty now; lines, also for what is left beside removed files."""
        lines = []
        in_use = {parent for file in self.files for parent in file.parents}
        for folder in [Path(folder) for folder in reversed(self._folders)]:
            if folder in in_use:
                continue
            self._folders.remove(str(folder))
            others = sorted(file.name for file in folder.iterdir()) if folder.is_dir() else []
            if folder.is_dir() and not others:
                folder.rmdir()
                lines.append(f"removed  {folder}")
            elif others and folder in self._left:
                lines.append(f"kept     {folder}: others have put {', '.join(others)} there")
        return lines

    def _is_ours(self, file: Path) -> bool:
        return _digest(file.read_bytes()) == self._files.get(str(file))

    def _make_folders(self, folder: Path) -> None:
        missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
        for parent in reversed(missing):
            parent.mkdir()
            self._folders.append(str(parent))


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _replace(file: Path, content: bytes, *, executable: bool) -> None:
    """Write a whole file, or none; a new one in place of the old: a running Wireshark may have that one mapped."""
    new = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        new.write_bytes(content)
        new.chmod(0o755 if executable else 0o644)
        new.replace(file)
    finally:
        with suppress(OSError):
            new.unlink()
