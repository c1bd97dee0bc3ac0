# SPDX-License-Identifier: GPL-2.0-or-later
"""Tables of levels, as Saleae Logic, PulseView, DSView and others export them, and Saleae's binary files.

A row of a table has the levels of all channels, 0 or 1, at a time, or in one sample. Comments may come before it.
"""

from __future__ import annotations

import re
import struct
from array import array
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from sistap.commands.imports.saleae import seconds
from sistap.commands.imports.source import NS, Stated, lines
from sistap.commands.imports.wave import NO_END, Wave
from sistap.tap.analyser.probe import hertz
from sistap.tap.terminal.exits import Refusal

SALEAE = "<SALEAE>"

_SAMPLERATE = re.compile(r"sample ?rate: *([1-9][\d.]{0,9} *[kMG]?Hz)", re.IGNORECASE)
_CHANNELS = re.compile(r"Channels \(\d+/\d+\): (.+)")
_TIME = re.compile(r"time\b|(?:milli|micro|nano)?seconds\b", re.IGNORECASE)
_UNIT = re.compile(r"(milli|micro|nano|\bm|\bu|\bn)s(?:econds)?\b", re.IGNORECASE)
_AROUND = ' "\r\n'  # what may stand around a cell
_BEFORE_ALL = -(1 << 62)  # ns
_BINARY = struct.Struct("<8siiIddQ")  # of Logic 2, version 0
_IN_NS = {"m": 10**6, "milli": 10**6, "u": 10**3, "micro": 10**3, "n": 1, "nano": 1}


class _Layout(NamedTuple):
    """What the lines before the first row say."""

    names: list[str]  # of the channels
    separator: str
    unit_ns: int  # of the times; 0: a row is a sample
    samplerate: int | None


def is_table(head: str) -> bool:
    """Tell whether a text begins as a table of levels."""
    return _layout(head.splitlines()) is not None


def read_table(path: Path, stated: Stated) -> Wave:
    """Read a table. May raise Refusal."""
    layout = _layout(lines(path))
    assert layout
    samplerate = stated.samplerate or layout.samplerate
    rate = NS if layout.unit_ns else samplerate or NS
    channels = [array("q") for _ in layout.names]
    now, last = _BEFORE_ALL if layout.unit_ns else -1, 0
    before, warning = None, ""
    try:
        for line in lines(path):
            time, _, row = line.partition(layout.separator) if layout.unit_ns else ("", "", line)
            if row != before:
                levels = _cells(row, layout.separator)
                if not set(levels) <= {"0", "1"}:
                    continue  # a comment, the names, or a row that is cut
            now = max(now, _ns(time, layout.unit_ns)) if layout.unit_ns else now + 1
            if row != before:
                before = row
                last = now
                for channel, level in zip(channels, levels, strict=False):
                    if len(channel) % 2 != int(level):
                        channel.append(now)
    except (ValueError, OverflowError):
        now, warning = max((channel[-1] for channel in channels if channel), default=0), NO_END
    # A last row without a change is the end. Else the levels stay as they are.
    end = now if now > last else now + rate
    return Wave(rate, dict(zip(layout.names, channels, strict=True)), end, samplerate, warning)


def read_saleae(path: Path, stated: Stated) -> Wave:
    """Read a binary file of Saleae Logic 2: one channel. May raise Refusal."""
    try:
        with path.open("rb") as file:
            _, version, kind, level, begin_s, end_s, _ = _BINARY.unpack(file.read(_BINARY.size))
            times = file.read()
        if (version, kind) != (0, 0):
            raise Refusal(f"{path} is not digital, or of a newer version: export the levels as CSV")
        begin = [round(begin_s * NS)] if level else []
        edges = sorted(round(time_s * NS) for (time_s,) in struct.iter_unpack("<d", times[: len(times) // 8 * 8]))
        return Wave(NS, {path.stem: array("q", begin + edges)}, round(end_s * NS), stated.samplerate)
    except (struct.error, ValueError, OverflowError) as error:
        raise Refusal(f"{path} cannot be read ({error}): export it again") from None


def _ns(text: str, unit_ns: int) -> int:
    text = text.strip(_AROUND)
    try:
        return round(float(text.replace(",", ".")) * unit_ns)
    except ValueError:
        return round(seconds(text) * NS)  # a date


def _layout(rows: Iterable[str]) -> _Layout | None:
    """Read the lines up to the first row, that included; None if this is no table of levels."""
    comments = names = row = ""
    for line in rows:
        row = line.strip()
        if row.startswith((";", "#")):
            comments += line
        elif names or not row:
            break
        else:
            names = row
    rate, listed = _SAMPLERATE.search(comments), _CHANNELS.search(comments)
    separator = next((mark for mark in "\t;" if mark in names), ",")
    named, levels = _cells(names, separator), _cells(row, separator)
    unit_ns = 0
    if _TIME.match(named[0]):
        unit = _UNIT.search(named[0])
        unit_ns = _IN_NS[unit[1].lower()] if unit else NS
        named, levels = named[1:], levels[1:]
    if not (unit_ns or rate) or not levels or len(levels) != len(named) or not set(levels) <= {"0", "1"}:
        return None
    if listed and listed[1].count(",") == len(named) - 1:
        named = listed[1].strip().split(", ")
    if len(set(named)) < len(named):  # sigrok calls all of them "logic"
        named = [str(place) for place in range(len(named))]
    return _Layout(named, separator, unit_ns, hertz(rate[1]) if rate else None)


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip(_AROUND) for cell in line.split(separator)]
