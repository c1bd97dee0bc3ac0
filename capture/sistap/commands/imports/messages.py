# SPDX-License-Identifier: GPL-2.0-or-later
"""Converts a table of messages into packets for a dissector by name: `--dissector`.

A line has a time in s, the sender (M: master, S: slave), and the bytes in hexadecimal. A message is whole. So there are
no characters and no times inside it, and the capture has no `sertap` records.
"""

from __future__ import annotations

import platform
import re
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import sistap
from sistap.commands.imports.source import lines
from sistap.tap.files import pcapng
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import Interface, PacketFlags
from sistap.tap.terminal.exits import Refusal, why

DISSECTORS = ("synaxpk", "synaxpcp", "synaxpd", "arcnet7f")

_SENDERS = {"M": PacketFlags.OUTBOUND, "S": PacketFlags.INBOUND}
_TIME = re.compile(r"\d{1,10}(\.\d+)?")
_LATEST_S = 9_000_000_000  # the end of what Wireshark shows
_LARGEST = 65_535  # bytes of a message
_SHOWN = 24  # characters of a cell
_LINE = "a line is time,M or S,bytes, such as 0.125,M,0082 000C 0002"


class Message(NamedTuple):
    """One message."""

    time_ns: int
    sender: PacketFlags
    data: bytes


def read(path: Path) -> list[Message]:
    """Read the whole table. Refusal names the line that is wrong, and the cure."""
    try:
        messages = list(_messages(path))
    except OSError as error:
        raise Refusal(f"cannot read {path}: {why(error)}; name a table of messages") from None
    if not messages:
        raise Refusal(f"{path} has no messages in it: {_LINE}")
    return messages


def _messages(path: Path) -> Iterator[Message]:
    for number, line in enumerate(lines(path), 1):
        if not line.strip() or line.startswith("#") or (number == 1 and re.match(r'\s*"?[A-Za-z]', line)):
            continue  # the first line may name the columns
        try:
            yield _message(line)
        except ValueError as error:
            raise Refusal(f"{path}:{number}: {error}") from None


def _message(line: str) -> Message:
    separator = ";" if ";" in line else ","
    cells = [cell.strip().strip('"').strip() for cell in line.split(separator)]
    if len(cells) != len(Message._fields):
        raise ValueError(f"there are {len(cells)} columns, not 3; {_LINE}")
    time, sender, data = cells
    if sender.upper() not in _SENDERS:
        raise ValueError(f"{_quoted(sender)} is no direction; write M for the master, S for the slave")
    return Message(_nanoseconds(time.replace(",", ".")), _SENDERS[sender.upper()], _bytes(data))


def _nanoseconds(text: str) -> int:
    if not _TIME.fullmatch(text) or Fraction(text) > _LATEST_S:
        raise ValueError(f"{_quoted(text)} is no time; write seconds, such as 0.125")
    return round(Fraction(text) * 1_000_000_000)


def _bytes(text: str) -> bytes:
    try:
        data = bytes.fromhex(text)
    except ValueError:
        raise ValueError(f"{_quoted(text)} is no row of bytes; write two hexadecimal digits a byte") from None
    if not data or len(data) > _LARGEST:
        raise ValueError(f"there are {len(data)} bytes; a message has 1 to {_LARGEST}")
    return data


def _quoted(text: str) -> str:
    return f"'{text[:_SHOWN]}{'...' if len(text) > _SHOWN else ''}'"


def write(output: Output, dissector: str, name: str, messages: list[Message]) -> None:
    """Write the messages as packets of one interface; `name` is that of the table. May raise OutputError."""
    interface = Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, dissector, f"messages imported from {name}")
    output.begin()
    output.write(pcapng.section_header(f"sistap {sistap.__version__}", f"{platform.system()} {platform.release()}"))
    output.write(pcapng.interface_description(interface))
    for message in messages:
        data = pcapng.upper_pdu(dissector, message.data)
        output.write(pcapng.enhanced_packet(0, message.time_ns, data, int(message.sender)))
