# SPDX-License-Identifier: GPL-2.0-or-later
"""What Wireshark lists: an interface for each serial port, a logic analyser, a distant tap, and the demo bus.

Wireshark keeps what a person sets for an interface under its name. So the name is that of the adapter where the system
has one (/dev/serial/by-id, from its maker, model and serial number): it is the same adapter wherever it is plugged in
again. Other ports are named as their device.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import NamedTuple

from sistap.extcap.sentences import plain, sentence
from sistap.line import analyser, ports

BY_ID = Path("/dev/serial/by-id")
DEVICES = Path("/dev")
PREFIX = "sistap-"
DEMO = PREFIX + "demo"
DISTANT = PREFIX + "distant"  # what it is the tap of, its dialog says
ANALYSER = PREFIX + "sigrok"


class Interface(NamedTuple):
    """One line of Wireshark's list."""

    name: str
    display: str

    def __str__(self) -> str:
        return sentence("interface", value=self.name, display=self.display)


def found() -> list[Interface]:
    """List the ports there are, then what needs none; without pyserial that alone, and it says why."""
    distant = Interface(DISTANT, "SIS tap on another computer (sistap serve)")
    try:
        names = _adapter_names()
        of_ports = [_of_port(port, str(behind.name), names) for port, behind in ports.found()]
        return [*of_ports, *_analyser(), distant, Interface(DEMO, "SIS demo bus")]
    except ModuleNotFoundError:
        why = f"no serial ports: pyserial is missing for {sys.executable}"
        return [*_analyser(), distant, Interface(DEMO, plain(f"SIS demo bus ({why})"))]


def _analyser() -> list[Interface]:
    """List one for whatever sigrok-cli can read: which analyser, and where the line is, the dialog says."""
    if not analyser.program():
        return []
    names = ", ".join(one.name for one in analyser.plugged_in())
    return [Interface(ANALYSER, plain(f"SIS tap: logic analyser ({names or 'by sigrok-cli'})"))]


def port_of(name: str) -> str:
    """Return the device of an interface, which need not exist any more."""
    known_as = name.removeprefix(PREFIX)
    link = BY_ID / known_as
    if os.path.lexists(link):
        return os.path.realpath(link)
    return known_as if sys.platform == "win32" else str(DEVICES / known_as)


def _of_port(port: str, adapter: str, names: dict[str, str]) -> Interface:
    device = Path(port).name
    described = f"SIS tap: {device} ({adapter})" if adapter else f"SIS tap: {device}"
    return Interface(PREFIX + names.get(ports.real(port), device), plain(described))


def _adapter_names() -> dict[str, str]:
    """Return the names of adapters by their devices."""
    links = sorted(BY_ID.iterdir()) if BY_ID.is_dir() else []
    return {os.path.realpath(link): link.name for link in reversed(links)}
