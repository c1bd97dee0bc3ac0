# SPDX-License-Identifier: GPL-2.0-or-later
"""Converts a source into a capture: its reads go through the assembler to the writer."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable

import sistap
from sistap.commands.imports.source import Source
from sistap.dissected.wireshark.tshark import TsharkError
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Read
from sistap.tap.records.assembler import Assembler
from sistap.tap.records.counters import Counters
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.record import Event, event

_PROGRESS_S = 0.5
_LOOK_NS = 100_000_000  # interval between checks whether a line is silent


class Conversion:
    """The conversion of one source into one capture."""

    def __init__(self, source: Source, writer: PcapngWriter, counters: Counters, name: str, cut: Cut = SIS) -> None:
        """`name` is the name of the file in messages; frames are cut as `cut` says."""
        self._source = source
        self._writer = writer
        self._counters = counters
        self._name = name
        self._assembler = Assembler(cut)
        self._begun = False
        self._now_ns = 0
        self._looked_ns = 0
        # number of characters for each uncertainty, in ns, rounded to two digits
        self.uncertainties: Counter[int] = Counter()

    def run(self, stopped: Callable[[], bool], progress: Callable[[str], None]) -> None:
        """Read to the end, or until `stopped`. May raise TsharkError and OutputError."""
        try:
            self._read(stopped, progress)
        except TsharkError:  # what came before is saved
            self._finish()
            raise
        self._finish()

    def _read(self, stopped: Callable[[], bool], progress: Callable[[str], None]) -> None:
        shown = time.monotonic()
        for read in self._source.reads():
            if not self._begun:
                self._begin(read.time_ns)
            self._take(read)
            if time.monotonic() - shown >= _PROGRESS_S:
                shown = time.monotonic()
                progress(str(self._counters))
            if stopped():
                break

    def _finish(self) -> None:
        self._assembler.flush(self._assembler.lines, self._now_ns)
        self._write_due()
        self._writer.end(self._now_ns)

    def _begin(self, time_ns: int) -> None:
        source = self._source
        self._begun = True
        for line in source.lines:
            self._assembler.add_line(line, source.settings, time_ns)
        said = f"sistap {sistap.__version__}; imported from {self._name}: "
        how = f"{source.settings}, {source.settings_from}; {source.timing}{self._assembler.cut.said}"
        self._writer.begin(
            *(
                event(
                    time_ns,
                    line,
                    source.settings,
                    Event.CAPTURE_STARTED,
                    f"{said}{text}; {how}",
                )
                for line, text in source.lines.items()
            )
        )

    def _take(self, read: Read) -> None:
        lines = self._assembler.lines
        if read.line not in lines:  # the only direction there is
            read = read._replace(line=lines[0])
        self._now_ns = max(self._now_ns, read.time_ns)
        self._counters.add_read(read)
        self.uncertainties[_rounded(read.uncertainty_ns)] += len(read.data)
        self._assembler.take(read, self._now_ns, self._source.settings_from)
        if self._now_ns - self._looked_ns >= _LOOK_NS:  # one line can be silent while another is not
            self._looked_ns = self._now_ns
            self._assembler.idle(self._now_ns)
        self._write_due()

    def _write_due(self) -> None:
        for record in self._assembler.due(self._now_ns):
            self._counters.add_record(record, written=self._writer.write(record))


def _rounded(uncertainty_ns: int) -> int:
    """Round up to two digits; unknown stays unknown."""
    if uncertainty_ns == UNCERTAINTY_UNKNOWN:
        return uncertainty_ns
    step = int(10 ** max(len(str(uncertainty_ns)) - 2, 0))
    return -(-uncertainty_ns // step) * step
