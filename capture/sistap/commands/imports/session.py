# SPDX-License-Identifier: GPL-2.0-or-later
"""Sessions of logic analysers: zips that hold samples.

Those of sigrok-cli and PulseView (.sr) have a text `metadata` with the sample rate, the names of the channels and the
bytes of a sample. The samples are in `logic-1-1`, `logic-1-2` and so on, bit n - 1 of each being channel n. Those of
DSView (.dsl) have a text `header`. The samples of channel n are in `L-n/0`, `L-n/1` and so on, eight in a byte, the
first one in the lowest bit.
"""

from __future__ import annotations

import re
import zlib
from array import array
from collections.abc import Iterator, Sequence
from configparser import ConfigParser, SectionProxy
from configparser import Error as ConfigError
from pathlib import Path
from zipfile import BadZipFile, ZipFile, is_zipfile

from sistap.commands.imports.source import Stated
from sistap.commands.imports.wave import HEAD, Wave
from sistap.tap.analyser.finding import BAUDS
from sistap.tap.analyser.probe import hertz
from sistap.tap.analyser.uart import FEWEST_SAMPLES, HIGH, LOW, Edges
from sistap.tap.terminal.exits import Refusal

_PIECE = 1 << 17  # bytes read at once
_MOST_EDGES = 16_000_000  # of all channels: an hour of a busy bus at 9600 Bd
_MOST_TEXT = 1 << 20  # bytes
_EIGHT = [b"".join(HIGH if value >> bit & 1 else LOW for bit in range(8)) for value in range(256)]

_Samples = Iterator[tuple[str, bytes]]  # pieces: the name of the channel, and its next samples, one in each byte


def is_session(path: Path) -> bool:
    """Tell whether a file is a session."""
    try:
        if not is_zipfile(path):
            return False
        with ZipFile(path) as archive:
            return {"metadata", "version"} <= set(archive.namelist()) or _is_dsview(archive)
    except (BadZipFile, OSError):
        return False


def read(path: Path, stated: Stated) -> Wave:
    """Read a session. May raise Refusal."""
    try:
        with ZipFile(path) as archive:
            reader = _dsview if _is_dsview(archive) else _sigrok
            return _wave(path, *reader(archive, path, stated), stated)
    except (BadZipFile, OSError, EOFError, NotImplementedError, RuntimeError, zlib.error) as error:
        raise Refusal(f"{path} cannot be read ({error}): save it again") from None
    except (ConfigError, KeyError, ValueError) as error:
        raise Refusal(f"{path} is no session with samples of logic ({error})") from None


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


def _described(archive: ZipFile, text: str, section: str) -> SectionProxy:
    config = ConfigParser(interpolation=None, strict=False)
    with archive.open(text) as file:
        lines = file.read(_MOST_TEXT).decode("utf-8", "replace").splitlines()
    config.read_string("\n".join(map(str.strip, lines)))  # old sessions have keys that begin with a blank
    return config[section]


def _samplerate(said: SectionProxy, path: Path, stated: Stated) -> int:
    if rate := said.get("samplerate"):
        return hertz(rate)
    if not stated.samplerate:
        raise Refusal(f"{path} does not say how many samples a second has: add --samplerate HZ")
    return stated.samplerate


def _probes(said: SectionProxy) -> dict[int, str]:
    """Return the names of the channels by their numbers."""
    return {int(key[5:]): name for key, name in said.items() if re.fullmatch(r"probe\d{1,3}", key)}


def _parts(archive: ZipFile, begin: str) -> list[str]:
    """Return the files whose names are this beginning and a number, in order."""
    numbers = ((re.fullmatch(re.escape(begin) + r"(\d{1,9})", name), name) for name in archive.namelist())
    return [name for _, name in sorted((int(match[1]), name) for match, name in numbers if match)]


def _pieces(archive: ZipFile, parts: Sequence[str]) -> Iterator[bytes]:
    for part in parts:
        with archive.open(part) as file:
            while piece := file.read(_PIECE):
                yield piece


def _sigrok(archive: ZipFile, path: Path, stated: Stated) -> tuple[int, list[str], _Samples]:
    said = _described(archive, "metadata", "device 1")
    size, samplerate = int(said.get("unitsize", "1")), _samplerate(said, path, stated)
    begin = said.get("capturefile", "logic-1")
    parts = _parts(archive, f"{begin}-") or [name for name in archive.namelist() if name == begin]
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


def _is_dsview(archive: ZipFile) -> bool:
    names = archive.namelist()
    return "header" in names and any(re.fullmatch(r"L-\d+/\d+", name) for name in names)


def _dsview(archive: ZipFile, path: Path, stated: Stated) -> tuple[int, list[str], _Samples]:
    said = _described(archive, "header", "header")
    parts = {name: _parts(archive, f"L-{number}/") for number, name in _probes(said).items()}

    def samples() -> _Samples:
        for name, files in parts.items():
            for piece in _pieces(archive, files):
                yield name, b"".join(map(_EIGHT.__getitem__, piece))

    return _samplerate(said, path, stated), list(parts), samples()
