# SPDX-License-Identifier: GPL-2.0-or-later
"""The list of what `sistap install` has installed, so that it and `uninstall` touch nothing else.

sistap replaces or removes a file only if nobody has changed it, and only in a folder into which install puts files. A
file that somebody has changed, that was there before, or that the list names elsewhere stays, with a message.
"""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from pathlib import Path

from sistap.dissected.wireshark.folders import Own
from sistap.tap.terminal import state
from sistap.tap.terminal.exits import FAILED, Refusal


class ElsewhereError(Exception):
    """The list names a file outside of these folders; the text is the line to show."""


class Ledger:
    """The list of the files and folders that were made, for this user, or as root for all users."""

    def __init__(self, *, for_all: bool) -> None:
        """Read the list, if there is one. Refusal, OSError; RuntimeError if there can be none."""
        name = "installed-for-all.json" if for_all else "installed.json"
        self.path = state.folder() / name
        self._files: dict[str, str] = {}  # path: SHA-256; while a file is renewed, that of the old, a blank, the new
        self._folders: list[str] = []  # in the order in which they were made
        self.removed_from: set[Path] = set()  # folders from which a file was removed
        if self.path.exists():
            if state.is_root():
                state.check(self.path)
            self._load(self.path)

    def _load(self, path: Path) -> None:
        try:
            if not path.is_file():  # to read a pipe would take for ever
                raise ValueError(path)
            entries = json.loads(path.read_text())
            self._files = {_name(file): str(digest) for file, digest in entries["files"].items()}
            self._folders = [_name(folder) for folder in entries["folders"]]
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            raise Refusal(
                f"{path} is not what `sistap install` writes: delete it, then install again", FAILED
            ) from None

    @property
    def is_empty(self) -> bool:
        """Tell whether there is nothing to remove."""
        return not self._files and not self._folders

    @property
    def files(self) -> list[Path]:
        """Return what was installed and not removed yet."""
        return [Path(path) for path in self._files]

    def save(self) -> None:
        """Write the list; remove it when nothing is left. May raise OSError."""
        if self.is_empty:
            _remove(self.path)
        else:
            text = json.dumps({"files": self._files, "folders": self._folders}, indent=2) + "\n"
            state.save(self.path.name, text.encode())

    def put(self, file: Path, content: bytes, *, executable: bool = False) -> str:
        """Write a file, unless somebody else owns it; return the line that reports it. May raise OSError."""
        is_new = not file.exists()
        if file.is_file() and file.read_bytes() == content:  # somebody else may own it: a package may have put it there
            if str(file) in self._files:  # of an install that was killed before it noted the new contents
                self._files[str(file)] = _digest(content)
            return f"same     {file}"
        if not is_new and not self._is_ours(file):
            cure = "delete it and install again to have the one of this sistap"
            return f"kept     {file}: it was not put there by `sistap install`, or changed since; {cure}"
        try:
            self._announce(file, content)
            state.replace(file, content, executable=executable)
        except OSError:
            self._take_back(file)
            raise
        self._files[str(file)] = _digest(content)
        return f"{'put' if is_new else 'renewed':8} {file}"

    def adopt(self, file: Path) -> None:
        """Put a file on the list that something else has put there for sistap, with its folder. May raise OSError."""
        self._files[str(file)] = _digest(file.read_bytes())
        if str(file.parent) not in self._folders:
            self._folders.append(str(file.parent))

    def remove(self, file: Path, own: Own) -> str:
        """Remove a file that is ours; return the line that reports it.

        OSError, or ElsewhereError if it is not in `own` folders: then it stays on the list.
        """
        if not own.have(file):
            raise ElsewhereError(f"kept {file}: {self._elsewhere()}")
        if not file.exists():
            line = f"gone     {file}: somebody has removed it already"
        elif self._is_ours(file):
            with state.closed(file):
                file.unlink()
            line = f"removed  {file}"
        else:
            line = f"kept     {file}: it was changed since it was put there"
        del self._files[str(file)]
        self.removed_from.add(file.parent)
        return line

    def remove_folders(self, own: Own) -> list[str]:
        """Remove the folders that were made and are empty now; return lines, also about what is left in them."""
        lines = []
        in_use = {parent for file in self.files for parent in file.parents}
        for folder in [Path(folder) for folder in reversed(self._folders)]:
            if folder in in_use:
                continue
            if not own.are_below(folder):
                lines.append(f"kept     {folder}: {self._elsewhere()}")
                continue
            self._folders.remove(str(folder))
            others = sorted(file.name for file in folder.iterdir()) if folder.is_dir() else []
            if folder.is_dir() and not others:
                folder.rmdir()
                lines.append(f"removed  {folder}")
            elif others and folder in self.removed_from:
                lines.append(f"kept     {folder}: it still has {', '.join(others)}")
        return lines

    def _elsewhere(self) -> str:
        return (
            f"{self.path} names it, but it is in none of the folders of `sistap install`; if it is yours, delete it "
            "yourself"
        )

    def _is_ours(self, file: Path) -> bool:
        if not file.is_file() or file.is_symlink():
            return False
        return _digest(file.read_bytes()) in self._files.get(str(file), "").split()

    def _announce(self, file: Path, content: bytes) -> None:
        """Write down what comes before it is there, as this may be killed at any moment; make its folder."""
        missing = [folder for folder in file.parents if not folder.exists()]
        self._files[str(file)] = f"{self._files.get(str(file), '')} {_digest(content)}".lstrip()
        self._folders += [str(folder) for folder in reversed(missing) if str(folder) not in self._folders]
        self.save()
        file.parent.mkdir(parents=True, exist_ok=True)

    def _take_back(self, file: Path) -> None:
        """Take what could not be put off the list again, if this is possible."""
        with suppress(OSError, RuntimeError):
            if not file.exists():
                self._files.pop(str(file), None)
                self._folders = [folder for folder in self._folders if Path(folder).exists()]
                self.save()


def _name(text: object) -> str:
    """Check that the text can be the name of a file or folder. Raise ValueError if not."""
    name = str(text)
    if b"\0" in os.fsencode(name):
        raise ValueError("a name has no NUL")
    return name


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _remove(ledger: Path) -> None:
    """Remove a list, and its folder if it is empty then."""
    ledger.unlink(missing_ok=True)
    with suppress(OSError):
        ledger.parent.rmdir()
