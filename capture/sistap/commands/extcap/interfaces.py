# SPDX-License-Identifier: GPL-2.0-or-later
"""The interfaces in Wireshark's list: each serial port, a logic analyser, and the demo bus.

Wireshark stores the settings of an interface under its name. So the name is that of the adapter, if the system has one
(/dev/serial/by-id, from vendor, model and serial number): the adapter keeps it at any USB port. Other ports have the
name of their device. Wireshark gets its answers in lines: `kind {key=value}{key=value}`.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import NamedTuple

from sistap.tap.analyser import probe
from sistap.tap.line import ports
from sistap.tap.terminal.console import visible

_NOT_IN_A_VALUE = str.maketrans("{}\r\n", "()  ")  # Wireshark has no way to quote them


def sentence(kind: str, **values: object) -> str:
    """Return a line; leave out None and empty values, except an empty `value`."""
    said = {key: str(value) for key, value in values.items() if value is not None and (value != "" or key == "value")}
    return f"{kind} " + "".join(f"{{{key}={text}}}" for key, text in said.items())


def plain(text: str) -> str:
    """Make a text from elsewhere safe for a sentence."""
    return visible(text.translate(_NOT_IN_A_VALUE))


BY_ID = Path("/dev/serial/by-id")
DEVICES = Path("/dev")
PREFIX = "sistap-"
DEMO = PREFIX + "demo"
ANALYSER = PREFIX + "sigrok"


class ExtcapInterface(NamedTuple):
    """One line of Wireshark's list."""

    name: str
    display: str

    def __str__(self) -> str:
        return sentence("interface", value=self.name, display=self.display)


def found() -> list[ExtcapInterface]:
    """List the ports, then the interfaces that need none. Without pyserial list only these, and say why."""
    try:
        names = _adapter_names()
        of_ports = [_of_port(port, str(behind.name), names) for port, behind in ports.found()]
        return [*of_ports, *_analyser(), ExtcapInterface(DEMO, "SIS demo bus")]
    except ModuleNotFoundError:
        why = f"no serial ports: pyserial is missing for {sys.executable}"
        return [*_analyser(), ExtcapInterface(DEMO, plain(f"SIS demo bus ({why})"))]


def _analyser() -> list[ExtcapInterface]:
    """List one analyser for all that sigrok-cli can read: its dialog asks for the analyser and the channel."""
    if not probe.program():
        return []
    names = ", ".join(one.name for one in probe.plugged_in())
    return [ExtcapInterface(ANALYSER, plain(f"SIS tap: logic analyser ({names or 'by sigrok-cli'})"))]


def port_of(name: str) -> str:
    """Return the device of an interface, which need not exist any more."""
    known_as = name.removeprefix(PREFIX)
    link = BY_ID / known_as
    if os.path.lexists(link):
        return os.path.realpath(link)
    return known_as if sys.platform == "win32" else str(DEVICES / known_as)


def _of_port(port: str, adapter: str, names: dict[str, str]) -> ExtcapInterface:
    device = Path(port).name
    described = f"SIS tap: {device} ({adapter})" if adapter else f"SIS tap: {device}"
    return ExtcapInterface(PREFIX + names.get(ports.real(port), device), plain(described))


def _adapter_names() -> dict[str, str]:
    """Return the names of adapters, keyed by their devices."""
    links = sorted(BY_ID.iterdir()) if BY_ID.is_dir() else []
    return {os.path.realpath(link): link.name for link in reversed(links)}
