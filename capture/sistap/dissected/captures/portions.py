# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures that are too large to be read together: in portions, each of which knows what those before it were told."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from sistap.dissected.captures import reading
from sistap.dissected.captures.joining import alone, begin_ns, in_order, is_foreign, joined
from sistap.dissected.captures.reading import NotCaptured
from sistap.tap.common import temporary
from sistap.tap.files import pcapng
from sistap.tap.records.before import Before, heard
from sistap.tap.records.record import Type

# Bytes of captures that are read at once: tshark needs up to three times as much memory. So it needs about 1 GB.
TOGETHER = 400_000_000

_PACKED_TIMES = 12  # as large is a capture that was compressed
_NANOSECONDS = bytes((9, 0, 1, 0, 9))  # the option of an interface with such times, as sistap writes them
_FIRST = 100  # records among which is what was told before


class Portion(NamedTuple):
    """A file with the packets of captures that are read together."""

    path: Path
    told: int = 0  # packets at its beginning that are in no capture: what was told before


def portions(captures: Iterable[Path], most: int) -> Iterator[list[Path]]:
    """Yield captures that can be joined, in the order of their time, up to so many bytes. A foreign one is alone."""
    portion: list[Path] = []
    size = 0
    for capture in in_order(captures):
        more = _size(capture)
        if portion and (size + more > most or is_foreign(capture) or is_foreign(portion[0])):
            yield portion
            portion, size = [], 0
        portion.append(capture)
        size += more
    yield portion


def _size(capture: Path) -> int:
    """Return how many bytes it has, if it is still there: unpacked, about."""
    try:
        return capture.stat().st_size * (_PACKED_TIMES if capture.suffix == ".gz" else 1)
    except OSError:
        return 0


def in_turn(captures: Sequence[Path], most: int, say: Callable[[str], None]) -> Generator[Portion, None, None]:
    """Yield captures of up to so many bytes, joined, one portion after the other. A larger one is cut into pieces.
    A single one that is small, or foreign, stays as it is.

    Report damage. Raise NotCaptured for a foreign one among several, before anything else.
    """
    if len(captures) == 1 and (_size(captures[0]) <= most or is_foreign(captures[0])):
        yield Portion(captures[0])
        return
    for capture in filter(is_foreign, captures):
        raise NotCaptured(alone(capture))
    read = list(portions(captures, most))
    facts = _Facts()
    is_told = not any(_is_cut(portion, most) for portion in read) and all(_is_told(portion[0]) for portion in read[1:])
    for portion in read:
        for pieces in _pieces(portion[0], most, say) if _is_cut(portion, most) else [portion]:
            with temporary.folder() as folder, joined([*facts.file(folder, pieces), *pieces], say) as together:
                if together.path.stat().st_size:  # not if all are deleted by now
                    yield Portion(together.path, together.number(pieces[0]) - 1)
            if not is_told:
                facts.take(pieces)


def _is_cut(portion: Sequence[Path], most: int) -> bool:
    """Tell whether it is a capture that is too large."""
    return len(portion) == 1 and _size(portion[0]) > most


def _pieces(capture: Path, most: int, say: Callable[[str], None]) -> Iterator[list[Path]]:
    """Yield pieces of a capture, one after the other in the same file. Each begins with the section and interfaces."""
    blocks, heading, has_more = _blocks(capture, say), b"", True
    with temporary.folder() as folder:
        path = folder / "piece.pcapng"
        while has_more:
            with temporary.keeping("a part of the capture"), path.open("wb") as file:
                size, has_more = file.write(heading), False
                for kind, _, body in blocks:
                    block = pcapng.block(kind, body)
                    if kind in (pcapng.SECTION_HEADER, pcapng.INTERFACE_DESCRIPTION):
                        heading = block if kind == pcapng.SECTION_HEADER else heading + block
                    size += file.write(block)
                    if size > most:
                        has_more = True
                        break
            yield [path]


def _blocks(capture: Path, say: Callable[[str], None]) -> Iterator[reading.Block]:
    """Yield the blocks of a capture; report where it is damaged."""
    damages: list[str] = []
    try:
        with reading.opened(capture) as source:
            yield from reading.blocks(source, capture, damages.append)
    except (OSError, NotCaptured) as error:
        damages.append(str(error))
    for damage in damages:
        say(f"{capture}: only what comes before the damage: {damage}")


def _is_told(capture: Path) -> bool:
    """Tell whether what was told before is at its beginning."""
    try:
        return any(record.type == Type.BEFORE for record in islice(reading.records(capture), _FIRST))
    except (OSError, NotCaptured):
        return False


class _Facts:
    """What captures were told, by the description of their interface."""

    def __init__(self) -> None:
        self._before: dict[bytes, Before] = {}

    def take(self, captures: Iterable[Path]) -> None:
        """Take what these were told, up to a damage."""
        for capture in captures:
            try:
                for packet in reading.packets(capture):
                    if _NANOSECONDS in packet.interface and (record := reading.record_of(packet)):
                        self._before.setdefault(packet.interface, Before()).take(heard(record))
            except (OSError, ValueError, IndexError):
                continue

    def file(self, folder: Path, captures: Sequence[Path]) -> list[Path]:
        """Return a capture of it that goes before these, if anything is known."""
        time_ns = begin_ns(captures[0])
        if not self._before or time_ns is None:
            return []
        blocks = [pcapng.section_header("sistap", "")]
        blocks += [pcapng.block(pcapng.INTERFACE_DESCRIPTION, description) for description in self._before]
        for number, before in enumerate(self._before.values()):
            packets = [pcapng.upper_pdu("sertap", record.pack()) for record in before.records(time_ns)]
            blocks += [pcapng.enhanced_packet(number, time_ns, packet) for packet in packets]
        path = folder / "told.pcapng"
        path.write_bytes(b"".join(blocks))
        return [path]
