# SPDX-License-Identifier: GPL-2.0-or-later
"""Files of other tools with the same command and reaction, for the page: USB captures, exports of logic analysers."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

from sampled_wire import NS, Sent, sampled
from usb_captures import STATUS, Host, Recorder, UsbPcap, cdc, ftdi

from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.telegram import build

# Figure 8-21 of the SIS definition: the phase is read, and it is 2.
COMMAND = build(0x12, 16, 3)
REACTION = build(0x12, 16, 3, b"\0\x02", reaction=True)
SETTINGS = LineSettings(9600)
SAMPLERATE = 1_000_000
METADATA = "[device 1]\ncapturefile=logic-1\nsamplerate=1 MHz\nprobe1=D0\nunitsize=1\n"
_CHARACTER_S = Fraction(11, SETTINGS.baud)


class Recording(NamedTuple):
    """How a file is made, and what it does not say."""

    write: Callable[[Path], object]
    options: tuple[str, ...] = ()
    said: str = ""  # a part of what `sistap import` says of it


def _usb(host: Host, status: bytes) -> Host:
    host.send(10, 18, COMMAND)
    host.receive(5, 60, status + REACTION)
    return host


def _ftdi(recorder: Recorder | None = None) -> Recording:
    return Recording(_usb(ftdi(recorder), STATUS).save, (), "9600 Bd 8E1, as the adapter was set")


def _characters() -> list[Sent]:
    """Return the characters of the wire, by the middles of their stop bits."""
    sent = []
    for begin_s, telegram in ((Fraction(1, 100), COMMAND), (Fraction(6, 100), REACTION)):
        for place, value in enumerate(telegram, 1):
            time_s = begin_s + place * _CHARACTER_S - Fraction(1, 2 * SETTINGS.baud)
            sent.append(Sent(time_s * NS, value, SETTINGS))
    return sent


def session(path: Path, channel: str = "D0") -> None:
    """Write a session of sigrok."""
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        archive.writestr("version", "2")
        archive.writestr("metadata", METADATA.replace("D0", channel))
        archive.writestr("logic-1-1", sampled([_characters()], SAMPLERATE, NS // 10))


def _saleae(path: Path) -> None:
    took_s = _CHARACTER_S - Fraction(1, 2 * SETTINGS.baud)  # from the start bit on
    rows = [
        f'"Async Serial","data",{float(sent.time_ns / NS - took_s):.9f},{float(took_s):.9f},0x{sent.value:02X},'
        for sent in _characters()
    ]
    path.write_text("\n".join(["name,type,start_time,duration,data,error", *rows, ""]))


RECORDINGS = {
    "ftdi.pcap": _ftdi(),
    "windows.pcap": _ftdi(UsbPcap()),
    "cdc.pcap": Recording(_usb(cdc(), b"").save, (), "9600 Bd 8E1, as the adapter was set"),
    "pulseview.sr": Recording(session, (), "9600 Bd 8E1, "),
    "saleae.csv": Recording(_saleae, ("--baud", "9600"), "9600 Bd 8E1, as given"),
}
