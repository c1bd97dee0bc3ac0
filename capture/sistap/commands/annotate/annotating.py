# SPDX-License-Identifier: GPL-2.0-or-later
"""Turns the lines of a log into its explanation: a file by way of a spool and a capture, a pipe as it comes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from sistap.commands.annotate.annotator import Annotator
from sistap.commands.annotate.blocks import LogBlocks
from sistap.commands.annotate.cutting import LogRecord, RecordCutter
from sistap.commands.annotate.explaining import LiveCapture, WholeCapture
from sistap.commands.annotate.reading import LogReader, Piece
from sistap.commands.annotate.spool import LogEntry, Spool
from sistap.commands.annotate.textlog import LogLine
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.framer import ASCII_WORD
from sistap.tap.records.record import Type
from sistap.tap.sis.telegram import START

LONGEST_LINE = 1_000_000  # characters; each takes 350 bytes of memory while they are read

Batches = Iterable[list[LogLine]]  # lines that came together; an empty one: nothing came for a moment
Trouble = Callable[[int, str], None]  # called with the number of a line and the reason why it cannot be read


class FoundInLine(NamedTuple):
    """What a line holds, and the telegrams that it completes."""

    pieces: list[Piece]
    cuts: list[LogRecord]

    @property
    def size(self) -> int:
        """The number of bytes in the line."""
        return sum(len(piece.run.data) for piece in self.pieces)


class Passage:
    """The reading of a log, from its first line to its last."""

    def __init__(
        self,
        reader: LogReader,
        trouble: Trouble = lambda _, __: None,
        framing: Cut = SIS,
        *,
        takes_cut: bool = False,
    ) -> None:
        """Read with this reader; call `trouble` for lines that cannot be read; `framing` says what a frame is.

        With `takes_cut`, bytes that begin as a telegram are a damaged one, whatever else is there.
        """
        self._reader = reader
        self._trouble = trouble
        self._cutter = RecordCutter(framing)
        self._framing = framing
        self._takes_cut = takes_cut
        self.lines = 0
        self.bytes = 0
        self.telegrams = 0  # right ones
        self.has_ascii = False  # between telegrams of SIS, there are words of the ASCII protocol

    @property
    def uncertainty_ns(self) -> int:
        """Of the worst time; 0 without times."""
        return self._cutter.uncertainty_ns

    def feed(self, line: LogLine) -> FoundInLine:
        """Read the next line."""
        if len(line.text) > LONGEST_LINE:
            self._trouble(line.number, f"longer than {LONGEST_LINE:,} characters: only its beginning is explained")
            line.text = line.text[:LONGEST_LINE].rpartition(" ")[0]
        self._look_for_ascii(line.text.encode("latin-1", errors="replace"))
        pieces, trouble = self._reader.contents(line)
        if trouble:
            self._trouble(line.number, trouble)
        cuts: list[LogRecord] = []
        for piece in pieces:
            cuts += self._cutter.feed(piece)
        found = FoundInLine(pieces, self._counted(cuts))
        self.lines += 1
        self.bytes += found.size
        return found

    def end(self) -> list[LogRecord]:
        """Return what is left."""
        return self._counted(self._cutter.end())

    def _counted(self, cuts: list[LogRecord]) -> list[LogRecord]:
        return [self._judged(cut) for cut in cuts]

    def _judged(self, cut: LogRecord) -> LogRecord:
        """Count a record. In a log of another protocol, some bytes look like a damaged telegram."""
        record = cut.record
        if record.is_good_frame:
            self.telegrams += 1
        elif self._takes_cut and record.data[0] == START:
            return cut._replace(record=record._replace(type=Type.FRAME, checksum_bad=True))
        elif record.type == Type.OTHER or not (self.telegrams or self._reader.is_trusted):
            self._look_for_ascii(record.data)
            return cut._replace(record=record._replace(type=Type.OTHER, checksum_bad=False))
        return cut

    def _look_for_ascii(self, data: bytes) -> None:
        if self._framing == SIS and not self.has_ascii:
            self.has_ascii = ASCII_WORD.search(data) is not None


def record(
    batches: Batches, passage: Passage, log: str, write: Callable[[bytes], object], spool: Spool | None = None
) -> None:
    """Write a log as a capture, block by block, and keep the log itself in a spool. May raise Refusal."""
    blocks = LogBlocks(log)
    for batch in batches:
        entries = []
        for line in batch:
            found = passage.feed(line)
            entries.append(LogEntry(line, found.size, [cut.parts for cut in found.cuts]))
            for cut in found.cuts:
                write(blocks.packet(cut.record))
        if spool and entries:
            spool.put(entries)
    rest = passage.end()
    for cut in rest:
        write(blocks.packet(cut.record))
    if spool:
        spool.put([LogEntry(None, 0, [cut.parts for cut in rest])])


def annotate_recorded(
    batches: Iterable[list[LogEntry]], sayer: WholeCapture, annotator: Annotator, flush: Callable[[], object]
) -> None:
    """Write a log that `record` has kept, with its explanations. May raise TsharkError."""
    for batch in batches:
        for line, size, complete in batch:
            if line:
                annotator.add(line, size)
            for parts in complete:
                annotator.explain(parts, sayer.get())
        annotator.release()
        flush()
    annotator.end(sayer.answer())
    flush()


def annotate_live(
    batches: Batches, passage: Passage, explainer: LiveCapture, annotator: Annotator, flush: Callable[[], object]
) -> None:
    """Write a log with its explanations live. May raise TsharkError."""
    for batch in batches:
        cuts: list[LogRecord] = []
        for line in batch:
            found = passage.feed(line)
            annotator.add(line, found.size)
            cuts += found.cuts
        _explain(cuts, explainer, annotator)
        annotator.release(everything=not batch)
        flush()
    _explain(passage.end(), explainer, annotator)
    annotator.end()
    flush()


def _explain(cuts: list[LogRecord], explainer: LiveCapture, annotator: Annotator) -> None:
    """Send all records of a batch before waiting for the first answer."""
    for cut in cuts:
        explainer.put(cut.record)
    for cut in cuts:
        annotator.explain(cut.parts, explainer.get())
