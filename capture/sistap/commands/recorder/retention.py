# SPDX-License-Identifier: GPL-2.0-or-later
"""The files in the folder of a recorder, including those of earlier runs: names, number, compression."""

from __future__ import annotations

import errno
import gzip
import os
import re
import time
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from shutil import disk_usage

from sistap.tap.terminal.writing import mode_like

RING = "ring.pcapng"  # output names the files: ring_00001_20261122031204.pcapng
SUFFIX = ".gz"  # of a compressed file
_PIECE = 1 << 16
_PAUSE_S = 0.001  # after each piece a reader can have its turn

_KEPT_NAME = re.compile(r"kept_(\d{14}\.\d{3})_([\w.-]+?)(?:-\d+)?\.pcapng(?:\.gz)?", re.ASCII)
_RING_NAME = re.compile(r"ring_\d{5}_(\d{14})\.pcapng(?:\.gz)?", re.ASCII)


Matches = Sequence[re.Match[str]]  # of the names of files, in the order of their time
Written = Callable[[], Collection[str]]  # the names of files that are being written


class Retention:
    """The files of one kind: how many of them stay."""

    def __init__(
        self,
        folder: Path,
        name: re.Pattern[str],
        surplus: Callable[[Matches], Matches],
        say: Callable[[str], None],
        written: Written,
    ) -> None:
        """Hold the files with such a name; `surplus` chooses those that must go. The first group is their time.

        The files that are `written` are the newest, whatever their names say: a clock can be set back, and summer time
        ends once a year.
        """
        self.folder = folder
        self._name = name
        self._surplus = surplus
        self._say = say
        self._written = written
        self._stay: set[str] = set()  # files that cannot be deleted; reported once

    def prune(self) -> None:
        """Delete files if there are too many."""
        for match in self._surplus(self._found()):
            path = self.folder / match[0]
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                if path.name not in self._stay:
                    self._stay.add(path.name)
                    self._say(f"{path} cannot be deleted: {error.strerror}; each new file tries again")

    def complete(self) -> list[Path]:
        """Return the files that are not compressed, except the newest: that may be written. No links, no pipes."""
        paths = [self.folder / match[0] for match in self._found()[:-1] if not match[0].endswith(SUFFIX)]
        written = self._written()
        return [path for path in paths if path.name not in written and path.is_file() and not path.is_symlink()]

    def _found(self) -> Matches:
        found = list(filter(None, (self._name.fullmatch(path.name) for path in self.folder.iterdir())))
        written = self._written()  # asked last: what was found and is not among them is complete
        return sorted(found, key=lambda match: (match[0] in written, match[1], match[0]))


def kept(folder: Path, at_most: int, say: Callable[[str], None], written: Written) -> Retention:
    """Return the kept files. The first of each reason stays."""
    return Retention(folder, _KEPT_NAME, lambda found: _repeats(found, at_most), say, written)


def ring(folder: Path, at_most: int | None, say: Callable[[str], None], written: Written) -> Retention:
    """Return the files of the full ring, None: all stay."""
    return Retention(folder, _RING_NAME, lambda found: found[:-at_most] if at_most else (), say, written)


def _repeats(found: Matches, at_most: int) -> Matches:
    """Return the files above `at_most`: the oldest of those whose reasons are the most frequent.

    So a thousand repeats displace neither a rare cause nor the first file of a reason. The newest is about to be told.
    """
    counts = Counter(reason for match in found for reason in _reasons(match))
    firsts: dict[str, re.Match[str]] = {}
    for match in found[:-1]:
        for reason in _reasons(match):
            firsts.setdefault(reason, match)
    last = dict.fromkeys(firsts.values())
    others = [match for match in found[:-1] if match not in last]
    others.sort(key=lambda match: min(counts[reason] for reason in _reasons(match)), reverse=True)
    return [*others, *last][: max(len(found) - at_most, 0)]


def _reasons(match: re.Match[str]) -> list[str]:
    return match[2].split("_")


def new_name(folder: Path, time_ns: int, *words: str) -> Path:
    """Return an unused name for a file, from its time (local) and reasons."""
    seconds, ns = divmod(time_ns, 1_000_000_000)
    base = f"kept_{time.strftime('%Y%m%d%H%M%S', time.localtime(seconds))}.{ns // 1_000_000:03d}_{'_'.join(words)}"
    path, number = folder / f"{base}.pcapng", 1
    while os.path.lexists(path) or os.path.lexists(f"{path}{SUFFIX}"):  # a link that leads nowhere is there, too
        number += 1
        path = folder / f"{base}-{number}.pcapng"
    return path


def pack(path: Path) -> Path:
    """Compress a file; return its new name. May raise OSError: then it is there as it was.

    A file is written without compression, so that it has all records whatever happens to the recorder. It is compressed
    as a whole when it is complete: 3 times smaller if times are exact to 1 ns, 12 times if they are exact to 1 ms.
    The disk must have room for it a second time: the last room is for what is being written.
    """
    if disk_usage(path.parent).free < path.stat().st_size:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    packed = path.with_name(path.name + SUFFIX)
    part = path.with_name(f".{packed.name}")
    part.unlink(missing_ok=True)  # of a recorder that was killed
    try:
        mode = mode_like([path])  # from the first moment on: who has opened it goes on reading it
        with path.open("rb") as source, open(part, "xb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
            with gzip.GzipFile(path.name, "wb", 6, file) as target:
                while piece := source.read(_PIECE):
                    target.write(piece)
                    time.sleep(_PAUSE_S)
            file.flush()
            os.fsync(file.fileno())
        part.replace(packed)
    except OSError:
        part.unlink(missing_ok=True)
        raise
    try:
        path.unlink(missing_ok=True)
    except OSError:  # of Windows, while somebody reads it
        packed.unlink(missing_ok=True)
        raise
    return packed
