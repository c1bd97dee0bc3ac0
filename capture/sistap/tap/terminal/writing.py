# SPDX-License-Identifier: GPL-2.0-or-later
"""How a file is opened for writing: with no link, the right mode, and a lock while a program writes it for long.

A symbolic link is refused, because somebody else may have put it there. Locks end with the program; readers are not
hindered.
"""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

if sys.platform == "win32":
    import ctypes
    import msvcrt

    # One byte far behind the end of any file: a lock of Windows keeps others from what it covers.
    _PLACE = (0xFFFFFFFF, 0x3FFFFFFF)  # low and high half
    _LOCK_VIOLATION = 33

    def lock(descriptor: int) -> bool:
        """Lock an open file until it is closed. False if another program has locked it. Else, without locks, True."""
        windows = ctypes.WinDLL("kernel32", use_last_error=True)
        handle = ctypes.c_void_p(msvcrt.get_osfhandle(descriptor))
        return bool(windows.LockFile(handle, *_PLACE, 1, 0)) or ctypes.get_last_error() != _LOCK_VIOLATION

else:
    import fcntl

    def lock(descriptor: int) -> bool:
        """Lock an open file until it is closed. False if another program has locked it. Else, without locks, True."""
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            pass
        return True


FORCE = "overwrite a file that holds data"  # the help of --force
WINDOWS_PIPES = "\\\\.\\pipe\\"  # they can be opened, but not created like files
# Folders in which only the system makes links, such as /dev/stdout: they lead to what the user has opened.
_OF_SYSTEM = re.compile(r"/dev(/fd)?|/proc/\d+(/task/\d+)?/fd")
_MODE = 0o640  # mode of a new file, before the umask: what a machine does is confidential


def no_link(path: str) -> int:
    """Return the flag of os.open that refuses a symbolic link, unless the system made it. OSError if it is one."""
    if _OF_SYSTEM.fullmatch(os.path.realpath(Path(path).parent)):
        return 0
    if Path(path).is_symlink():
        raise OSError(errno.ELOOP, "it is a symbolic link, which may lead anywhere")
    return getattr(os, "O_NOFOLLOW", 0)


def mode_like(sources: Sequence[str | Path]) -> int:
    """Return the mode of a new file: whoever may not read one of its sources may not read it."""
    mode = 0o666 if sources else _MODE
    for source in sources:
        with suppress(OSError):  # whoever opens it will say why
            about = Path(source).stat()
            mode &= about.st_mode
            if about.st_gid != getattr(os, "getegid", lambda: 0)():  # another group than that of the new file
                mode &= ~stat.S_IRWXG | (about.st_mode & stat.S_IRWXO) << 3
    return mode | 0o600
