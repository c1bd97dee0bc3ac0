# SPDX-License-Identifier: GPL-2.0-or-later
"""A drive's ASCII protocol: characters in, echo, answer and prompt out (MPH-02 p. 10-86 to 10-91, public clients).

BCD:21 opens drive 21 and closes the others; an open drive repeats each line before it answers. What no document says
is chosen: a binary value has all its digits, a hexadecimal one none in front, an attribute eight.
"""

from __future__ import annotations

import re
import struct
from decimal import Decimal, InvalidOperation

from sisbus.devices.device import Device
from sisbus.devices.parameters import AccessError, Element, Parameter, as_list, ident
from sistap.dissected.telegrams.attribute import LENGTH_WORDS, Format

_CR, _LF = 0x0D, 0x0A
_LONGEST = 255  # characters of a line
_END = "\r\n"

# Errors of the protocol itself (fig. 10-51); the others are those of parameter services.
WRONG_TYPE, WRONG_SET, NOT_RECOGNIZED, NO_ELEMENT, NEITHER_R_NOR_W, WRONG_DATA = (
    0x9002,
    0x9003,
    0x9004,
    0x9005,
    0x9006,
    0x9007,
)

_OPEN = re.compile(r"BCD:(\d{1,3})")
_ACCESS = re.compile(r"([A-Z])-(\d+)-(\d{1,4}),(\d+),(.*)")


class Terminal:
    """The protocol of one drive."""

    def __init__(self, address: int, device: Device) -> None:
        self._address = address
        self._device = device
        self._line = bytearray()
        self._is_open = False
        self._list: tuple[Parameter, list[bytes]] | None = None  # being written, with its elements so far

    def hear(self, value: int, now_ns: int) -> bytes | None:
        """Take a character; return what the drive says to the line that it ends, None if nothing."""
        if value == _CR:
            line, self._line = self._line.decode("latin-1"), bytearray()
            said = self._take(line, now_ns)
            return None if said is None else said.encode("latin-1")
        if 0x20 <= value < 0x7F and len(self._line) < _LONGEST:
            self._line.append(value)
        elif value != _LF:
            self._line.clear()
        return None

    def _take(self, line: str, now_ns: int) -> str | None:
        opened = _OPEN.fullmatch(line)
        if opened:
            self._list = None
            self._is_open = int(opened[1]) == self._address
            return self._prompt if self._is_open else None
        if not self._is_open:
            return None
        try:
            answer = self._add(line, now_ns) if self._list else self._access(line, now_ns)
        except AccessError as error:
            self._list = None
            answer = [f"#{error.code:04X}"]
        return "".join(text + _END for text in (line, *answer)) + ("?" if self._list else self._prompt)

    @property
    def _prompt(self) -> str:
        return f"E{self._address:02}:>"

    def _access(self, line: str, now_ns: int) -> list[str]:
        if not line:
            return []
        asked = _ACCESS.fullmatch(line)
        if not asked:
            raise AccessError(NOT_RECOGNIZED)
        kind, set_number, number, element, what = asked.groups()
        for wrong, code in (
            (kind not in "SP", WRONG_TYPE),
            (int(set_number) > 7, WRONG_SET),
            (not 1 <= int(element) <= 7, NO_ELEMENT),
            (what.lower() != "r" and not what.lower().startswith("w,"), NEITHER_R_NOR_W),
            (int(number) > 0xFFF, NOT_RECOGNIZED),
        ):
            if wrong:
                raise AccessError(code)
        key = ident(f"{kind}-{set_number}-{int(number):04}")
        if what.lower() == "r":
            return self._read(key, Element(int(element)), now_ns)
        return self._write(key, Element(int(element)), what[2:], now_ns)

    def _read(self, key: bytes, element: Element, now_ns: int) -> list[str]:
        data = self._device.read(key, element, now_ns)
        parameter = self._device.find(key)
        if element == Element.IDENT_NUMBER:
            return [parameter.ident]
        if element in (Element.NAME, Element.UNIT):
            return [data[LENGTH_WORDS:].decode("latin-1")]
        if element == Element.ATTRIBUTE:
            return [f"{int.from_bytes(data, 'little'):08X}"]
        if not parameter.attribute.is_list or element != Element.DATA:
            return [_shown(parameter, data)]
        elements = data[LENGTH_WORDS:]
        if parameter.attribute.format == Format.TEXT:
            return [elements.decode("latin-1")]
        size = parameter.attribute.size
        return [_shown(parameter, elements[start : start + size]) for start in range(0, len(elements), size)]

    def _write(self, key: bytes, element: Element, value: str, now_ns: int) -> list[str]:
        parameter = self._device.find(key)
        if element == Element.IDENT_NUMBER:
            status = self._device.write(key, element, b"", now_ns)
            return [f"{int.from_bytes(status, 'little'):04X}"]
        if element == Element.DATA and parameter.attribute.is_list and value == ">":
            parameter.check_writable(element, self._device.phases.at(now_ns))
            self._list = parameter, []
            return []
        self._device.write(key, element, _read_value(parameter, value), now_ns)
        return []

    def _add(self, line: str, now_ns: int) -> list[str]:
        """Take an element of a list, or its end: a list of fixed length keeps the elements that were not given."""
        if not self._list:
            return []
        parameter, elements = self._list
        if line != "<":
            elements.append(_read_value(parameter, line))
            return []
        self._list = None
        given = b"".join(elements)
        rest = parameter.data[LENGTH_WORDS + len(given) :] if parameter.fixed_length else b""
        room = int.from_bytes(parameter.data[2:LENGTH_WORDS], "little")
        self._device.write(ident(parameter.ident), Element.DATA, as_list(given + rest, room), now_ns)
        return []


def _shown(parameter: Parameter, data: bytes) -> str:
    """Write a value as people read it."""
    format = parameter.attribute.format
    number = int.from_bytes(data, "little", signed=format == Format.SIGNED)
    if format == Format.FLOAT:
        return f"{struct.unpack('<f', data)[0]:.4f}"
    if format == Format.BINARY:
        return f"{number:0{8 * len(data)}b}"
    if format == Format.HEXADECIMAL:
        return f"{number:X}"
    if format == Format.IDENT_NUMBER:
        return f"{'P' if number & 0x8000 else 'S'}-{number >> 12 & 7}-{number & 0xFFF:04}"
    return f"{Decimal(number).scaleb(-parameter.attribute.decimals):f}"


def _read_value(parameter: Parameter, value: str) -> bytes:
    """Read a value, also with the ends b and h of binary and hexadecimal ones. May raise AccessError."""
    format = parameter.attribute.format
    try:
        if format == Format.FLOAT:
            return struct.pack("<f", float(value))
        if value[-1:] == "b":
            number = int(value[:-1], 2)
        elif format == Format.HEXADECIMAL or value[-1:] == "h":
            number = int(value.removesuffix("h"), 16)
        else:
            number = int(Decimal(value).scaleb(parameter.attribute.decimals))
        return number.to_bytes(parameter.attribute.size, "little", signed=format == Format.SIGNED)
    except (ValueError, InvalidOperation, OverflowError):
        raise AccessError(WRONG_DATA) from None
