# SPDX-License-Identifier: GPL-2.0-or-later
"""What an access tells: a number, or a state. Also of a parameter whose attribute nobody has read."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import NamedTuple

from sistap.dissected.accesses.access import Access
from sistap.dissected.episodes.standard import FORMS

RAW = "raw"  # unit of what nobody describes
_DIGITS = 2  # hexadecimal, of a byte
_LENGTHS = {1, 2, 4, 8}  # bytes of a number
_SIGNED = {2 * length for length in (2, 4, 8)}  # digits
_WORDS = 4  # bytes: the two lengths before a text
_SHORT_CODE = 5  # hexadecimal digits of a diagnosis; longer ones are SERCOS III's: bits 16 to 19 are its class
_CLASS_AT = -5
_TEXT_CODE = re.compile(r'"?\s*([A-Z][0-9A-F]{3,4})\b')
_RUNNING = 0x100  # A0101, A101: an operation mode; below are the states ready, halt and others
_BINARY = re.compile(r"0b[01 ]*[01]")  # words may follow: "(clear)"
_HEX = re.compile(r"0x0*([0-9A-Fa-f]+)")


class ValueReading(NamedTuple):
    """A value. Bits and texts have no number."""

    number: float | None
    text: str
    unit: str = ""
    bits: int | None = None


def reading(access: Access) -> ValueReading | None:
    """Return what an access tells of its parameter; None: nothing."""
    if access.error or not access.value:
        return None
    if not access.is_raw:
        form = FORMS.get(access.parameter.ident, "")
        if binary := _BINARY.match(access.value):
            return ValueReading(None, access.value, "", int(binary[0].replace(" ", ""), 2))
        if access.number is not None and (access.value.startswith("0x") or _is_bits(form)):
            return ValueReading(None, access.value, "", int(access.number))
        return ValueReading(access.number, access.value, access.unit)
    return _raw(access.parameter.ident, access.data) if access.data else None


def raw_number(access: Access) -> int | None:
    """Return the bytes of a value as a signed number; None: they are none."""
    data = access.data
    return _signed(data) if data and len(data) in _SIGNED else None


@lru_cache(1024)
def _signed(data: str) -> int:
    return int.from_bytes(bytes.fromhex(data), "little", signed=True)


def _is_bits(form: str) -> bool:
    return form not in ("", "position", "diagnosis_text")


@lru_cache(1024)
def _raw(ident: str, data: str) -> ValueReading | None:
    """Return a value of which only the bytes are known."""
    form = FORMS.get(ident, "")
    content = bytes.fromhex(data)
    if form == "diagnosis_text":
        return ValueReading(None, _text(content))
    if len(content) not in _LENGTHS:
        return ValueReading(None, data)
    number = int.from_bytes(content, "little")
    if _is_bits(form):
        return ValueReading(None, f"0x{number:0{_DIGITS * len(content)}X}", "", number)
    signed = int.from_bytes(content, "little", signed=True)
    return ValueReading(float(signed), str(signed), RAW)


def _text(content: bytes) -> str:
    if int.from_bytes(content[:2], "little") + _WORDS == len(content):
        content = content[_WORDS:]
    return f'"{content.decode("latin-1").rstrip(chr(0))}"'


@lru_cache(256)
def code_of(ident: str, text: str) -> str:
    """Return the diagnosis that a value says, as a drive displays it: F228, F2028, A0101; or ""."""
    if FORMS.get(ident) == "diagnosis_text":
        found = _TEXT_CODE.match(text)
        return found[1] if found else ""
    found = _HEX.match(text)
    digits = found[1].upper() if found else ""
    if text.isdigit():
        digits = f"{int(text):X}"
    return digits if class_of(digits) else ""


def class_of(code: str) -> str:
    """Return the letter of a diagnosis: F an error, E a warning, C a command, A and others a state."""
    letter = code[_CLASS_AT] if len(code) > _SHORT_CODE else code[:1]
    return letter if letter.isalpha() else ""


def is_running(code: str) -> bool | None:
    """Tell whether a drive with this diagnosis is in operation; None: it does not say."""
    letter = class_of(code)
    if letter == "F":
        return False
    if letter != "A" or len(code) > _SHORT_CODE:
        return None
    return int(code[1:], 16) >= _RUNNING
