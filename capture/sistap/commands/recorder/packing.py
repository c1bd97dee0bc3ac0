# SPDX-License-Identifier: GPL-2.0-or-later
"""Compresses complete files: Wireshark and sistap open NAME.pcapng.gz as they open NAME.pcapng.

A file is written without compression, so that it has all records whatever happens to the recorder. It is compressed as
a whole when it is complete: 3 times smaller if times are exact to 1 ns, 12 times if they are exact to 1 ms. Pieces of
a second each would be larger: 2 and 4 times.
"""

from __future__ import annotations

import errno
import gzip
import os
import time
from pathlib import Path
from shutil import disk_usage

from sistap.tap.terminal.writing import mode_like

SUFFIX = ".gz"
_PIECE = 1 << 16
_PAUSE_S = 0.001  # after each piece a reader can have its turn


def pack(path: Path) -> Path:
    """Compress a file; return its new name. May raise OSError: then it is there as it was.

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
    path.unlink(missing_ok=True)
    return packed
