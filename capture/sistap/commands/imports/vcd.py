# SPDX-License-Identifier: GPL-2.0-or-later
"""Value change dumps (IEEE 1364, chapter 18), as sigrok, PulseView, DSView, Saleae and simulators write them."""

from __future__ import annotations

import re
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path

from sistap.commands.imports.source import Stated, lines
from sistap.commands.imports.wave import NO_END, Wave
from sistap.tap.analyser.probe import hertz
from sistap.tap.terminal.exits import Refusal

_UNITS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9, "ps": 10**12, "fs": 10**15}
_ACQUIRED = re.compile(r"\bat (\d[\d.]* [kMG]?Hz)\b")  # what sigrok says of its samples


def is_dump(head: str) -> bool:
    """Tell whether a text begins as a dump."""
    return re.match(r"\$(date|version|comment|timescale|scope|var)\b", head) is not None


def read(path: Path, stated: Stated) -> Wave:
    """Read a dump: its signals of one bit. May raise Refusal."""
    words = (word for line in lines(path) for word in line.split())
    try:
        header = _Header(words)
    except (ValueError, OverflowError) as error:
        raise Refusal(f"{path} is no value change dump that can be read ({error})") from None
    edges = {code: array("q") for code in header.names}
    channels = {header.names[code]: signal for code, signal in edges.items()}
    try:
        end, warning = _take(words, edges, header.rate), ""
    except (ValueError, OverflowError):
        end, warning = max((signal[-1] for signal in edges.values() if signal), default=0) + header.rate, NO_END
    return Wave(header.rate, channels, end, header.samplerate, warning)


class _Header:
    """What comes before the changes."""

    def __init__(self, words: Iterator[str]) -> None:
        self.rate = 0
        self.samplerate: int | None = None
        self.names: dict[str, str] = {}  # of signals, by their codes
        known = set()
        scopes: list[str] = []
        for word in words:
            if word == "$enddefinitions":
                break
            said = list(iter(lambda: next(words, "$end"), "$end"))
            match word, said:
                case "$timescale", _:
                    self.rate = _rate("".join(said))
                case "$comment", _ if acquired := _ACQUIRED.search(" ".join(said)):
                    self.samplerate = hertz(acquired[1])
                case "$scope", [_, scope, *_]:
                    scopes.append(scope)
                case "$upscope", _:
                    del scopes[-1:]
                case "$var", [_, "1", code, name, *_] if code not in self.names:
                    names = (name, ".".join([*scopes, name]), f"{name} {code}")
                    self.names[code] = next(one for one in names if one not in known)
                    known.add(self.names[code])
        if not self.rate:
            raise ValueError("no $timescale")


def _rate(text: str) -> int:
    match = re.fullmatch(r"(1|10|100)([munpf]?s)", text)
    if not match or _UNITS[match[2]] % int(match[1]):
        raise ValueError(f"$timescale {text}")
    return _UNITS[match[2]] // int(match[1])


def _take(words: Iterator[str], edges: Mapping[str, array[int]], rate: int) -> int:
    """Add the edges of the signals, by their codes; return the end. May raise ValueError and OverflowError."""
    now = last = 0
    for word in words:
        level, code = word[0], word[1:]
        if level == "#":
            now = max(now, int(code))
        elif word == "$comment":
            while next(words, "$end") != "$end":
                pass
        elif level in "bBrR":  # vectors and real numbers are not among the signals; but a bit may be written as b1
            level, code = code, next(words, "")
        signal = edges.get(code)
        if signal is not None and level in ("0", "1") and len(signal) % 2 != int(level):
            signal.append(now)
            last = now
    return now if now > last else now + rate
