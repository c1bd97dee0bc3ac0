# SPDX-License-Identifier: GPL-2.0-or-later
"""Keeps a log and what was found in it on disk until all of it has been dissected.

A log is read only once, because it may grow meanwhile, and because finding the bytes is most of the work. The spool
holds enough to write the log again with its explanations. Each batch is a blob of plain tuples, which load fastest.
"""

from __future__ import annotations

import pickle
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from sistap.commands.annotate.cutting import LogRecord, Part, Pieces
from sistap.commands.annotate.notations import Run
from sistap.commands.annotate.reading import Piece
from sistap.commands.annotate.stamps import Stamp
from sistap.commands.annotate.textlog import LogLine
from sistap.tap.common.temporary import Blobs


class Entry(NamedTuple):
    """A line with its number of bytes, and the places of the telegrams and other characters that it completes."""

    line: LogLine | None  # None: after the last line
    size: int
    complete: list[list[Part]]


class Spool:
    """Keeps a log. Use it in a `with`."""

    def __init__(self) -> None:
        self._blobs = Blobs("the log")

    def __enter__(self) -> Spool:
        return self

    def __exit__(self, *error: object) -> None:
        self._blobs.__exit__(*error)

    def put(self, entries: Iterable[tuple[LogLine | None, list[Piece], list[LogRecord]]]) -> None:
        """Keep a batch: lines with their pieces, and the records that they complete. Refusal if there is no room."""
        self._blobs.put(pickle.dumps([_packed(*entry) for entry in entries], pickle.HIGHEST_PROTOCOL))

    def batches(self, progress: Callable[[float], None]) -> Iterator[list[Entry]]:
        """Return the batches in order; call `progress` with the part that has been read, 0 to 1."""
        unpacker = _Unpacker()
        for blob, part in self._blobs.all():
            yield [unpacker.entry(packed) for packed in pickle.loads(blob)]
            progress(part)


_PackedLine = tuple[bytes, bytes, str, str]
_PackedPiece = tuple[int, bool, tuple[Any, ...], tuple[Any, ...] | None]  # direction, continues, run, stamp
_Packed = tuple[_PackedLine | None, list[_PackedPiece], list[tuple[int, int]]]


def _packed(line: LogLine | None, pieces: list[Piece], cuts: list[LogRecord]) -> _Packed:
    return (
        (line.raw, line.ending, line.text, line.encoding) if line else None,
        [
            (piece.direction, piece.continues, tuple(piece.run), tuple(piece.stamp) if piece.stamp else None)
            for piece in pieces
        ],
        # The places of the bytes are counted again: each record has the next bytes of its direction.
        [(cut.record.line, len(cut.record.data)) for cut in cuts],
    )


class _Unpacker:
    """Restores packed entries, in the same order."""

    def __init__(self) -> None:
        self._number = 0
        self._pieces: defaultdict[int, Pieces] = defaultdict(Pieces)  # by direction

    def entry(self, packed: _Packed) -> Entry:
        packed_line, pieces, cuts = packed
        line = None
        size = 0
        if packed_line:
            self._number += 1
            line = LogLine(self._number, *packed_line)
            for direction, continues, run, stamp in pieces:
                size += len(run[-1])
                piece = Piece(line, Run(*run), direction, Stamp(*stamp) if stamp else None, continues)
                self._pieces[direction].add(piece)
        return Entry(line, size, [self._pieces[direction].take(count) for direction, count in cuts])
