# SPDX-License-Identifier: GPL-2.0-or-later
"""Cures in the words of each system: one column each for Linux, Windows and macOS."""

from __future__ import annotations

import shlex
import subprocess
import sys
from typing import NamedTuple


class Advice(NamedTuple):
    """Cures, each a clause to follow a colon."""

    no_port: str  # an adapter was plugged in, and there is no port
    late: str  # other programs make a capture late
    tshark: str
    wireshark: str  # tshark is installed, Wireshark is not
    libpcap: str
    no_pseudo_terminal: str
    in_use: str  # another program has the port {port}: what follows "by another program"
    held: str  # a file cannot be replaced or removed
    started: str  # how to start Wireshark with the profile
    path: str  # {folder} is not in PATH
    remove: str  # the {folder} of a user
    latency_timer: str  # of an FTDI adapter: {name} is its name in Windows
    ports_group: str = ""  # users of serial ports must belong to it
    package: str = ""  # how to remove the package of the system
    no_wireshark: str = ""  # none was found; it may be somewhere else
    null_device: str = "restart the computer"  # what a program reads or writes in place of nothing is not there


_LINUX = Advice(
    no_port="if it does not appear, `sudo dmesg | tail` says why",
    late="run sistap with sudo, or put `@dialout - rtprio 1` into /etc/security/limits.conf and log in again",
    tshark="Debian and Ubuntu: `apt-get install tshark`",
    wireshark="`apt-get install wireshark`",
    libpcap="install the package libpcap0.8 (or libpcap)",
    no_pseudo_terminal="close some terminals",
    in_use="(often ModemManager): `sudo fuser -v {port}` names it",
    held="see who may write to its folder",
    started="start it with `wireshark -C SIS`",
    path='`export PATH={folder}:"$PATH"`, also as a line of ~/.profile; on Debian and Ubuntu a new login is enough',
    remove="`rm -r {folder}` removes it",
    latency_timer="`echo 1 | sudo tee /sys/bus/usb-serial/devices/ttyUSB0/latency_timer`",
    ports_group="dialout",
    package="`sudo apt-get remove sistap` removes the Debian package",
    null_device="`sudo rm -f /dev/null; sudo mknod -m 666 /dev/null c 1 3` makes it anew",
)

_MACOS = _LINUX._replace(
    no_port="if it does not appear, see System Information > USB, and install its driver",
    late="end other programs that need the processor",
    tshark="install Wireshark, which includes it",
    wireshark="install Wireshark",
    libpcap="macOS includes it: start sistap with the Python of this system",
    path='`export PATH={folder}:"$PATH"`, also as a line of ~/.zprofile',
    in_use="(also by its other name, /dev/cu.* or /dev/tty.*): `lsof {port}` names it",
    latency_timer="the driver of macOS has no such setting: capture on a Linux computer, through ssh",
    ports_group="",
    package="",
    null_device="restart the computer",
)

_WINDOWS = Advice(
    no_port="if it does not appear, Device Manager > Ports (COM & LPT) shows whether its driver is missing",
    late="end other programs that need the processor, and choose the power plan High performance",
    tshark="run Wireshark's installer again and tick TShark",
    wireshark="run Wireshark's installer again and tick Wireshark",
    libpcap="install Npcap, which Wireshark's installer includes",
    no_pseudo_terminal="Windows has none: use --listen HOST:PORT, or --port PORT --transmit",
    in_use=": close that program first",
    held="a program has it open: close Wireshark, then try again",
    started="start it, and choose the profile SIS at the right end of its status bar",
    path="Settings > System > About > Advanced system settings > Environment Variables > Path > Edit > New adds it, "
    "for windows that are opened then; py -m sistap works without it",
    remove="delete {folder} to remove it",
    latency_timer="in Device Manager > Ports (COM & LPT) > {name} > Properties > Port Settings > Advanced set Latency "
    "Timer (msec) to 1, then start again",
    no_wireshark="install it, with TShark; if it is in another folder, as a portable one is, type sistap install "
    "--wireshark FOLDER",
)

_OF_SYSTEM = {"darwin": _MACOS, "win32": _WINDOWS}


def advice(system: str = "") -> Advice:
    """Return the column of a system, named as in sys.platform; by default of this system."""
    return _OF_SYSTEM.get(system or sys.platform, _LINUX)


def shell_word(text: str, system: str = "") -> str:
    """Return a word of a command that a person can copy: quoted as the shell of the system needs it."""
    return subprocess.list2cmdline([text]) if (system or sys.platform) == "win32" else shlex.quote(text)
