# SPDX-License-Identifier: GPL-2.0-or-later
"""Messages: why a port cannot be opened or was lost, and the cure, in one line each."""

from __future__ import annotations

import errno
import re
import socket
import stat
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from sistap.tap.line import others
from sistap.tap.line.settings import LineSettings
from sistap.tap.terminal.advice import advice

if sys.platform == "win32":
    _NUMBERED: tuple[type[BaseException], ...] = (OSError,)
else:
    import termios

    _NUMBERED = (OSError, termios.error)


# Errors of Windows, which says them in its own language; pyserial quotes the exception, with the number last.
_OF_WINDOWS = {
    2: "does not exist: `sistap ports` lists the ports there are",
    3: "does not exist: `sistap ports` lists the ports there are",
    5: "is in use by another program: close that program first",
    31: "is there, but its adapter does not work (Windows error 31): unplug it, and plug it in again",
    121: "is there, but its adapter does not answer (Windows error 121): unplug it, and plug it in again",
    433: "is gone: plug the adapter in",
    1167: "is gone: plug the adapter in",
}
_QUOTED = re.compile(r"Error\(.*, (\d+)\)")


class Otherwise(ValueError):
    """A driver has silently set something else; the text says what."""


def device_trouble(port: str, settings: LineSettings, error: Exception) -> str:
    """Return why a device could not be opened, and the cure."""
    number = _errno(error)
    text = f"{port} cannot be opened: {error}"
    if number == errno.ENOENT:
        text = f"{port} does not exist: `sistap ports` lists the ports there are"
    elif number in (errno.ENOTTY, errno.EISDIR):
        text = f"{port} is not a serial port: `sistap ports` lists the ports there are"
    elif number in (errno.EACCES, errno.EPERM):
        text = f"no permission to open {port}: {_permission_cure(port)}"
    elif number in (errno.EBUSY, errno.EWOULDBLOCK):
        known = others.look(port).known
        text = f"{port} is in use by {known or 'another program ' + advice().in_use.format(port=port)}"
    elif number in (errno.ENXIO, errno.ENODEV, errno.EIO):
        text = f"there is no working hardware behind {port}: `sistap ports` lists the ports there are"
    elif isinstance(error, ValueError | OverflowError) or number == errno.EINVAL:
        why = f" ({error})" if isinstance(error, Otherwise) else ""
        text = f"{port} cannot do {settings}{why}: choose another --baud or --format"
    return text


def lost_text(port: str, *, pseudo_terminal: bool = False, windows_error: int | None = None) -> str:
    """Return that a device was lost while it was read, and the cure."""
    if pseudo_terminal:
        return f"{port}: the program at its other end has ended: start it and a new capture"
    if windows_error in (31, 121):
        return f"{port} {_OF_WINDOWS[windows_error]}, then start a new capture"
    return f"{port} is gone: plug the adapter in and start a new capture"


def url_trouble(port: str, settings: LineSettings, error: Exception) -> str:
    """Return why pyserial could not open a port, and the cure."""
    import serial  # imported here: the rest works without pyserial

    known = "bus://HOST:PORT, socket://HOST:PORT, rfc2217://HOST:PORT"
    text = f"{port} cannot be opened: {error}"
    cause = error.__context__
    quoted = _QUOTED.search(str(error))
    if quoted and (words := _OF_WINDOWS.get(int(quoted[1]))):
        text = f"{port} {words}"
    elif "invalid baudrate" in str(error) or "Cannot configure port" in str(error):
        text = f"{port} cannot do {settings.baud} Bd {settings.format}: choose another --baud or --format"
    elif isinstance(error, OSError) and error.errno == errno.ENOENT:  # spy:// and the like have a device behind them
        text = f"{port} does not exist: `sistap ports` lists the ports there are"
    elif isinstance(cause, OSError) and not isinstance(cause, serial.SerialException):
        text = connection_trouble(port, cause)
    elif "://" in port and (cause or isinstance(error, ValueError | KeyError)):
        text = f"{port} is not the URL of a port: write {known}"
    return text


def connection_trouble(port: str, error: OSError) -> str:
    """Return why a connection failed, and the cure."""
    if isinstance(error, ConnectionRefusedError | FileNotFoundError):
        return f"nothing listens at {port}: start the other end first"
    if isinstance(error, socket.gaierror):
        return f"{port}: no host has that name"
    if isinstance(error, TimeoutError):
        return f"{port} does not answer: check address and network"
    return f"{port} cannot be reached: {error.strerror or error}"


def _errno(error: BaseException) -> int | None:
    """Return the number of an error that pyserial may have wrapped without it."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, _NUMBERED) and cause.args and isinstance(cause.args[0], int):
            return cause.args[0]
        cause = cause.__context__
    return None


def _permission_cure(port: str) -> str:
    if sys.platform == "win32":
        return "close the program that has it"
    try:
        status = Path(port).stat()
    except OSError:
        return "its folder is not open to you"
    if not stat.S_ISCHR(status.st_mode):
        return "it is not a serial port; `sistap ports` lists the ports there are"
    if status.st_mode & 0o060 == 0o060 and status.st_gid != 0:
        group = _name(Path(port).group, status.st_gid)
        return f"it is for group {group}: `sudo usermod -aG {group} $USER`, then log in again"
    return f"it belongs to {_name(Path(port).owner, status.st_uid)}: run sistap as that user"


def _name(look_up: Callable[[], str], number: int) -> str:
    """Return the name of an owner or a group, or its number; a browser's Python has no such names."""
    with suppress(KeyError, ImportError, NotImplementedError):
        return look_up()
    return str(number)
