# SPDX-License-Identifier: GPL-2.0-or-later
"""Logic analysers: their addresses, which are plugged in, and the program that reads them (sigrok-cli)."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qsl

from sistap.tap.analyser.uart import ENOUGH_SAMPLES
from sistap.tap.terminal.programs import on_path

PROGRAM = "sigrok-cli"
PREFIX = "sigrok:"
FORM = "sigrok:DRIVER?rx=CHANNEL&tx=CHANNEL&samplerate=HZ&invert=rx|tx|both"
DRIVER, CHANNEL = "fx2lafw", "D0"  # of the most common analysers
MISSING = f"{PROGRAM} is missing: `apt-get install {PROGRAM}`, or see sigrok.org"
FIRMWARE = Path("/usr/share/sigrok-firmware")
SYSFS = Path("/sys")
DEVICES = Path("/dev/bus/usb")

# Sample rates of analysers with an FX2. The first that samples a bit often enough is used.
_SAMPLERATES = (4_000_000, 8_000_000, 12_000_000, 24_000_000)
_UNITS = {"": 1, "k": 1_000, "m": 1_000_000, "g": 1_000_000_000}
_INVERTED = {"no": (), "rx": ("rx",), "tx": ("tx",), "both": ("rx", "tx"), "yes": ("rx", "tx")}

# Analysers that sigrok's driver fx2lafw reads, by USB vendor and product number. An FX2 gets other numbers when
# sigrok-cli has loaded its firmware.
_FX2 = {
    "0925:3881": "Saleae Logic or a copy of it",
    "04b4:8613": "Cypress FX2 without a name",
    "08a9:0009": "USBee SX",
    "08a9:0014": "USBee AX",
    "08a9:0015": "USBee DX",
    "16d0:0498": "Braintechnology USB-LPS",
    "1d50:608c": "FX2 with 8 channels",
    "1d50:608d": "FX2 with 16 channels",
}


class Probe(NamedTuple):
    """The lines at an analyser."""

    driver: str  # as for sigrok-cli, perhaps with ":conn=..."
    channels: tuple[str, ...]  # one, or those of the two directions
    samplerate: int | None = None  # Hz; None: chosen by the rate of the line
    inverted: tuple[bool, ...] = (False, False)

    @classmethod
    def parse(cls, text: str) -> Probe:
        """Parse an address given to -i. ValueError says what is wrong with it."""
        driver, _, query = text.removeprefix(PREFIX).partition("?")
        said = dict(parse_qsl(query, keep_blank_values=True))
        if unknown := said.keys() - {"rx", "tx", "samplerate", "invert"}:
            raise ValueError(f"{text}: unknown: {', '.join(sorted(unknown))}; write it as {FORM}")
        channels = (said.get("rx") or CHANNEL, *([said["tx"]] if said.get("tx") else []))
        bad = [name for name in channels if not re.fullmatch(r"[\w.+-]+", name)]
        if not driver or driver.startswith("-") or bad or len(set(channels)) < len(channels):
            raise ValueError(f"{text} is not the address of an analyser: write it as {FORM}")
        if (inverted := said.get("invert", "no")) not in _INVERTED:
            raise ValueError(f"{text}: invert is one of {', '.join(_INVERTED)}")
        rate = said.get("samplerate")
        which = _INVERTED[inverted]
        return cls(driver, channels, hertz(rate) if rate else None, ("rx" in which, "tx" in which))

    def samplerate_for(self, baud: int) -> int:
        """Return the sample rate for a line of this rate."""
        if self.samplerate:
            return self.samplerate
        return next((rate for rate in _SAMPLERATES if rate >= ENOUGH_SAMPLES * baud), _SAMPLERATES[-1])


class Analyser(NamedTuple):
    """An analyser that is plugged in."""

    name: str
    usb: str  # BUS.ADDRESS, as for sigrok-cli
    device: Path

    @property
    def may_be_opened(self) -> bool:
        """Tell whether this user may open it."""
        return os.access(self.device, os.R_OK | os.W_OK)

    @property
    def missing(self) -> str:
        """Return what to do before it can be read; empty if nothing."""
        if not program():
            return MISSING
        if not self.may_be_opened:
            return (
                f"no permission to open {self.device}: `apt-get install libsigrok4` installs udev rules for the user "
                "at this computer and for group plugdev; then plug it in again"
            )
        if not any(FIRMWARE.glob("fx2lafw-*")):
            return "its firmware is missing: `apt-get install sigrok-firmware-fx2lafw`"
        return ""

    @property
    def port(self) -> str:
        """Return its address for -i."""
        return f"{PREFIX}{DRIVER}:conn={self.usb}?rx={CHANNEL}"


def is_analyser(port: str) -> bool:
    """Tell whether a port is the address of an analyser."""
    return port.startswith(PREFIX)


def program() -> str | None:
    """Return the path of sigrok-cli; None if it is not installed."""
    return on_path(PROGRAM)


def hertz(text: str) -> int:
    """Parse a sample rate such as "4m", "500k" or "4 MHz". ValueError says what is expected."""
    match = re.fullmatch(r"(\d{1,12}(?:\.\d{1,9})?)\s*([kmg]?)(?:hz)?", text.strip(), re.IGNORECASE)
    rate = round(float(match[1]) * _UNITS[match[2].lower()]) if match else 0
    if not 0 < rate <= _UNITS["g"]:
        raise ValueError(f"'{text}' is not a sample rate, such as 4m, 500k or 4000000")
    return rate


def plugged_in(sysfs: Path = SYSFS, devices: Path = DEVICES) -> list[Analyser]:
    """List the analysers of this computer that the driver fx2lafw reads. Nothing is opened."""
    if sys.platform != "linux":
        return []
    found = []
    for folder in sorted((sysfs / "bus/usb/devices").glob("*")):
        known = _FX2.get(f"{_line(folder / 'idVendor')}:{_line(folder / 'idProduct')}")
        bus, address = _line(folder / "busnum"), _line(folder / "devnum")
        if known and bus.isdecimal() and address.isdecimal():
            name = _line(folder / "product") or known
            found.append(Analyser(name, f"{bus}.{address}", devices / f"{int(bus):03}" / f"{int(address):03}"))
    return found


def _line(file: Path) -> str:
    try:
        return file.read_text(errors="replace").strip()
    except OSError:
        return ""
