# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap as a library: records of a port, of a file or of the virtual bus, and a capture to write them to.

    import sistap

    with sistap.Tap("/dev/ttyUSB0", baud=19200) as tap, sistap.Writer("night.pcapng") as capture:
        for record in tap:
            capture.write(record)

A `Record` is a telegram, other characters, or an event of the tap. `Record.characters()` has the time and the flags of
each character. Times are ns since 1970. Nothing is ever written to a port.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Self

from sistap.annotate import sources
from sistap.annotate.annotating import Passage
from sistap.annotate.sources import SourceError
from sistap.bus.scenarios import scenario
from sistap.bus.scenarios.scenario import Playing
from sistap.bus.wires.recording import Recording
from sistap.capture.rate import AUTO, FORMATS
from sistap.capture.session import Capture
from sistap.capture.tap import Conditions
from sistap.captures import reading
from sistap.captures.reading import NotCaptured
from sistap.captures.stream import Stream
from sistap.files.output import Output, OutputError, OutputRefused
from sistap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, SECTION_HEADER, Interface
from sistap.files.writer import PcapngWriter
from sistap.line.reader import PortError, PortLost, open_reader
from sistap.line.settings import Flag, LineSettings
from sistap.records.counters import Counters
from sistap.records.cut import SIS, Cut
from sistap.records.record import Character, Event, Framing, Record, Type
from sistap.sis.rates import RATES

__all__ = [
    "Character",
    "Event",
    "Flag",
    "Framing",
    "LineSettings",
    "NotCaptured",
    "OutputError",
    "OutputRefused",
    "PortError",
    "PortLost",
    "Record",
    "SourceError",
    "Tap",
    "Type",
    "Writer",
    "play",
    "read",
]

_LOG = logging.getLogger("sistap")
_PCAPNG = SECTION_HEADER.to_bytes(4)  # it reads the same from both ends


class _Collector:
    """A sink that keeps records until they are taken."""

    def __init__(self) -> None:
        self.records: deque[Record] = deque()

    def begin(self, *started: Record) -> None:
        self.records.extend(started)

    def write(self, record: Record) -> bool:
        self.records.append(record)
        return True

    def look(self, time_ns: int) -> None:
        """Do nothing: there are no files."""

    def end(self, time_ns: int) -> None:
        """Do nothing: there are no files."""


class _Messages:
    """Messages for people go to the logger `sistap`; the reason of an end is kept."""

    shows_progress = False
    alarms = ""

    def say(self, text: str) -> None:
        _LOG.info(text)

    def alarm(self, text: str) -> None:
        self.alarms = text

    def progress(self, text: str) -> None:
        """Show nothing."""


class Tap:
    """One port, or the two of a full-duplex line. Iterate over it for records, as they come."""

    def __init__(  # noqa: PLR0913 - as `sistap capture`
        self,
        *ports: str,
        baud: int | str = RATES[0],
        format: str = "8E1",  # noqa: A002 - the word of the command
        framing: str = "sis",
        limits: str = "",
        duration_s: float | None = None,
    ) -> None:
        """Open one or two ports: a device, "bus://HOST:PORT", or "sigrok:DRIVER". PortError says what to do.

        `baud` may be "auto"; `framing` is sis, 3964r or silence:MS; `limits` as for --limits. ValueError for others.
        """
        if len(ports) not in {1, 2}:
            raise ValueError(f"a tap has one port, or the two of a full-duplex line, not {len(ports)}")
        settings = LineSettings.parse(RATES[0] if baud == AUTO else int(baud), format)
        numbers = [0] if len(ports) == 1 else range(1, len(ports) + 1)
        conditions = Conditions(
            Cut.parse(framing), duration_s=duration_s, formats=FORMATS if baud == AUTO else (), limits=limits
        )
        self._opened = ExitStack()
        with ExitStack() as opened:
            readers = []
            for line, port in zip(numbers, ports, strict=True):
                readers.append(open_reader(port, settings, line))
                opened.callback(readers[-1].close)
            self._opened = opened.pop_all()
        self._sink, self._messages = _Collector(), _Messages()
        self._capture = Capture(readers, self._sink, Stream(), Counters(), self._messages, conditions)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the ports."""
        self._opened.close()

    def __iter__(self) -> Iterator[Record]:
        """Yield records until the time is over, or the ports are gone: then PortLost."""
        capture, records = self._capture, self._sink.records
        capture.begin()
        with capture.reading():
            while not capture.is_over:
                capture.turn()
                while records:
                    yield records.popleft()
        capture.end()
        yield from records
        if self._messages.alarms:
            raise PortLost(self._messages.alarms)


class Writer:
    """A capture that Wireshark opens."""

    def __init__(self, path: str | Path, *, description: str = "sistap", force: bool = False) -> None:
        """Begin a file. OutputRefused if it cannot be written, or has data and `force` is not set."""
        try:
            self._output = Output(str(path), force=force)
        except OutputRefused as refused:
            raise OutputRefused(refused.what, "; choose another path, or overwrite it with force=True") from None
        self._counters = Counters()
        interface = Interface(LINKTYPE_WIRESHARK_UPPER_PDU, description)
        self._writer = PcapngWriter(self._output, {0: interface}, self._counters)
        self._writer.begin()
        self._end_ns = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        self.close()

    def write(self, record: Record) -> None:
        """Write a record at once: a file that ends here is whole. OutputError if the disk takes no more."""
        self._writer.write(record)
        self._counters.add_record(record)
        self._end_ns = record.end_ns

    def close(self) -> None:
        """End the file."""
        self._writer.end(self._end_ns)
        self._output.close()


def read(path: str | Path) -> Iterator[Record]:
    """Yield the records of a capture, or the telegrams of a log of another program.

    NotCaptured or SourceError says what is wrong with the file, OSError that it cannot be read.
    """
    with Path(path).open("rb") as file:
        is_capture = file.read(len(_PCAPNG)) == _PCAPNG
    if is_capture:
        yield from reading.records(Path(path))
        return
    source = sources.look(str(path), SIS)
    passage = Passage(source.reader)
    for batch in source.lines(SIS, lambda _: None):
        for line in batch:
            yield from (cut.record for cut in passage.feed(line).cuts)
    yield from (cut.record for cut in passage.end())


class _Played(Recording):
    """What a tap of the virtual bus writes, as records."""

    records: deque[Record]

    def _write(self, record: Record) -> None:
        self.records.append(record)


def play(name: str, *, seed: int = 1, duration_s: float) -> Iterator[Record]:
    """Yield what a tap records of a scenario (`sistap bus --list`, or FILE.toml). ValueError for an unknown one."""
    played = scenario.load(name)
    tap = _Played(Stream(), played.settings, f"scenario {name}, seed {seed}", seed, 1, played.cut, played.lines)
    tap.records = deque(tap.started)
    for sent in played.play(played.settings, Playing(seed, end_ns=duration_s * 1e9)):
        tap.deliver(sent)
        while tap.records:
            yield tap.records.popleft()
    tap.close()
    yield from tap.records
