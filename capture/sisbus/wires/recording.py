# SPDX-License-Identifier: GPL-2.0-or-later
"""The bus directly in a capture file, as a tap would have written it: same assembler and writer, no waiting."""

from __future__ import annotations

import random
from collections.abc import Callable

import sistap
from sisbus.playing.characters import TIMING, Played, reads, received, uncertainty
from sisbus.scenarios.scenario import Scenario
from sistap.tap.files.output import Output
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.assembler import Assembler
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Framing, Record, event
from sistap.tap.sis.initialization import Follow, RateChange

_START_NS = 946_684_800_000_000_000  # 2000-01-01: obviously not today, and the same seed makes the same file
_LINE = 0  # of SIS: one shared bus


class Recording:
    """A tap that follows changes of the rate, as `sistap capture --follow-baud` does, in simulated time."""

    name = ""
    deserted = False

    def __init__(  # noqa: PLR0913 - what is recorded, how, and where to
        self,
        output: Output,
        scenario: Scenario,
        name: str,
        seed: int,
        settings: LineSettings | None = None,
        most: int = 1,
        heard: Callable[[Record], object] = lambda record: None,
    ) -> None:
        """Begin the file; reads have `most` characters, `heard` gets each record, too. May raise OutputError."""
        settings, lines, cut = settings or scenario.settings, scenario.lines, scenario.cut
        start_ns = _START_NS if scenario.begin_ns is None else scenario.begin_ns
        text = f"scenario {name}, seed {seed}"
        self.counters = Counters()
        self._heard = heard
        self._start_ns = start_ns
        self._output = output
        self._most = most
        self._noise = random.Random(f"{seed} tap")
        self._assembler = Assembler(cut)
        for line in lines:
            self._assembler.add_line(line, settings, start_ns)
        self._follow = Follow(settings.baud)
        self._now_ns = start_ns
        interface = Interface(LINKTYPE_WIRESHARK_UPPER_PDU, text, f"{settings}; {TIMING}", settings.baud, "virtual bus")
        self.interfaces = dict.fromkeys(lines, interface)
        self._writer = PcapngWriter(output, self.interfaces, self.counters, system="")
        said = f"sistap {sistap.__version__}; {text} (virtual bus); {settings}; {TIMING}{cut.said}"
        self.started = [event(start_ns, line, settings, Event.CAPTURE_STARTED, said) for line in lines]
        self._writer.begin(*self.started)

    @property
    def written(self) -> str:
        """Say what was written, where, and how to open it."""
        return f"{self.counters} {self._output.written}"

    def wait_for_listener(self) -> None:
        """Do nothing: the file listens already."""

    def deliver(self, played: Played) -> list[str]:
        """Record all characters. May raise OutputError."""
        for read in reads(played.characters, self._most, played.settings.character_ns):
            time_ns = self._start_ns + read[-1].time_ns
            if played.line == _LINE:
                self._change(self._follow.due(time_ns - uncertainty(read)))
            settings = self._assembler.settings(played.line)
            heard = [received(character, played.settings, settings, self._noise) for character in read]
            values, flags = bytes(value for value, _ in heard), bytes(flag for _, flag in heard)
            self._take(Read(played.line, time_ns, values, flags, uncertainty(read), settings))
        return []

    def close(self) -> None:
        """End the file. May raise OutputError."""
        self._assembler.flush(self._assembler.lines, self._now_ns)
        self._write_due()
        self._writer.end(self._now_ns)
        self._output.close()

    def _take(self, read: Read) -> None:
        self._now_ns = read.time_ns
        self.counters.add_read(read)
        completed = self._assembler.take(read, read.time_ns, "")
        self._write_due()
        for record in completed:
            if record.is_good_frame and record.framing == Framing.SIS:
                self._change(self._follow.take(record.data, record.end_ns))

    def _change(self, change: RateChange | None) -> None:
        """Listen at another rate from the next character on."""
        settings = self._assembler.settings(_LINE)
        if change and change.baud != settings.baud:
            self._assembler.change(_LINE, settings._replace(baud=change.baud), change.why, self._now_ns)
            self._write_due()

    def _write_due(self) -> None:
        for record in self._assembler.due(self._now_ns):
            self._write(record)

    def _write(self, record: Record) -> None:
        self.counters.add_record(record, written=self._writer.write(record))
        self._heard(record)
