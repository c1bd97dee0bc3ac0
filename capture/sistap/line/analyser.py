# SPDX-License-Identifier: GPL-2.0-or-later
"""Logic analysers: how a line at one is named, which are plugged in, and the program that reads them (sigrok-cli)."""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qsl

from sistap.line.uart import ENOUGH_SAMPLES

PROGRAM = "sigrok-cli"
PREFIX = "sigrok:"
FORM = "sigrok:DRIVER?rx=CHANNEL&tx=CHANNEL&samplerate=HZ&invert=rx|tx|both"
DRIVER, CHANNEL = "fx2lafw", "D0"  # of the analysers that everybody has
MISSING = f"{PROGRAM} is missing: `apt-get install {PROGRAM}`, or see sigrok.org"
FIRMWARE = Path("/usr/share/sigrok-firmware")
SYSFS = Path("/sys")
DEVICES = Path("/dev/bus/usb")

# Rates that analysers with an FX2 have: the first that samples a bit often enough is taken.
_SAMPLERATES = (4_000_000, 8_000_000, 12_000_000, 24_000_000)
_UNITS = {"": 1, "k": 1_000, "m": 1_000_000, "g": 1_000_000_000}
_INVERTED = {"no": (), "rx": ("rx",), "tx": ("tx",), "both": ("rx", "tx"), "yes": ("rx", "tx")}

# Analysers that sigrok's driver fx2lafw reads, by the numbers of maker and product on USB. An FX2 gets other numbers
# when sigrok-cli has loaded its firmware.
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

    driver: str  # as sigrok-cli takes it, perhaps with ":conn=..."
    channels: tuple[str, ...]  # one, or those of the two directions
    samplerate: int | None = None  # Hz; None: as the rate of the line needs it
    inverted: tuple[bool, ...] = (False, False)

    @classmethod
    def parse(cls, text: str) -> Probe:
        """Read what -i takes. ValueError says what is wrong with it."""
        driver, _, query = text.removeprefix(PREFIX).partition("?")
        said = dict(parse_qsl(query, keep_blank_values=True))
        if unknown := said.keys() - {"rx", "tx", "samplerate", "invert"}:
            raise ValueError(f"{text}: nobody knows {', '.join(sorted(unknown))}: it is written {FORM}")
        channels = (said.get("rx") or CHANNEL, *([said["tx"]] if said.get("tx") else []))
        bad = [name for name in channels if not re.fullmatch(r"[\w.+-]+", name)]
        if not driver or driver.startswith("-") or bad or len(set(channels)) < len(channels):
            raise ValueError(f"{text} is not the address of an analyser: it is written {FORM}")
        if (inverted := said.get("invert", "no")) not in _INVERTED:
            raise ValueError(f"{text}: invert is one of {', '.join(_INVERTED)}")
        rate = said.get("samplerate")
        which = _INVERTED[inverted]
        return cls(driver, channels, hertz(rate) if rate else None, ("rx" in which, "tx" in which))

    def samplerate_for(self, baud: int) -> int:
        """Return the rate to sample a line of this rate at."""
        if self.samplerate:
            return self.samplerate
        return next((rate for rate in _SAMPLERATES if rate >= ENOUGH_SAMPLES * baud), _SAMPLERATES[-1])


class Analyser(NamedTuple):
    """An analyser that is plugged in."""

    name: str
    usb: str  # BUS.ADDRESS, as sigrok-cli takes it
    device: Path

    @property
    def may_be_opened(self) -> bool:
        """Whether this user has the rights."""
        return os.access(self.device, os.R_OK | os.W_OK)

    @property
    def missing(self) -> str:
        """What to do before it can be read; nothing if all is well."""
        if not program():
            return MISSING
        if not self.may_be_opened:
            return (
                f"no permission to open {self.device}: `apt-get install libsigrok4` brings udev rules for whoever sits "
                "at this computer, and for group plugdev; then plug it in again"
            )
        if not any(FIRMWARE.glob("fx2lafw-*")):
            return "its firmware is missing: `apt-get install sigrok-firmware-fx2lafw`"
        return ""

    @property
    def port(self) -> str:
        """What -i takes."""
        return f"{PREFIX}{DRIVER}:conn={self.usb}?rx={CHANNEL}"


def is_analyser(port: str) -> bool:
    """Tell whether a port is the address of one."""
    return port.startswith(PREFIX)


def program() -> str | None:
    """Return where sigrok-cli is, None if it is not there."""
    return shutil.which(PROGRAM)


def hertz(text: str) -> int:
    """Read a rate such as "4m", "500k" or "4 MHz". ValueError says what it has to be."""
    match = re.fullmatch(r"(\d{1,12}(?:\.\d{1,9})?)\s*([kmg]?)(?:hz)?", text.strip(), re.IGNORECASE)
    rate = round(float(match[1]) * _UNITS[match[2].lower()]) if match else 0
    if not 0 < rate <= _UNITS["g"]:
        raise ValueError(f"'{text}' is no rate of samples, such as 4m, 500k or 4000000")
    return rate


def plugged_in(sysfs: Path = SYSFS, devices: Path = DEVICES) -> list[Analyser]:
    """List the analysers of this machine that need no other driver than fx2lafw. Nothing is opened."""
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
