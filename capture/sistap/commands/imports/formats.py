# SPDX-License-Identifier: GPL-2.0-or-later
"""The files that can be imported. Each is recognised by its contents, never by its name."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from sistap.commands.imports import levels, saleae, session, sigrok, usb_transfers, usbmon, vcd, wave
from sistap.commands.imports.dissected import protocols
from sistap.commands.imports.rtac import RtacCapture
from sistap.commands.imports.source import Source, Stated
from sistap.commands.imports.usb import UsbCapture
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.packed import unpack
from sistap.tap.files.pcapng import FIRST_BYTES
from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.exits import Refusal, why


class TextFormat(NamedTuple):
    """A text that its first line identifies."""

    name: str
    first_line: str  # regular expression
    opened: Callable[[Path, Stated], Source]


class Form(NamedTuple):
    """A recording of a logic analyser."""

    name: str
    is_it: Callable[[Path, str], bool]  # by the file and its beginning
    read: Callable[[Path, Stated], wave.Wave]


class CaptureFormat(NamedTuple):
    """A capture file that a protocol in its first packets identifies."""

    name: str
    protocol: str  # in frame.protocols
    opened: Callable[[Tshark, Path, Stated], Source]


CAPTURES = (
    CaptureFormat(
        "USB captures (usbmon, USBPcap) of an adapter: FTDI, CH340, CP210x, PL2303, CDC",
        "usb",
        lambda tshark, path, stated: UsbCapture(usb_transfers.Transfers(tshark, path), path, stated),
    ),
    CaptureFormat("RTAC serial captures", "rtacser", RtacCapture),
)
TEXTS = (
    TextFormat("data tables of Saleae Logic 2", saleae.LOGIC_2.first_line, saleae.reader(saleae.LOGIC_2)),
    TextFormat("exports of Saleae Logic 1", saleae.LOGIC_1.first_line, saleae.reader(saleae.LOGIC_1)),
    TextFormat(
        "exports of Saleae Logic 1, all analysers", saleae.LOGIC_1_ALL.first_line, saleae.reader(saleae.LOGIC_1_ALL)
    ),
    TextFormat(
        "texts of usbmon, of the same adapters",
        usbmon.FIRST_LINE,
        lambda path, stated: UsbCapture(usbmon.UsbmonTransfers(path), path, stated),
    ),
    TextFormat("annotations of sigrok-cli and PulseView with sample numbers", sigrok.FIRST_LINE, sigrok.opened),
)
WAVES = (
    Form(
        "sessions of sigrok-cli, PulseView (.sr) and DSView (.dsl)",
        lambda path, _: session.is_session(path),
        session.read,
    ),
    Form("value change dumps (.vcd)", lambda _, head: vcd.is_dump(head), vcd.read),
    Form(
        "tables of levels (.csv) of Saleae, PulseView, DSView", lambda _, head: levels.is_table(head), levels.read_table
    ),
    Form("binary exports of Saleae Logic 2 (.bin)", lambda _, head: head.startswith(levels.SALEAE), levels.read_saleae),
)
NAMES = tuple(known.name for known in (*CAPTURES, *TEXTS, *WAVES))

_HEAD = 4096  # bytes that contain the first line


def opened(path: Path, stated: Stated, tools: ExitStack) -> Source:
    """Recognise a file and open it; `tools` keeps what it needs. May raise Refusal and TsharkError."""
    if opener := known(path):
        return opener(path, stated)
    tshark = tools.enter_context(Tshark())
    seen = protocols(tshark, path)
    for capture in CAPTURES:
        if capture.protocol in seen:
            return capture.opened(tshark, path, stated)
    if packed := unpack(path):
        raise Refusal(packed)
    if _first(path).startswith(FIRST_BYTES):
        raise Refusal(f"{path} is a capture that Wireshark reads as it is: `sistap log {shell_word(str(path))}`")
    raise Refusal(
        f"{path} is none of the files that can be imported. For a log with bytes in hexadecimal: "
        f"`sistap annotate {shell_word(str(path))} -w FILE`. These can be imported: {'; '.join(NAMES)}"
    )


def known(path: Path) -> Callable[[Path, Stated], Source] | None:
    """Return what opens a file of a logic analyser; None: it is none. May raise Refusal."""
    head = _first(path).decode(errors="replace").removeprefix("\ufeff").lstrip()
    for text in TEXTS:
        if re.match(text.first_line, head):
            return text.opened
    for form in WAVES:
        if form.is_it(path, head):
            return lambda path, stated: wave.opened(path, form.read(path, stated), stated)
    return None


def _first(path: Path) -> bytes:
    if path.exists() and not path.is_file() and not path.is_dir():
        raise Refusal(f"{path} is not a file: it is read more than once, so save it first")
    try:
        with path.open("rb") as file:
            return file.read(_HEAD)
    except OSError as error:
        raise Refusal(f"cannot read {path}: {why(error)}; name a file that another tool has recorded") from None
