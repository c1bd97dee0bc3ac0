# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says about each record of a log.

A complete log is dissected in two passes. These know what only a later telegram tells. A log that is still being
written goes through one running tshark, record by record.
"""

from __future__ import annotations

import queue
from pathlib import Path
from types import TracebackType
from typing import Protocol

from sistap.annotate.blocks import Blocks
from sistap.explain.fields import Fields, Said
from sistap.explain.running import Running as Process
from sistap.records.record import Record
from sistap.wireshark.tshark import Tshark, TsharkError

_ANSWER_S = 30  # longest time that a running tshark takes for an answer


class Sayer(Protocol):
    """Explains records, in their order."""

    def get(self) -> Said:
        """Return the explanation of the next record. May raise TsharkError."""


class Explainer(Sayer, Protocol):
    """A sayer that first has to receive the records."""

    def put(self, record: Record) -> None:
        """Take the next record."""


class WholeCapture:
    """Explains the records of a complete capture file, without its event."""

    def __init__(self, tshark: Tshark, capture: Path) -> None:
        self._fields = Fields(tshark)
        self._lines = tshark.lines(["-r", str(capture), "-2", *self._fields.arguments])
        next(self._lines, None)

    def get(self) -> Said:
        """Return the explanation of the next record."""
        try:
            return self._fields.said(next(self._lines))
        except StopIteration:
            raise TsharkError("tshark has said less than the log holds: is there room for its files?") from None


class Running:
    """Explains records as they come, in one pass. Use it in a `with`."""

    def __init__(self, tshark: Tshark, log: str) -> None:
        self._fields = Fields(tshark)
        self._blocks = Blocks(log)
        self._process = Process(tshark, self._fields.arguments)
        self._first = True

    def put(self, record: Record) -> None:
        """Send a record to tshark."""
        self._process.put(self._blocks.packet(record))

    def get(self) -> Said:
        """Wait for the explanation of the next record."""
        if self._first:
            self._first = False
            self._answer()  # skip the answer to the event
        return self._fields.said(self._answer())

    def _answer(self) -> str:
        try:
            line = self._process.lines.get(timeout=_ANSWER_S)
        except queue.Empty:
            raise TsharkError(
                f"tshark has said nothing for {_ANSWER_S} s: save the log and annotate the file"
            ) from None
        if line is None:
            raise self._process.failure()
        return line

    def __enter__(self) -> Running:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self._process.kill()
        self._process.end()
        self._process.wait()
