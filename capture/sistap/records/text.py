# SPDX-License-Identifier: GPL-2.0-or-later
"""A record as lines of text, for users without Wireshark."""

from __future__ import annotations

import time

from sistap.line.settings import Flag
from sistap.records.counters import longest_interval_ns
from sistap.records.framer_3964r import HANDSHAKE_NAMES
from sistap.records.record import Framing, Record, Type
from sistap.sis import telegram
from sistap.sis.names import service_name

_FOLD = 16  # characters in a line
_PRINTABLE = bytes(c if 0x20 <= c < 0x7F else ord(".") for c in range(256))
_ERRORS = {
    Flag.CHARACTER_ERROR: "CHARACTER ERROR",
    Flag.BREAK: "BREAK",
    Flag.LOST_BEFORE: "CHARACTERS LOST",
    Flag.UNLOCATED_ERROR: "ERROR SOMEWHERE",
}


def lines(record: Record) -> str:
    """Return a frame or other characters as complete lines, with the number of the line if there are two."""
    seconds, ns = divmod(record.time_ns, 1_000_000_000)
    when = time.strftime("%H:%M:%S", time.localtime(seconds)) + f".{ns // 1000:06d}"
    if record.line:
        when += f"  {record.line}"
    errors = record.errors
    marks = "".join(f"  {text}" for flag, text in _ERRORS.items() if flag & errors)
    if record.type == Type.FRAME and record.framing == Framing.SIS:
        return f"{when}  {_telegram(record)}{marks}\n"
    if record.is_handshake:
        return f"{when}  {HANDSHAKE_NAMES[record.data[0]]}{marks}\n"
    if record.type == Type.FRAME and record.framing == Framing.PROCEDURE_3964R:
        marks = f"  BCC {'WRONG' if record.checksum_bad else 'ok'}{marks}"
    return "".join(
        f"{when if i == 0 else ' ' * len(when)}  {_hex_and_text(record.data[i : i + _FOLD])}{marks if i == 0 else ''}\n"
        for i in range(0, len(record.data), _FOLD)
    )


def _telegram(record: Record) -> str:
    header = telegram.parse(record.data)
    direction = "Reaction" if header.reaction else "Command"
    checksum = "checksum WRONG" if record.checksum_bad else "checksum ok"
    status = telegram.status(header)
    longest_ns = longest_interval_ns(record)
    longest = f"{longest_ns / 1e6:.3f} ms" if longest_ns else "not known, all in one read"
    stations = f"{_station(header.talker)} -> {_station(header.listener)}"
    outcome = f"  STATUS 0x{status:02x}" if status else ""
    return (
        f"{stations:10}  {direction:8}  {service_name(header.service)}{outcome}  {checksum}"
        f"  longest interval {longest}"
    )


def _station(address: int) -> str:
    return "all" if address == telegram.BROADCAST else str(address)


def _hex_and_text(data: bytes) -> str:
    return f"{data.hex(' '):{3 * _FOLD - 1}}  |{data.translate(_PRINTABLE).decode()}|"
