# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says of each record: the only place where an explanation comes from.

A log that is there as a whole is dissected in two passes, which know what only a later telegram tells; one that is
still being written goes through one running tshark, record by record.
"""

from __future__ import annotations

import contextlib
import queue
import tempfile
import threading
from pathlib import Path
from types import TracebackType
from typing import NamedTuple, Protocol

from sistap.annotate.blocks import Blocks
from sistap.records.record import Record
from sistap.wireshark import rows
from sistap.wireshark.rows import INFO_FIELDS, NECESSARY, NO_DISSECTOR, first, info, unknown_fields
from sistap.wireshark.tshark import Tshark, TsharkError

_REACTION, _UNANSWERED = "sis.reaction_time", "sis.command.unanswered"
_FIELDS = (*INFO_FIELDS, NECESSARY, _REACTION, _UNANSWERED)
_INFO_COLUMN = ("-o", 'gui.column.format:"Info","%i"')  # the user's own columns may be without
_ANSWER_S = 30  # so long, at most, does a running tshark take


class Said(NamedTuple):
    """What the dissector says of a record."""

    info: str
    is_telegram: bool
    reaction_s: float | None  # after its command, from packet to packet
    unanswered: bool


class Sayer(Protocol):
    """Says of records what they are, in their order."""

    def get(self) -> Said:
        """Return what is said of the next record. May raise TsharkError."""


class Explainer(Sayer, Protocol):
    """A sayer that has to be told the records first."""

    def put(self, record: Record) -> None:
        """Take the next record."""


class Fields:
    """The fields of an explanation that this tshark knows."""

    def __init__(self, tshark: Tshark, more: tuple[str, ...] = ()) -> None:
        """Ask tshark, also for others. TsharkError if it has no dissector for SIS."""
        self._names = [*_FIELDS, *more]
        with tempfile.TemporaryFile() as nothing:
            unknown = unknown_fields(tshark.run(["-r", "-", *self.arguments], stdin=nothing).stderr)
        if NECESSARY in unknown:
            raise TsharkError(NO_DISSECTOR)
        self._names = [name for name in self._names if name not in unknown]

    @property
    def arguments(self) -> list[str]:
        """What tells tshark to print them."""
        return [*_INFO_COLUMN, *rows.printing(self._names)]

    def columns(self, line: str) -> dict[str, str]:
        """Take apart what it prints for one packet; several values are joined by JOINT."""
        return rows.columns(self._names, line)

    def said(self, line: str) -> Said:
        """Read what it prints for one record."""
        return said(self.columns(line))


def said(columns: dict[str, str]) -> Said:
    """Return what is said of one record."""
    reaction = first(columns.get(_REACTION, ""))
    return Said(
        info(columns),
        bool(columns.get(NECESSARY)),
        float(reaction) if reaction else None,
        bool(columns.get(_UNANSWERED)),
    )


class WholeCapture:
    """Explains the records of a capture file that is complete, its event left out."""

    def __init__(self, tshark: Tshark, capture: Path) -> None:
        """Start reading it."""
        self._fields = Fields(tshark)
        self._lines = tshark.lines(["-r", str(capture), "-2", *self._fields.arguments])
        next(self._lines, None)

    def get(self) -> Said:
        """Return what is said of the next record."""
        try:
            return self._fields.said(next(self._lines))
        except StopIteration:
            raise TsharkError("tshark has said less than the log holds: is there room for its files?") from None


class Running:
    """Explains records as they come, in one pass. Use it in a `with`."""

    def __init__(self, tshark: Tshark, log: str) -> None:
        """Start tshark."""
        self._fields = Fields(tshark)
        self._blocks = Blocks(log)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the rest
        self._process = tshark.start(["-r", "-", "-l", *self._fields.arguments], self._errors)
        self._said: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._first = True
        # A thread, because tshark must never have to wait with its answers while it is written to.
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            self._said.put(line.decode(errors="replace").rstrip("\n"))
        self._said.put(None)

    def put(self, record: Record) -> None:
        """Send a record to tshark."""
        assert self._process.stdin
        try:
            self._process.stdin.write(self._blocks.packet(record))
            self._process.stdin.flush()
        except OSError:
            raise self._failure() from None

    def get(self) -> Said:
        """Wait for what it says of the next record."""
        if self._first:
            self._first = False
            self._answer()  # the event
        return self._fields.said(self._answer())

    def _answer(self) -> str:
        try:
            line = self._said.get(timeout=_ANSWER_S)
        except queue.Empty:
            raise TsharkError(
                f"tshark has said nothing for {_ANSWER_S} s: save the log and annotate the file"
            ) from None
        if line is None:
            raise self._failure()
        return line

    def _failure(self) -> TsharkError:
        self._process.wait()
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        return TsharkError(said[-1] if said else f"tshark ended with exit code {self._process.returncode}")

    def __enter__(self) -> Running:
        """Nothing more to do."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End tshark."""
        assert self._process.stdin
        if kind is not None:
            self._process.kill()
        with contextlib.suppress(OSError):
            self._process.stdin.close()
        self._process.wait()
        self._errors.close()
