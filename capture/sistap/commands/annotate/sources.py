# SPDX-License-Identifier: GPL-2.0-or-later
"""Where a log comes from: a file, which can be read again, or a pipe that another program still writes."""

from __future__ import annotations

import os
import queue
import stat
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from sistap.commands.annotate.choosing import LONGEST, AnyReader
from sistap.commands.annotate.raw import RawCutter, RawReader, is_raw
from sistap.commands.annotate.reading import LogReader
from sistap.commands.annotate.session import SessionReader, is_session
from sistap.commands.annotate.textlog import UTF_16, Cutter, LineCutter, LogLine, lines
from sistap.tap.common.packed import unpack
from sistap.tap.common.usbmon import is_usbmon
from sistap.tap.files.pcapng import FIRST_BYTES
from sistap.tap.records.cut import ASCII, Cut
from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.exits import Refusal, why

_PIECE = 1 << 18
_AHEAD = 16  # pieces of a pipe that may wait: its writer can be faster than they are explained
_IDLE_S = 0.2
_NULS = 10  # one byte in this many may be 0: some programs write what they received


class SourceError(Refusal):
    """The log cannot be read; the text is the line to show."""


class LogSource(NamedTuple):
    """A log."""

    log: str
    reader: LogReader  # of its lines
    is_pipe: bool = True

    @property
    def is_raw(self) -> bool:
        """Whether the file has the bytes themselves."""
        return isinstance(self.reader, RawReader)

    def lines(self, framing: Cut, progress: Callable[[float], None]) -> Iterator[list[LogLine]]:
        """Yield its lines in batches; call `progress` with the part of a file that has been read, 0 to 1."""
        if self.is_pipe:
            return from_pipe(self.log)
        return _from_file(self.log, RawCutter(framing) if self.is_raw else LineCutter(), progress)


def look(log: str, framing: Cut, reader: LogReader | None = None) -> LogSource:
    """Look how a log is to be read, unless a `reader` is given. SourceError if it cannot be read."""
    live = reader or (SessionReader() if framing == ASCII else AnyReader(framing=framing))
    if log == "-":
        return LogSource(log, live)
    try:
        mode = Path(log).stat().st_mode
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            return LogSource(log, live)  # opening it would wait for a writer
        if packed := unpack(Path(log)):
            raise SourceError(packed)
        with open(log, "rb") as file:
            beginning = file.read(LONGEST)
    except OSError as error:
        raise SourceError(f"cannot read {log}: {why(error)}; name a log, or - for standard input") from None
    if beginning.startswith(FIRST_BYTES):
        raise SourceError(f"{log} is a capture, not a log: `sistap log {log}` explains it")
    if not reader and not beginning.startswith(UTF_16) and is_raw(beginning[:_PIECE], framing):
        return LogSource(log, RawReader(), is_pipe=False)
    _check_text(log, beginning)
    if not reader and framing == ASCII and is_session(beginning):
        reader = SessionReader()
    return LogSource(log, reader or AnyReader([*lines([beginning])], framing), is_pipe=False)


def _check_text(log: str, beginning: bytes) -> None:
    """Raise SourceError for a file that no editor would show, or whose numbers are not all bytes."""
    _check_usb(log, beginning.decode(errors="replace"))
    if beginning.count(0) > len(beginning) / _NULS and not beginning.startswith(UTF_16):
        raise SourceError(
            f"{log} is no text, and its bytes are no telegrams: name a log that an editor can show, or a raw log"
        )


def _check_usb(log: str, text: str) -> None:
    """Raise SourceError for the text of usbmon: tags and lengths are no bytes of the bus."""
    if is_usbmon(text):
        name = "FILE" if log == "-" else shell_word(log)
        raise SourceError(f"this is a text of usbmon, not a log: read it with `sistap import {name} -w x.pcapng`")


def _from_file(log: str, lines: Cutter, progress: Callable[[float], None]) -> Iterator[list[LogLine]]:
    with open(log, "rb") as file:
        size = os.fstat(file.fileno()).st_size or 1
        while piece := file.read(_PIECE):
            if batch := list(lines.feed(piece)):
                yield batch
            progress(min(file.tell() / size, 1))
    if rest := list(lines.end()):
        yield rest


def from_pipe(log: str) -> Iterator[list[LogLine]]:
    """Yield the lines of a pipe as they come; an empty list if nothing came for a moment."""
    pieces: queue.Queue[bytes] = queue.Queue(_AHEAD)
    descriptor = 0 if log == "-" else os.open(log, os.O_RDONLY | getattr(os, "O_BINARY", 0))
    # A thread, because Windows cannot tell whether a pipe has something to read.
    threading.Thread(target=_read, args=(descriptor, pieces), daemon=True).start()
    lines = LineCutter()
    waits = None
    while True:
        try:
            piece = pieces.get(timeout=waits)
        except queue.Empty:
            waits = None
            yield []
            continue
        if not piece:
            break
        waits = _IDLE_S
        if batch := list(lines.feed(piece)):
            _check_usb(log, "\n".join(line.text for line in batch))
            yield batch
    if rest := list(lines.end()):
        yield rest


def _read(descriptor: int, pieces: queue.Queue[bytes]) -> None:
    try:
        while piece := os.read(descriptor, _PIECE):
            pieces.put(piece)
    except OSError:
        pass  # the log ends here
    pieces.put(b"")
