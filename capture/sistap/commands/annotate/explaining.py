# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says about each record of a log.

A complete log is dissected in two passes. These know what only a later telegram tells. A log that is still being
written goes through one running tshark, record by record.
"""

from __future__ import annotations

import queue
from pathlib import Path
from types import TracebackType

from sistap.commands.annotate.blocks import LogBlocks
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.folding import DAMAGE
from sistap.dissected.episodes.lines import lines
from sistap.dissected.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.dissected.explain import advice
from sistap.dissected.explain.fields import Fields, Said, said
from sistap.dissected.explain.running import Running
from sistap.dissected.packets.dissection import packet_of
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.records.record import Record

_FOREIGN = "It may be another protocol: USIP, USS and others begin with 02, too. Or it was logged at another rate."
_ANSWER_S = 30  # longest time that a running tshark takes for an answer


class WholeCapture:
    """Explains the records of a complete capture file, without its event."""

    def __init__(self, tshark: Tshark, fields: Fields, capture: Path, thresholds: Thresholds = THRESHOLDS) -> None:
        """Explain it by these fields, which are those of a Packet, too."""
        self._fields = fields
        self._engine = Engine(thresholds=thresholds)
        self._times_s: list[float] = []  # of the first and the last packet
        self.has_telegram = True  # without a right one, no fault is anybody's
        self._lines = tshark.lines(["-r", str(capture), "-2", *self._fields.arguments])
        next(self._lines, None)

    def get(self) -> Said:
        """Return the explanation of the next record."""
        try:
            columns = self._fields.columns(next(self._lines))
        except StopIteration:
            raise TsharkError("tshark has said less than the log holds: is there room for its files?") from None
        packet = packet_of(columns)
        self._engine.add(packet)
        self._times_s = [*self._times_s[:1], packet.epoch_s]
        return said(columns) if self.has_telegram else said(columns)._replace(advice="")

    def answer(self) -> list[str]:
        """Return the five lines that say what happened, if something has to be looked at and the log has times.

        A log is short: in it, one damaged telegram has to be looked at, too. That it is no log of SIS needs no times.
        """
        episodes = self._engine.finish()
        foreign = [one.text for one in episodes if one.kind == "foreign"]
        if foreign:
            return [f"{text} {_FOREIGN}" for text in foreign]
        is_news = any(one.severity >= Severity.WARNING or one.kind in DAMAGE for one in episodes)
        if not self._times_s or not self._times_s[0] or not is_news or not self.has_telegram:
            return []
        return [line.text for line in lines(episodes, self._times_s[0], self._times_s[-1])]


class LiveCapture:
    """Explains records as they come, in one pass. Use it in a `with`."""

    def __init__(self, tshark: Tshark, log: str) -> None:
        self._fields = Fields(tshark, tuple(advice.FIELDS))
        self._blocks = LogBlocks(log)
        self._process = Running(tshark, self._fields.arguments)
        self._first = True
        self._has_telegram = False  # until then, no fault is anybody's

    def put(self, record: Record) -> None:
        """Send a record to tshark."""
        self._has_telegram |= record.is_good_frame
        self._process.put(self._blocks.packet(record))

    def get(self) -> Said:
        """Wait for the explanation of the next record."""
        if self._first:
            self._first = False
            self._answer()  # skip the answer to the event
        said = self._fields.said(self._answer())
        return said if self._has_telegram else said._replace(advice="")

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

    def __enter__(self) -> LiveCapture:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self._process.kill()
        self._process.end()
        self._process.wait()
