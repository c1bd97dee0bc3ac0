# SPDX-License-Identifier: GPL-2.0-or-later
"""Records as lines of text, for users without tshark."""

from __future__ import annotations

import time

from sistap.tap.files.output import Output
from sistap.tap.line.settings import Flag
from sistap.tap.records.counters import Counters, longest_interval_ns
from sistap.tap.records.framer_3964r import HANDSHAKE_NAMES
from sistap.tap.records.record import Framing, Record, Type, interval_text
from sistap.tap.sis import telegram
from sistap.tap.sis.telegram import service_name

_FOLD = 16  # characters in a line
_PRINTABLE = bytes(c if 0x20 <= c < 0x7F else ord(".") for c in range(256))
_ERRORS = {
    Flag.CHARACTER_ERROR: "CHARACTER ERROR",
    Flag.BREAK: "BREAK",
    Flag.LOST_BEFORE: "CHARACTERS LOST",
    Flag.UNLOCATED_ERROR: "ERROR SOMEWHERE",
}


class PlainText:
    """Prints records as text, where there is no tshark."""

    def __init__(self, output: Output) -> None:
        """Print to `output`."""
        self._output = output

    def begin(self, *started: Record) -> None:
        """Print nothing: standard error has it."""

    def write(self, record: Record) -> bool:
        """Print a record at once, except an event, which goes to standard error."""
        if record.type == Type.EVENT:
            return False
        self._output.write(lines(record).encode())
        return True

    def look(self, time_ns: int) -> None:
        """Do nothing: there is only one output."""

    def end(self, time_ns: int) -> None:
        """Print nothing."""

    def summary(self, counters: Counters) -> str:
        """Return what was heard."""
        return str(counters)


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
    longest = interval_text(longest_ns) if longest_ns else "not known, all in one read"
    stations = f"{_station(header.talker)} -> {_station(header.listener)}"
    outcome = f"  STATUS 0x{status:02x}" if status else ""
    return (
        f"{stations:10}  {direction:8}  {service_name(header.service)}{outcome}  {checksum}"
        f"  longest interval {longest}"
    )


def _station(address: int) -> str:
    return f"{address} (all)" if address == telegram.BROADCAST else str(address)


def _hex_and_text(data: bytes) -> str:
    return f"{data.hex(' '):{3 * _FOLD - 1}}  |{data.translate(_PRINTABLE).decode()}|"
