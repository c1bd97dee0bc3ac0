# SPDX-License-Identifier: GPL-2.0-or-later
"""Renews or removes the profile SIS of every user of this computer: for the Debian package, which root installs.

    python3 -m sistap.commands.install.homes renew|remove

Nothing is done as root in the folders of others: each user has a process with that user's rights.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from sistap.commands.install import personal
from sistap.dissected.wireshark import profile
from sistap.tap.terminal.console import visible

ORDINARY = range(1000, 60000)  # users of people, as Debian numbers them
_FOLDERS = (".config/wireshark", ".wireshark")
_DO: dict[str, Callable[[Path], Iterator[str]]] = {"renew": personal.renew, "remove": personal.remove}


def main(what: str) -> None:
    """Act for every user who has the profile; print a line for each file."""
    if sys.platform == "win32":
        return
    import pwd  # noqa: PLC0415 - not on Windows

    for user in pwd.getpwall():
        folders = [Path(user.pw_dir, folder) for folder in _FOLDERS]
        has_it = any(os.path.lexists(folder / "profiles" / profile.NAME) for folder in folders)
        if has_it and user.pw_uid in (0, *ORDINARY):
            sys.stdout.flush()
            child = os.fork()
            if child == 0:
                os._exit(_act(_DO[what], user, folders))
            os.waitpid(child, 0)


def _act(do: Callable[[Path], Iterator[str]], user: Any, folders: Sequence[Path]) -> int:
    """Act with the rights of a user; return the exit code."""
    if sys.platform == "win32":
        return 1
    try:
        if user.pw_uid != 0:
            os.initgroups(user.pw_name, user.pw_gid)
            os.setgid(user.pw_gid)
            os.setuid(user.pw_uid)
        os.environ["HOME"] = user.pw_dir
        os.environ.pop("XDG_STATE_HOME", None)
        for folder in folders:
            for line in do(folder):
                print(visible(line))
        sys.stdout.flush()
    except Exception as error:  # noqa: BLE001 - the trouble of one user is not that of the package
        print(f"sistap: {visible(str(error))}", file=sys.stderr, flush=True)
        return 1
    return 0


if __name__ == "__main__":
    main(*sys.argv[1:])
