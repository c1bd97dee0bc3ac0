# SPDX-License-Identifier: GPL-2.0-or-later
"""Adds a folder to the PATH of this user of Windows, or removes it: for the installer.

    python -m sistap.commands.install.userpath add|remove FOLDER

The installer's own language cuts texts at 1023 characters, and many a PATH is longer.
"""

from __future__ import annotations

import sys

_SEPARATOR = ";"


def changed(path: str, what: str, folder: str) -> str:
    """Return a PATH with the folder at its end, or without it; the rest of it stays as it is."""
    others = [entry for entry in path.split(_SEPARATOR) if _plain(entry) != _plain(folder)]
    if what == "add":
        others = [*(others if path.strip(_SEPARATOR) else []), folder]
    return _SEPARATOR.join(others)


def _plain(entry: str) -> str:
    return entry.strip().strip('"').rstrip("\\").casefold()


def main(what: str, folder: str) -> None:
    """Change the registry, and let what runs know. May raise OSError."""
    if sys.platform != "win32":
        return
    import ctypes
    import winreg

    with winreg.OpenKey(winreg.HKEY_CURRENT_USER, "Environment", 0, winreg.KEY_READ | winreg.KEY_WRITE) as key:
        try:
            path, kind = winreg.QueryValueEx(key, "Path")
        except FileNotFoundError:
            path, kind = "", winreg.REG_EXPAND_SZ
        if (new := changed(path, what, folder)) == path:
            return
        if new:
            winreg.SetValueEx(key, "Path", 0, kind, new)
        else:
            winreg.DeleteValue(key, "Path")
    everybody, setting_changed, if_not_hung, patience_ms = 0xFFFF, 0x001A, 2, 2000
    ctypes.windll.user32.SendMessageTimeoutW(
        everybody, setting_changed, 0, "Environment", if_not_hung, patience_ms, None
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
