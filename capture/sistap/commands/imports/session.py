# SPDX-License-Identifier: GPL-2.0-or-later
"""Sessions of logic analysers: zips that hold samples.

Those of sigrok-cli and PulseView (.sr) have a text `metadata` with the sample rate, the names of the channels and the
bytes of a sample. The samples are in `logic-1-1`, `logic-1-2` and so on, bit n - 1 of each being channel n. Those of
DSView (.dsl) have a text `header`. The samples of channel n are in `L-n/0`, `L-n/1` and so on, eight in a byte, the
first one in the lowest bit.
"""

from __future__ import annotations

import re
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

from sistap.commands.imports.source import Stated
from sistap.commands.imports.wave import HEAD, Wave
from sistap.tap.analyser.finding import BAUDS
from sistap.tap.analyser.probe import hertz
from sistap.tap.analyser.uart import FEWEST_SAMPLES, HIGH, LOW, Edges
from sistap.tap.common.packed import ZIP_ERRORS, zipped
from sistap.tap.terminal.exits import Refusal

_PIECE = 1 << 17  # bytes read at once
_MOST_EDGES = 16_000_000  # of all channels: an hour of a busy bus at 9600 Bd
_MOST_TEXT = 1 << 16  # bytes: a hundred for each channel and more
_EIGHT = [b"".join(HIGH if value >> bit & 1 else LOW for bit in range(8)) for value in range(256)]

_Samples = Iterator[tuple[str, bytes]]  # pieces: the name of the channel, and its next samples, one in each byte


def is_session(path: Path) -> bool:
    """Tell whether a file is a session."""
    names = zipped(path)
    return {"metadata", "version"} <= set(names) or _is_dsview(names)


def read(path: Path, stated: Stated) -> Wave:
    """Read a session. May raise Refusal."""
    try:
        with ZipFile(path) as archive:
            reader = _dsview if _is_dsview(archive.namelist()) else _sigrok
            return _wave(path, *reader(archive, path, stated), stated)
    except ZIP_ERRORS as error:
        raise Refusal(f"{path} cannot be read ({error}): save it again") from None


def _wave(path: Path, samplerate: int, names: Sequence[str], samples: _Samples, stated: Stated) -> Wave:
    """Find the edges. Of a channel that is too fast for a serial line, only the beginning counts."""
    fastest = min(max(BAUDS[-1], stated.baud or 0) / samplerate, 1 / FEWEST_SAMPLES)  # edges in a sample
    edges = {name: Edges() for name in names}
    channels = {name: array("q") for name in names}
    too_fast = set()
    for name, piece in samples:
        if name not in too_fast:
            found = edges[name].feed(piece)
            if len(found) > max(HEAD, len(piece) * fastest):
                too_fast.add(name)
                del found[HEAD:]
            channels[name].extend(found)
            if sum(map(len, channels.values())) > _MOST_EDGES:
                raise Refusal(
                    f"{path} has more than {_MOST_EDGES // 10**6} million edges: save it again with the channels of "
                    "the bus only, or a part of it"
                )
    return Wave(samplerate, channels, max(finder.now for finder in edges.values()), samplerate)


def _opened(archive: ZipFile, name: str) -> IO[bytes]:
    """Open a file in the zip. ValueError if a piece of it can unpack to gigabytes at once."""
    if archive.getinfo(name).compress_type not in (ZIP_STORED, ZIP_DEFLATED):
        raise ValueError(f"{name} is packed as no analyser packs it")
    return archive.open(name)


def _described(archive: ZipFile, text: str, section: str) -> dict[str, str]:
    """Return what a section of a text says: a key and a value in each line."""
    with _opened(archive, text) as file:
        lines = file.read(_MOST_TEXT).decode("utf-8", "replace").splitlines()
    said, is_inside = {}, False
    for line in lines:
        key, _, value = map(str.strip, line.partition("="))  # old sessions have keys that begin with a blank
        if key.startswith("["):
            is_inside = key == f"[{section}]"
        elif is_inside:
            said[key] = value
    return said


def _samplerate(said: Mapping[str, str], path: Path, stated: Stated) -> int:
    with suppress(ValueError):
        return hertz(said.get("samplerate", ""))
    if not stated.samplerate:
        raise Refusal(f"{path} does not say how many samples a second has: add --samplerate HZ")
    return stated.samplerate


def _probes(said: Mapping[str, str]) -> dict[int, str]:
    """Return the names of the channels by their numbers. What names none or several of them goes by its key."""
    probes = {key: name for key, name in said.items() if re.fullmatch(r"probe\d{1,3}", key)}
    count = Counter(probes.values())
    return {int(key[5:]): name if name and count[name] == 1 else key for key, name in probes.items()}


def _parts(archive: ZipFile, begin: str, first: int) -> list[str]:
    """Return the files whose names are this beginning and a number, in order. ValueError unless each is there once."""
    numbers = ((re.fullmatch(re.escape(begin) + r"(\d{1,9})", name), name) for name in archive.namelist())
    parts = sorted((int(match[1]), name) for match, name in numbers if match)
    if [number for number, _ in parts] != [*range(first, first + len(parts))]:
        raise ValueError("parts of its samples are missing, or there twice")
    return [name for _, name in parts]


def _pieces(archive: ZipFile, parts: Sequence[str]) -> Iterator[bytes]:
    for part in parts:
        with _opened(archive, part) as file:
            while piece := file.read(_PIECE):
                yield piece


def _sigrok(archive: ZipFile, path: Path, stated: Stated) -> tuple[int, list[str], _Samples]:
    said = _described(archive, "metadata", "device 1")
    samplerate, unit = _samplerate(said, path, stated), said.get("unitsize", "1")
    size = int(unit) if re.fullmatch(r"\d{1,3}", unit) else 0
    begin = said.get("capturefile", "logic-1")
    parts = _parts(archive, f"{begin}-", 1) or [name for name in archive.namelist() if name == begin]
    places = {name: divmod(number - 1, 8) for number, name in _probes(said).items() if 0 < number <= 8 * size}
    if not 0 < size <= 64 or not places or not parts:
        raise Refusal(f"{path} has no samples of logic channels: save them from sigrok-cli or PulseView")
    tables = [bytes((HIGH if value >> bit & 1 else LOW)[0] for value in range(256)) for bit in range(8)]

    def samples() -> _Samples:
        rest = b""
        for piece in _pieces(archive, parts):
            data = rest + piece
            whole = len(data) - len(data) % size
            rest = data[whole:]
            for name, (place, bit) in places.items():
                yield name, data[place:whole:size].translate(tables[bit])

    return samplerate, list(places), samples()


def _is_dsview(names: Sequence[str]) -> bool:
    return "header" in names and any(re.fullmatch(r"L-\d+/\d+", name) for name in names)


def _dsview(archive: ZipFile, path: Path, stated: Stated) -> tuple[int, list[str], _Samples]:
    said = _described(archive, "header", "header")
    parts = {name: _parts(archive, f"L-{number}/", 0) for number, name in _probes(said).items()}
    if not any(parts.values()):
        raise Refusal(f"{path} has no samples of logic channels: save them from DSView")

    def samples() -> _Samples:
        for name, files in parts.items():
            for piece in _pieces(archive, files):
                yield name, b"".join(map(_EIGHT.__getitem__, piece))

    return _samplerate(said, path, stated), list(parts), samples()
