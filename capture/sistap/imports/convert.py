# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes a capture of a source: characters through the framer of their line, records in order of time to the writer."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable

import sistap
from sistap.files.writer import PcapngWriter
from sistap.imports.source import Source
from sistap.line.settings import UNCERTAINTY_UNKNOWN, Read
from sistap.records.counters import Counters
from sistap.records.framer import SisFramer
from sistap.records.order import Order
from sistap.records.record import Event, Record, event
from sistap.wireshark.tshark import TsharkError

_PROGRESS_S = 0.5
_LOOK_NS = 100_000_000  # how often a line is asked whether it has been silent for long


class Conversion:
    """One source on its way into one capture."""

    def __init__(self, source: Source, writer: PcapngWriter, counters: Counters, name: str) -> None:
        """Nothing is read yet; `name` is that of the file for people."""
        self._source = source
        self._writer = writer
        self._counters = counters
        self._name = name
        self._framers = {line: SisFramer(line, source.settings) for line in source.lines}
        self._last_ns = {line: 0 for line in source.lines}  # when a character came
        self._order = Order()
        self._begun = False
        self._now_ns = 0
        self._looked_ns = 0
        self.uncertainties: Counter[int] = Counter()  # of how many characters each is, in ns, to two digits

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
        for framer in self._framers.values():
            self._emit(framer.flush())
        self._writer.end(self._now_ns)

    def _begin(self, time_ns: int) -> None:
        source = self._source
        self._begun = True
        self._last_ns = dict.fromkeys(self._last_ns, time_ns)
        said = f"sistap {sistap.__version__}; imported from {self._name}: "
        self._writer.begin(
            *(
                event(
                    time_ns,
                    line,
                    source.settings,
                    Event.CAPTURE_STARTED,
                    f"{said}{text}; {source.settings}, {source.settings_from}; {source.timing}",
                )
                for line, text in source.lines.items()
            )
        )

    def _take(self, read: Read) -> None:
        if read.line not in self._framers:  # the only direction there is
            read = read._replace(line=next(iter(self._framers)))
        framer = self._framers[read.line]
        self._now_ns = max(self._now_ns, read.time_ns)
        self._counters.add_read(read)
        self.uncertainties[_rounded(read.uncertainty_ns)] += len(read.data)
        if read.settings not in (None, framer.settings):
            self._take_settings(framer, read)
        self._emit(framer.feed(read))
        self._last_ns[read.line] = self._now_ns
        self._look()

    def _take_settings(self, framer: SisFramer, read: Read) -> None:
        """Note that this is the first read with other settings."""
        assert read.settings
        self._emit(framer.flush())
        framer.settings = read.settings
        text = f"{read.settings}: {self._source.settings_from}"
        self._emit([event(read.time_ns, framer.line, read.settings, Event.SETTINGS_CHANGED, text)])

    def _look(self) -> None:
        """Let a line that has been silent give what it holds back, though others are not."""
        if self._now_ns - self._looked_ns >= _LOOK_NS:
            self._looked_ns = self._now_ns
            for line, framer in self._framers.items():
                self._emit(framer.idle(self._now_ns - self._last_ns[line]))

    def _emit(self, records: list[Record]) -> None:
        """Write records, and those of the other line, in order of time."""
        if not records and self._order.empty:
            return
        self._order.add(records, self._now_ns)
        for record in self._order.due((framer.oldest_ns for framer in self._framers.values()), self._now_ns):
            written = self._writer.write(record)
            if record.event == Event.NONE:
                self._counters.accepted[record.line] += written
                self._counters.add_record(record)


def _rounded(uncertainty_ns: int) -> int:
    """Round up to two digits; what is unknown stays so."""
    if uncertainty_ns == UNCERTAINTY_UNKNOWN:
        return uncertainty_ns
    step = int(10 ** max(len(str(uncertainty_ns)) - 2, 0))
    return -(-uncertainty_ns // step) * step
