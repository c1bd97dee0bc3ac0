# SPDX-License-Identifier: GPL-2.0-or-later
"""A log as a capture, and where in its lines the telegrams stand: the page shows both side by side."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path

from sistap.annotate import annotating, sources
from sistap.annotate.annotating import Passage
from sistap.annotate.cutting import Part
from sistap.annotate.pattern import PatternReader, TooSlow
from sistap.annotate.sources import SourceError
from sistap.annotate.spool import Spool
from sistap.annotate.troubles import Troubles
from sistap.imports.formats import known
from sistap.records.cut import SIS
from sistap.terminal.exits import UsageError


class Log:
    """A log that was read."""

    def __init__(self, said: list[str]) -> None:
        self.lines: list[str] = []
        self.places: list[list[tuple[int, int, int]]] = []  # of each packet's bytes: line from 0, first column, end
        self.said = said

    def add(self, parts: Iterable[Part]) -> None:
        """Note where the bytes of a packet stand."""
        places = []
        for piece, first, end in parts:
            spans = piece.spans[first:end]
            places.append((piece.line.number - 1, spans[0][0], spans[-1][1]))
        self.places.append(places)


def is_import(name: str) -> bool:
    """Tell whether `sistap import` is for this file: of an analyser, or text of usbmon. May raise UsageError."""
    return known(Path(name)) is not None


def open_log(name: str, capture: str, pattern: str, progress: Callable[[float], None]) -> str:
    """Write a log as a capture; its packets are an event, then the telegrams. Return a Log as JSON. May raise
    UsageError.
    """
    log = Path(name)
    said: list[str] = []
    troubles = Troubles(said.append)
    try:
        source = sources.look(name, SIS, PatternReader(pattern) if pattern else None)
        passage = Passage(source.reader, troubles.add)
        with Spool() as spool, Path(capture).open("wb") as file:
            batches = source.lines(SIS, lambda part: progress(part / 2))
            annotating.record(batches, passage, log.name, file.write, spool)
            if not passage.telegrams:
                raise UsageError(_nothing(log, passage))
            troubles.end()
            if source.reader.notation:
                said.append(f"bytes: {source.reader.notation}")
            found = Log(said)
            for batch in spool.batches(lambda part: progress(0.5 + part / 2)):
                for line, _, complete in batch:
                    if line:
                        found.lines.append(line.text)
                    for parts in complete:
                        found.add(parts)
    except (SourceError, TooSlow, ValueError) as error:
        raise UsageError(str(error)) from None
    return json.dumps(found.__dict__)


def _nothing(log: Path, passage: Passage) -> str:
    """Say why nothing can be shown."""
    if passage.has_ascii:
        return f"{log.name} has the ASCII protocol of drives: `sistap annotate --framing ascii` explains it"
    if passage.bytes:
        return f"{log.name} has {passage.bytes} bytes, but no telegram of SIS"
    return f"{log.name} has no bytes in hexadecimal: make the other program log in hexadecimal"
