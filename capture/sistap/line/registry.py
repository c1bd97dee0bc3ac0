# SPDX-License-Identifier: GPL-2.0-or-later
"""The registry of Windows about an FTDI adapter: its name, its serial number, its latency timer."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import NamedTuple, Protocol

# Each adapter has a key such as VID_0403+PID_6001+A50285BIA: its serial number and the letter of its port. Its
# instances are below, each with "Device Parameters".
_FTDI = r"SYSTEM\CurrentControlSet\Enum\FTDIBUS"
_PARAMETERS = "Device Parameters"


class Registry(Protocol):
    """HKEY_LOCAL_MACHINE, read only."""

    def keys(self, path: str) -> list[str]:
        """Return the names of the keys below a key; none if it does not exist."""

    def value(self, path: str, name: str) -> object:
        """Return a value; None if it does not exist."""


class Ftdi(NamedTuple):
    """An FTDI adapter, as far as Windows knows it."""

    name: str  # "USB Serial Port (COM5)"
    driver: str  # "FTSER2K"
    serial: str
    latency_ms: int | None


def ftdi(port: str, registry: Registry | None = None) -> Ftdi | None:
    """Return the FTDI adapter behind a port such as COM5; None for another adapter, or without a registry."""
    registry = registry or _here()
    if registry is None:
        return None
    for device, key in _instances(registry):
        name = registry.value(rf"{key}\{_PARAMETERS}", "PortName")
        if isinstance(name, str) and name.upper() == port.upper().removeprefix("\\\\.\\"):
            latency_ms = registry.value(rf"{key}\{_PARAMETERS}", "LatencyTimer")
            return Ftdi(
                _text(registry.value(key, "FriendlyName")),
                _text(registry.value(key, "Service")),
                device.split("+")[2][:-1] if device.count("+") == 2 else "",
                latency_ms if isinstance(latency_ms, int) else None,
            )
    return None


def _instances(registry: Registry) -> Iterator[tuple[str, str]]:
    """Yield the name of each adapter that was ever plugged in, with the key of each of its instances."""
    for device in registry.keys(_FTDI):
        for instance in registry.keys(rf"{_FTDI}\{device}"):
            yield device, rf"{_FTDI}\{device}\{instance}"


def _text(value: object) -> str:
    return value if isinstance(value, str) else ""


class _LocalMachine:
    """The registry of this computer."""

    def keys(self, path: str) -> list[str]:
        """Return the names of the keys below a key; none if it does not exist."""
        if sys.platform != "win32":
            return []
        import winreg

        try:
            with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, path) as key:
                return [winreg.EnumKey(key, number) for number in range(winreg.QueryInfoKey(key)[0])]
        except OSError:
            return []

    def value(self, path: str, name: str) -> object:
        """Return a value; None if it does not exist."""
        if sys.platform != "win32":
            return None
        import winreg

        try:
            with winreg.OpenKey(winreg.HKEY_LOCAL_MACHINE, path) as key:
                found: object = winreg.QueryValueEx(key, name)[0]
                return found
        except OSError:
            return None


def _here() -> Registry | None:
    """Return the registry of this computer, if it has one."""
    try:
        import winreg  # noqa: F401
    except ImportError:
        return None
    return _LocalMachine()
