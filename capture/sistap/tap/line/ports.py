# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds serial ports and describes what is behind them: adapter, driver, and the delay that both may add.

On Windows the registry knows the name, the serial number and the latency timer of an FTDI adapter.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Protocol

from sistap.tap.line import drivers

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


SYSFS = Path("/sys")
DEVICES = Path("/dev")

# Linux: include/uapi/linux/serial_core.h, the attribute `type` of a ttyS.
_UART_NONE = "0"
_UARTS = {"1": "8250", "2": "16450", "3": "16550", "4": "16550A", "8": "16750", "9": "16850"}

_NOT_KNOWN = "n/a"  # pyserial's word for unknown

# Unix98 pseudo terminals (Linux: Documentation/admin-guide/devices.txt).
PTY_SLAVE_MAJORS = range(136, 144)


class Adapter(NamedTuple):
    """What is behind a port; empty or None where the system does not say."""

    name: str = ""
    driver: str = ""
    latency_ms: int | None = None  # latency timer of a USB adapter: it sends no earlier unless its buffer is full
    fifo_trigger: int | None = None  # characters in the FIFO of a UART that raise an interrupt
    pseudo_terminal: bool = False
    serial: str = ""  # serial number of a USB adapter
    is_uart: bool = False  # not a USB adapter: a port such as a 16550

    @property
    def tells(self) -> drivers.Driver:
        """Return what its driver can say about line errors."""
        return drivers.driver(self.driver, is_uart=self.is_uart)

    @property
    def latency(self) -> str:
        """Describe in words how long it holds characters back."""
        if self.latency_ms is not None:
            return f"latency timer {self.latency_ms} ms"
        if self.fifo_trigger is not None:
            return f"FIFO trigger {self.fifo_trigger}"
        return ""

    def __str__(self) -> str:
        """One line such as "FT232R USB UART (ftdi_sio, latency timer 16 ms)"."""
        details = ", ".join(detail for detail in (self.driver, self.latency) if detail)
        name = self.name or "unknown adapter"
        return f"{name} ({details})" if details else name


def adapter(port: str, sysfs: Path = SYSFS) -> Adapter:
    """Describe what is behind a device. A port that does not exist is an unknown adapter, not an error."""
    if sys.platform == "win32":
        return of_windows(port)
    if _is_pseudo_terminal(port):
        return Adapter("pseudo terminal", pseudo_terminal=True)
    tty = sysfs / "class/tty" / Path(os.path.realpath(port)).name
    kind = _line(tty / "type")
    uart = _UARTS.get(kind, "")
    usb = _usb_device(tty / "device")
    return Adapter(
        (_line(usb / "product") if usb else "") or (f"{uart} UART" if uart else ""),
        _driver(tty / "device"),
        number(sysfs / "bus/usb-serial/devices" / tty.name / "latency_timer"),
        number(tty / "rx_trig_bytes"),
        serial=_line(usb / "serial") if usb else "",
        is_uart=kind not in ("", _UART_NONE),
    )


def is_8250(port: str, sysfs: Path | None = None) -> bool:
    """Tell whether a port is an 8250 or one of its successors."""
    return _line((sysfs or SYSFS) / "class/tty" / Path(real(port)).name / "type") in _UARTS


def of_windows(port: str, known: Registry | None = None) -> Adapter:
    """Describe what is behind a port of Windows, from its registry, which lists only FTDI adapters."""
    found = ftdi(port, known)
    return Adapter(found.name, found.driver, found.latency_ms, serial=found.serial) if found else Adapter()


def identity(port: str, behind: Adapter) -> str:
    """Name the hardware itself: an adapter with a serial number is the same at every port."""
    if behind.serial:
        return f"{behind.name} {behind.serial}"
    return f"{behind.name or 'unknown adapter'} at {real(port)}"


def real(port: str) -> str:
    """Return the device behind a link. Windows has no links, and looking for one at COM5 may fail."""
    return port if sys.platform == "win32" else os.path.realpath(port)


def _is_pseudo_terminal(port: str) -> bool:
    if sys.platform == "win32":
        return False
    try:
        return os.major(Path(port).stat().st_rdev) in PTY_SLAVE_MAJORS
    except OSError:
        return False


def is_own_terminal(port: str) -> bool:
    """Tell whether a port is the terminal that this program reads or writes."""
    if sys.platform == "win32":
        return False
    try:
        device = Path(port).stat().st_rdev
    except (OSError, ValueError):
        return False
    standard = any(os.isatty(stream) and os.fstat(stream).st_rdev == device for stream in range(3))
    return standard or is_same_file(port, "/dev/tty")


def is_same_file(one: str, other: str) -> bool:
    """Tell whether two paths are one file; False if one of them does not exist."""
    try:
        return Path(one).samefile(other)
    except OSError:
        return False


def _line(file: Path) -> str:
    try:
        return file.read_text().strip()
    except OSError:
        return ""


def number(file: Path) -> int | None:
    """Read a number of sysfs; None if there is none."""
    text = _line(file)
    return int(text) if text.isdecimal() else None


def _usb_device(device: Path) -> Path | None:
    """Find the USB device that has the device as an interface, or below one. It names its product."""
    real = device.resolve()
    return next((folder for folder in (real, *real.parents[:3]) if _line(folder / "product")), None)


def _driver(device: Path) -> str:
    """Return the driver. From Linux 6.5 on, the core's "port" and "ctrl" lie between a ttyS and its driver."""
    real = device.resolve()
    for folder in (real, *real.parents[:3]):
        driver = folder / "driver"
        if driver.exists() and driver.resolve().name not in ("port", "ctrl"):
            return driver.resolve().name
    return ""


def found(sysfs: Path = SYSFS) -> list[tuple[str, Adapter]]:
    """List the ports, each with what is behind it, in natural order."""
    from serial.tools import list_ports  # imported here: the rest works without pyserial

    ports = []
    for info in sorted(list_ports.comports()):
        if _line(sysfs / "class/tty" / Path(info.device).name / "type") == _UART_NONE:
            continue  # a ttyS without hardware
        behind = adapter(info.device, sysfs)
        if not behind.name and info.description != _NOT_KNOWN:  # not on Linux: use what pyserial knows
            behind = behind._replace(name=info.description)
        ports.append((info.device, behind))
    return ports


def short(port: str) -> str:
    """Return the device of a port that is named without its folder: ttyUSB0 becomes /dev/ttyUSB0."""
    device = DEVICES / port
    is_short = sys.platform != "win32" and "/" not in port and ":" not in port and not Path(port).exists()
    return str(device) if port and is_short and device.exists() else port
