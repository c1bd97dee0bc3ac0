# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds serial ports and describes what is behind them: adapter, driver, and the delay that both may add."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from sistap.line import analyser, registry
from sistap.terminal.advice import advice
from sistap.terminal.exits import DONE
from sistap.terminal.visible import visible

SYSFS = Path("/sys")
DEVICES = Path("/dev")

# Linux: include/uapi/linux/serial_core.h, the attribute `type` of a ttyS.
_UART_NONE = "0"
_UARTS = {"1": "8250", "2": "16450", "3": "16550", "4": "16550A", "8": "16750", "9": "16850"}

_NOT_KNOWN = "n/a"  # pyserial's word for unknown

# Unix98 pseudo terminals (Linux: Documentation/admin-guide/devices.txt).
_PTY_SLAVE_MAJORS = range(136, 144)


class Adapter(NamedTuple):
    """What is behind a port; empty or None where the system does not say."""

    name: str = ""
    driver: str = ""
    latency_ms: int | None = None  # latency timer of a USB adapter: it sends no earlier unless its buffer is full
    fifo_trigger: int | None = None  # characters in the FIFO of a UART that raise an interrupt
    pseudo_terminal: bool = False
    serial: str = ""  # serial number of a USB adapter

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
    uart = _UARTS.get(_line(tty / "type"), "")
    usb = _usb_device(tty / "device")
    return Adapter(
        (_line(usb / "product") if usb else "") or (f"{uart} UART" if uart else ""),
        _driver(tty / "device"),
        number(sysfs / "bus/usb-serial/devices" / tty.name / "latency_timer"),
        number(tty / "rx_trig_bytes"),
        serial=_line(usb / "serial") if usb else "",
    )


def is_8250(port: str, sysfs: Path | None = None) -> bool:
    """Tell whether a port is an 8250 or one of its successors."""
    return _line((sysfs or SYSFS) / "class/tty" / Path(real(port)).name / "type") in _UARTS


def of_windows(port: str, known: registry.Registry | None = None) -> Adapter:
    """Describe what is behind a port of Windows, from its registry, which lists only FTDI adapters."""
    found = registry.ftdi(port, known)
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
        return os.major(Path(port).stat().st_rdev) in _PTY_SLAVE_MAJORS
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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of `sistap ports`."""
    parser.description = "List the serial ports with adapter, driver and latency. List logic analysers as well."
    parser.add_argument("--json", action="store_true", help="print the list as JSON, for programs")


def _as_json(ports: list[tuple[str, Adapter]], analysers: Sequence[analyser.Analyser]) -> str:
    """Return the ports as a JSON array; what the system does not say is null."""
    rows = [
        {
            "port": port,
            "adapter": behind.name or None,
            "driver": behind.driver or None,
            "latency_timer_ms": behind.latency_ms,
            "fifo_trigger": behind.fifo_trigger,
            "serial": behind.serial or None,
        }
        for port, behind in ports
    ]
    rows += [{"port": one.port, "adapter": one.name, "driver": analyser.DRIVER} for one in analysers]
    return json.dumps(rows, indent=2)


def short(port: str) -> str:
    """Return the device of a port that is named without its folder: ttyUSB0 becomes /dev/ttyUSB0."""
    device = DEVICES / port
    is_short = sys.platform != "win32" and "/" not in port and ":" not in port and not Path(port).exists()
    return str(device) if port and is_short and device.exists() else port


def run(args: argparse.Namespace) -> int:
    """Print the table of ports; return the exit code."""
    ports, analysers = found(), analyser.plugged_in()
    if args.json:
        print(_as_json(ports, analysers))
        return DONE
    if not ports and not analysers:
        print(f"no serial port found: plug the adapter in; {advice().no_port}")
        return DONE
    rows = [("port", "adapter", "driver", "latency")]
    rows += [(port, visible(behind.name) or "-", behind.driver or "-", behind.latency or "-") for port, behind in ports]
    rows += [(one.port, visible(one.name), analyser.DRIVER, "samples the bus") for one in analysers]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    return DONE
