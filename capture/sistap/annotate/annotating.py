# SPDX-License-Identifier: GPL-2.0-or-later
"""Leads a log from its lines to its explanation: a file in two readings, a pipe in one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from sistap.annotate.capturing import Blocks
from sistap.annotate.cutting import Cut, Cutter
from sistap.annotate.explaining import Explainer
from sistap.annotate.lines import Line
from sistap.annotate.reading import Reader
from sistap.annotate.weaving import Weaver
from sistap.record import Type

Batches = Iterable[list[Line]]  # lines that came together; an empty one: nothing came for a moment
Trouble = Callable[[int, str], None]  # told the number of a line, and why it cannot be read


class Found(NamedTuple):
    """What a line holds, and what is complete by it."""

    size: int  # bytes
    cuts: list[Cut]


class Passage:
    """One reading of a log, from its first line to its last; the same log gives the same each time."""

    def __init__(self, reader: Reader, trouble: Trouble = lambda _, __: None) -> None:
        """Nothing has been read."""
        self._reader = reader
        self._trouble = trouble
        self._cutter = Cutter()
        self.lines = 0
        self.bytes = 0
        self.telegrams = 0

    def feed(self, line: Line) -> Found:
        """Read the next line."""
        pieces, trouble = self._reader.read(line)
        if trouble:
            self._trouble(line.number, trouble)
        cuts: list[Cut] = []
        for piece in pieces:
            cuts += self._cutter.feed(piece)
        size = sum(len(piece.run.data) for piece in pieces)
        self.lines += 1
        self.bytes += size
        return Found(size, self._counted(cuts))

    def end(self) -> list[Cut]:
        """Give what is left."""
        return self._counted(self._cutter.end())

    def _counted(self, cuts: list[Cut]) -> list[Cut]:
        self.telegrams += sum(cut.record.type == Type.FRAME for cut in cuts)
        return cuts


def record(batches: Batches, passage: Passage, log: str, write: Callable[[bytes], object]) -> None:
    """Write a log as a capture, block by block."""
    blocks = Blocks(log)
    for batch in batches:
        for line in batch:
            for cut in passage.feed(line).cuts:
                write(blocks.packet(cut.record))
    for cut in passage.end():
        write(blocks.packet(cut.record))


def weave(
    batches: Batches, passage: Passage, explainer: Explainer, weaver: Weaver, flush: Callable[[], object]
) -> None:
    """Write a log with its explanations. May raise TsharkError."""
    for batch in batches:
        cuts: list[Cut] = []
        for line in batch:
            size, complete = passage.feed(line)
            weaver.add(line, size)
            cuts += complete
        _explain(cuts, explainer, weaver)
        weaver.release(everything=not batch)
        flush()
    _explain(passage.end(), explainer, weaver)
    weaver.end()
    flush()


def _explain(cuts: list[Cut], explainer: Explainer, weaver: Weaver) -> None:
    """Ask for all before the first answer is waited for."""
    for cut in cuts:
        explainer.put(cut.record)
    for cut in cuts:
        weaver.explain(cut, explainer.get())
