# SPDX-License-Identifier: GPL-2.0-or-later
"""Annotations of sigrok's UART decoder, from sigrok-cli and PulseView.

`sigrok-cli --protocol-decoder-samplenum` prints `1104-1938 uart-1: 02`. Between name and text, PulseView puts the class
or the row of the annotation ("RX data", "RX"). With `-l 4`, sigrok-cli puts the class ("rx-data") and all forms of the
text, the longest first.
"""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from fractions import Fraction
from pathlib import Path

from sistap.commands.imports.sampled import Row, SampledLine, UnreadableRow, bits_to_stop
from sistap.commands.imports.source import Stated, lines, need_rate
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.terminal.exits import Refusal

FIRST_LINE = r"\d+-\d+ [^:]+: "

_LINE = re.compile(r'(\d{1,18})-(\d{1,18}) (?P<decoder>[^:]+): (?:(?P<kind>[A-Za-z][\w -]*): )?"?(?P<text>[^"]*)"?.*')
_VALUE = re.compile(r"[0-9A-F]{2}")
# Classes and rows that have characters: no single bits, nothing made of several characters.
_CHARACTERS = re.compile(r"((RX|TX)( data)?|(rx|tx)-data|)")
_ERRORS = {"Parity error": Flag.CHARACTER_ERROR, "Frame error": Flag.CHARACTER_ERROR, "Break condition": Flag.BREAK}


def opened(path: Path, stated: Stated) -> SampledLine:
    """Open a file of annotations. May raise Refusal."""
    if stated.samplerate is None:
        also = "" if stated.settings.baud else ", and the rate of the bus, such as --baud 9600"
        raise Refusal(f"{path} counts samples and does not say how many a second has: add --samplerate HZ{also}")
    need_rate(stated.settings, path)
    return SampledLine(path, _rows(path, stated.settings, stated.samplerate), stated)


def _rows(path: Path, settings: LineSettings, samplerate: int) -> list[Row | UnreadableRow]:
    """Return the characters in the order of the file, each with its errors."""
    bit = Fraction(samplerate, settings.baud)  # in samples
    to_stop = bits_to_stop(settings, after_start=False) * bit
    rows: list[Row | UnreadableRow] = []
    begins: dict[str, list[tuple[int, int]]] = {}  # for each channel: where the data of a row begin, and which row
    errors: list[tuple[str, int, Flag]] = []
    for number, line in enumerate(lines(path), 1):
        match = _LINE.fullmatch(line.strip())
        if not match:
            if line.strip():
                rows.append(UnreadableRow(number, "it is no annotation of sigrok"))
            continue
        start, end, kind, text = int(match[1]), int(match[2]), match["kind"] or "", match["text"]
        channel = f"{match['decoder']} {kind[:2].upper()}".strip()
        if text in _ERRORS:
            errors.append((channel, start, _ERRORS[text]))
        elif _CHARACTERS.fullmatch(kind) and _VALUE.fullmatch(text):
            begins.setdefault(channel, []).append((start, len(rows)))
            rows.append(Row(channel, (end + to_stop) / samplerate, int(text, 16)))
    for channel, start, flag in errors:
        _mark(rows, sorted(begins.get(channel, [])), math.floor(start + bit * 3 / 2), flag)
    return rows


def _mark(rows: list[Row | UnreadableRow], begins: list[tuple[int, int]], latest: int, flag: Flag) -> None:
    """Mark the last character whose data begin up to this sample.

    A break begins with the start bit, a bit before the data. Other errors are behind the data, and the next character
    begins two bits after them.
    """
    index = bisect_right(begins, latest, key=lambda begin: begin[0]) - 1
    if index >= 0:
        row = rows[begins[index][1]]
        assert isinstance(row, Row)
        rows[begins[index][1]] = row._replace(flags=_worst(row.flags | flag))


def _worst(flags: Flag) -> Flag:
    """Return the worst error. A break is also a framing error."""
    return Flag.BREAK if flags & Flag.BREAK else flags
