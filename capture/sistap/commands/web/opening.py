# SPDX-License-Identifier: GPL-2.0-or-later
"""A log as a capture, and where in its lines the telegrams stand: the page shows both side by side."""

from __future__ import annotations

import json
from array import array
from collections.abc import Callable, Iterable
from pathlib import Path

from sistap.commands.annotate import annotating, sources
from sistap.commands.annotate.annotating import Passage
from sistap.commands.annotate.choosing import AnyReader
from sistap.commands.annotate.pattern import PatternReader
from sistap.commands.annotate.raw import CONTROLS
from sistap.commands.annotate.reading import LogReader
from sistap.commands.annotate.sources import LogSource
from sistap.commands.annotate.spool import LogEntry, Spool
from sistap.commands.annotate.textlog import UTF_16
from sistap.commands.annotate.troubles import Troubles
from sistap.commands.imports.formats import known
from sistap.commands.parameters import backup
from sistap.tap.line.settings import in_ms
from sistap.tap.records.cut import SIS
from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.exits import Refusal

LINES, PLACES = ".lines", ".places"  # what the names of the files end with
_NOTHING_PASTED = "There are no bytes in this text: paste them in hexadecimal, such as 02 D9 00 00 00 12 10 03"
_ENOUGH = 1 << 16  # bytes of a file that tell whether it is text
_CONTROLS_OF_TEXT = 50  # at most one character of so many


class OpenedLog:
    """What is said of a log that was read."""

    def __init__(self, said: list[str], unread: list[str]) -> None:
        self.said = said  # of the whole log
        self.unread = unread  # lines that could not be read, and why


def is_import(name: str) -> bool:
    """Tell whether `sistap import` is for this file: of an analyser, or text of usbmon. May raise Refusal."""
    return known(Path(name)) is not None


def open_log(
    name: str, capture: str, pattern: str, progress: Callable[[float], None], *, is_pasted: bool = False
) -> str:
    """Write a log as a capture; its packets are an event, then the telegrams. Return an OpenedLog as JSON. Refusal.

    Beside the capture are LINES, in UTF-8, and PLACES: of the bytes of each packet without the event, four numbers of
    32 bits, which are packet and line from 0, first column, end.

    What `is_pasted` needs no right telegram, and may be a few bytes.
    """
    log = Path(name)
    _refuse_backup(log)
    readers: list[LogReader | None] = [PatternReader(pattern) if pattern else None]
    if is_pasted:
        readers.append(AnyReader())  # it reads a few bytes, too
    for reader in readers:
        found, passage = _read(log, capture, reader, progress, is_pasted=is_pasted)
        if passage.telegrams or (is_pasted and passage.bytes and not passage.has_ascii):
            break
    else:
        raise Refusal(_NOTHING_PASTED if is_pasted and not passage.has_ascii else _nothing(log, passage))
    if not passage.telegrams:
        found.said.append(f"There is no right telegram of SIS in {_count(passage)}: what is wrong stands beside each")
    return json.dumps(found.__dict__)


def _read(
    log: Path, capture: str, reader: LogReader | None, progress: Callable[[float], None], *, is_pasted: bool
) -> tuple[OpenedLog, Passage]:
    unread: list[str] = []
    troubles = Troubles(unread.append)
    try:
        source = sources.look(str(log), SIS, reader)
        passage = Passage(source.reader, troubles.add, takes_cut=is_pasted)
        with Spool() as spool, Path(capture).open("wb") as file:
            batches = source.lines(SIS, lambda part: progress(part / 2))
            annotating.record(batches, passage, log.name, file.write, spool)
            troubles.end()
            _write_lines(capture, spool.batches(lambda part: progress(0.5 + part / 2)))
    except ValueError as error:
        raise Refusal(str(error)) from None
    return OpenedLog(_remarks(source, passage), unread), passage


def _write_lines(capture: str, batches: Iterable[list[LogEntry]]) -> None:
    """Write the lines, and where in them the bytes of each packet stand. A log may have millions."""
    packet = 0
    with open(f"{capture}{LINES}", "wb") as lines, open(f"{capture}{PLACES}", "wb") as places:
        for batch in batches:
            numbers = array("I")
            for _, _, complete in batch:
                for parts in complete:
                    for piece, first, end in parts:
                        spans = piece.spans[first:end]
                        numbers.extend((packet, piece.line.number - 1, spans[0][0], spans[-1][1]))
                    packet += 1
            lines.write("".join(f"{line.text}\n" for line, _, _ in batch if line).encode("utf-8", "replace"))
            places.write(numbers.tobytes())


def _count(passage: Passage) -> str:
    return f"{passage.bytes} byte{'' if passage.bytes == 1 else 's'}"


def _refuse_backup(log: Path) -> None:
    with log.open("rb") as file:
        if file.read(len(backup.MARK)) == backup.MARK.encode():
            raise Refusal(
                f"{log.name} is a backup of the parameters of a drive, not what was on a line: on a computer with "
                f"sistap, `sistap parameters CAPTURE --against {shell_word(log.name)}` compares a capture with it"
            )


def _is_binary(log: Path) -> bool:
    with log.open("rb") as file:
        beginning = file.read(_ENOUGH)
    controls = len(beginning) - len(beginning.translate(None, CONTROLS))
    return controls > len(beginning) / _CONTROLS_OF_TEXT and not beginning.startswith(UTF_16)


def _remarks(source: LogSource, passage: Passage) -> list[str]:
    if source.is_raw:
        return ["It is no text: its bytes are read as they are, without times and directions."]
    remarks = [f"bytes: {source.reader.notation}"] if source.reader.notation else []
    if passage.uncertainty_ns:
        remarks.append(
            f"Times are those of the log's lines, uncertain by up to {in_ms(passage.uncertainty_ns)}. An interval in "
            f"the list is the longest that is possible"
        )
    return remarks


def _nothing(log: Path, passage: Passage) -> str:
    """Say why nothing can be shown."""
    if _is_binary(log):
        return (
            f"{log.name} is no capture, no text, and no recording that sistap knows: "
            f"open a capture, or a log that an editor can show"
        )
    if passage.has_ascii:
        return (
            f"{log.name} has the ASCII protocol of drives: on a computer with sistap, "
            f"`sistap annotate --framing ascii {shell_word(log.name)}` explains it"
        )
    if passage.bytes:
        return f"{log.name} has {_count(passage)}, but no telegram of SIS: it may be the log of another protocol"
    return f"{log.name} has no bytes in hexadecimal: make the other program log in hexadecimal"
