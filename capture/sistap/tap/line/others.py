# SPDX-License-Identifier: GPL-2.0-or-later
"""Other programs that have a port open: each character reaches only one of those that read."""

from __future__ import annotations

import os
import stat
import sys
from pathlib import Path
from typing import NamedTuple

from sistap.tap.line import ports
from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.state import is_root

PROC = Path("/proc")
GRABBERS = {  # they open every new serial port
    "ModemManager": "it writes to new ports, looking for modems: `sudo systemctl stop ModemManager`",
    "brltty": "it takes adapters for braille displays: `sudo apt-get remove brltty`, or stop it",
}
_CURES = {**GRABBERS, "agetty": "it offers a login: `sudo systemctl stop serial-getty@{device}`"}
_EVERYTHING = "pid:[4026531836]"  # Linux: PROC_PID_INIT_INO; in a container, /proc has only what runs there


class Others(NamedTuple):
    """Who else can read a port."""

    known: str = ""  # programs, and how to end them; empty: none
    unknown: str = ""  # how to find those that are hidden from this one; empty: none is

    def warning(self, port: str) -> str:
        """Say it in one line."""
        return f"another program may read {port}: {self.known or self.unknown}"


def look(port: str) -> Others:
    """Find other programs that have a device open to read. Windows opens a port for one program alone."""
    if sys.platform == "win32":
        return Others()
    try:
        device = Path(port).stat()
    except (OSError, ValueError):  # a URL, or gone
        return Others()
    if not stat.S_ISCHR(device.st_mode):
        return Others()
    word = shell_word(port)
    try:
        is_everything = str((PROC / "self/ns/pid").readlink()) == _EVERYTHING and is_root()
    except OSError:  # not Linux
        return Others(unknown=f"`sudo lsof {word}` names it")
    known = []
    for process in PROC.glob("[0-9]*"):
        try:
            if int(process.name) != os.getpid() and _reads(process, device):
                known.append(_described(process, port))
        except PermissionError:
            is_everything = False
        except OSError:
            continue  # it has ended
    where = " outside of any container" if is_root() else ""
    return Others("; ".join(known), "" if is_everything else f"run `sistap doctor -i {word}` as root{where}")


def _reads(process: Path, device: os.stat_result) -> bool:
    """Tell whether a process has a device open to read. May raise OSError.

    The number of the device counts: a container has other files for it. But a container has pseudo terminals of its
    own, with the same numbers. A process that has the other end of a pseudo terminal is the bus.
    """
    if sys.platform == "win32":
        return False
    is_pseudo, reads = os.major(device.st_rdev) in ports.PTY_SLAVE_MAJORS, False
    for file in list(os.scandir(process / "fd")):
        try:
            if "/dev/" not in os.readlink(file):  # noqa: PTH115 - takes a third of the time
                continue  # a file on a network drive that is gone would never answer
            opened = file.stat()
            if is_pseudo and f"\ntty-index:\t{os.minor(device.st_rdev)}\n" in _text(process / "fdinfo" / file.name):
                return False
            if opened.st_rdev == device.st_rdev and (opened.st_dev == device.st_dev or not is_pseudo):
                reads |= bool(file.stat(follow_symlinks=False).st_mode & stat.S_IRUSR)
        except FileNotFoundError:
            continue  # just closed
    return reads


def _described(process: Path, port: str) -> str:
    """Return name, number and user of a process, and how to end it. May raise OSError."""
    if sys.platform == "win32":
        return ""
    is_sistap = "sistap" in _text(process / "cmdline").split("\0")  # python3 -m sistap capture
    name = "sistap" if is_sistap else _text(process / "comm").strip()
    cure = _CURES.get(name, "end it with `kill {pid}`").format(pid=process.name, device=Path(ports.real(port)).name)
    try:
        user = process.owner()
    except KeyError:
        user = str(process.stat().st_uid)
    return f"{name} (pid {process.name}, user {user}), {cure}"


def _text(file: Path) -> str:
    return file.read_text(errors="replace")
