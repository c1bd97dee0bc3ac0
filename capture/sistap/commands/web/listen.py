# SPDX-License-Identifier: GPL-2.0-or-later
"""Listens for the page, which reads ports with Web Serial: a capture as `sistap capture` makes it, turn by turn."""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Sequence
from typing import Any

from sistap.commands.imports import ftdi
from sistap.commands.web.window import Window
from sistap.dissected.captures.stream import Stream
from sistap.tap.capture.rate import AUTO, FORMATS
from sistap.tap.capture.session import Capture
from sistap.tap.capture.tap import Conditions
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.ports import Adapter
from sistap.tap.line.reader import PortLost, latency
from sistap.tap.line.reader.latency import Known
from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Record

# The browser does not say which character of a read had an error, and nothing but the page itself can be measured. So
# an error is "somewhere in this read", and the bound of the times is what the page was late, what the browser may add,
# and the latency timer of an FTDI adapter as by default.

BROWSER_NS = 5_000_000  # what the browser may add on the way from the port to the page, which nothing measures
FTDI_MS = 16  # latency timer of an adapter that no driver has been told another
_UNKNOWN = "{}: the delay of this adapter is not known, and not in the uncertainty"
_SLEEP_NS = 8_000_000  # the page is awake at least this often, or it was late
_MS = 1_000_000


class WebReader:
    """A port in the browser: what the page has read of it, and the settings that it shall have."""

    def __init__(self, line: int, name: str, vendor: int, settings: LineSettings, late_ns: int) -> None:
        """`late_ns` is how late the page has seen events so far."""
        self.line = line
        self.name = name
        self.settings = settings
        self._behind = Adapter(name, "", FTDI_MS) if vendor in ftdi.VENDORS else Adapter(name)
        self.adapter = str(self._behind)
        _, bound = self._bound(late_ns)
        self.timing = f"{bound.how}; times of the browser, in steps of 0.1 ms"
        self.notes: tuple[str, ...] = (_UNKNOWN.format(name),) if bound.notes else ()
        self._reads: deque[Read] = deque()
        self._lost = ""

    def _bound(self, late_ns: int) -> tuple[int, latency.Bound]:
        """Return how late a character can be seen in ns, and how that comes about."""
        known = Known(late_ns + BROWSER_NS, "measured in the page, with 5 ms for the browser", [])
        bound = latency.bound(known, self.name, self._behind, self.settings)
        return bound.ns(known.machine_ns), bound

    def hear(self, chunk: dict[str, Any]) -> None:
        """Take what the page has read: see `Listening.hear`."""
        late_ns, _ = self._bound(int(chunk["late_ms"] * _MS))
        data = bytes(chunk["data"])
        settings = LineSettings.parse(chunk["baud"], chunk["format"])
        unseen_ns = int(chunk["unseen_ms"] * _MS)
        uncertainty_ns = latency.uncertainty_ns(
            late_ns, settings, len(data), unseen_ns, in_time=unseen_ns <= _SLEEP_NS, sleep_ns=_SLEEP_NS
        )
        flags = bytes([Flag.UNLOCATED_ERROR if chunk["error"] else 0]) * len(data)
        if chunk["lost"] and data:
            flags = bytes([flags[0] | Flag.LOST_BEFORE]) + flags[1:]
        notices = (chunk["note"],) if chunk["note"] else ()
        time_ns = int(chunk["time_ms"] * 1000) * 1000
        self._reads.append(Read(self.line, time_ns, data, flags, uncertainty_ns, settings, notices))

    def lose(self, text: str) -> None:
        """Note that the port is gone."""
        self._lost = text

    def read(self, timeout_s: float) -> Read | None:
        """Return what the page has read, at once. May raise PortLost."""
        if self._reads:
            return self._reads.popleft()
        if self._lost:
            raise PortLost(self._lost, self.line)
        return None

    def change(self, settings: LineSettings) -> None:
        """Want other settings; the page opens the port anew."""
        self.settings = settings

    def close(self) -> None:
        """Do nothing: the page closes the port."""


class _Both:
    """The ports of a tap as one."""

    def __init__(self, readers: Sequence[WebReader]) -> None:
        self._readers = list(readers)

    def read(self, timeout_s: float) -> Read | None:
        """Return the next read of any port. May raise PortLost, once for each."""
        for reader in list(self._readers):
            try:
                if read := reader.read(timeout_s):
                    return read
            except PortLost:
                self._readers.remove(reader)
                raise
        return None


class _PageSink:
    """A capture whose blocks the page takes away, and the last records."""

    def __init__(self, stream: Stream, interfaces: dict[int, Interface], counters: Counters, system: str) -> None:
        self._writer = PcapngWriter(stream, interfaces, counters, system)
        self._interfaces = interfaces
        self.window = Window(interfaces, ())
        self.look, self.end = self._writer.look, self._writer.end

    def begin(self, *started: Record) -> None:
        """Begin, with an event for each port."""
        self._writer.begin(*started)
        self.window = Window(self._interfaces, started)

    def write(self, record: Record) -> bool:
        """Take a record."""
        self.window.add(record)
        return self._writer.write(record)


class _Console:
    """What is said, for the page to show."""

    def __init__(self) -> None:
        self.said = ""

    def say(self, text: str) -> None:
        """Keep the last line."""
        self.said = text

    alarm = say

    def progress(self, text: str) -> None:
        """Do nothing: the page asks for the counters."""


class Listening:
    """A capture at one port, or at the two of a full-duplex line."""

    def __init__(self, asked: str) -> None:
        """`asked` is JSON: ports [{name, vendor}], baud ("auto" looks for it), format, late_ms, system."""
        wanted = json.loads(asked)
        is_auto = wanted["baud"] == AUTO
        readers = _of_ports(wanted, is_auto=is_auto)
        self._readers = {reader.line: reader for reader in readers}
        self._counters, self._stream, self._console = Counters(), Stream(), _Console()
        interfaces = {reader.line: _interface(reader, is_auto=is_auto) for reader in readers}
        self._sink = _PageSink(self._stream, interfaces, self._counters, wanted["system"])
        formats = FORMATS if is_auto else ()
        conditions = Conditions(formats=formats, follow=True)
        told = self._stream, self._counters, self._console, conditions
        self._capture = Capture(readers, self._sink, *told, source=_Both(readers))  # no threads can be had
        self._capture.begin()
        self._capture.announce()

    def step(self, heard: str) -> bytes:
        """Go on with what the page has read; return the blocks that this adds. `heard` is JSON: a list of chunks.

        A chunk is {line, time_ms, data, baud, format, unseen_ms, late_ms, error, lost, note}, or {line, gone}.
        """
        for chunk in json.loads(heard):
            reader = self._readers[chunk["line"]]
            if "gone" in chunk:
                reader.lose(chunk["gone"])
            else:
                reader.hear(chunk)
        while self._capture.turn():
            pass
        return self._stream.take()

    @property
    def wanted(self) -> str:
        """Return the rate and format that the ports shall have, as JSON."""
        settings = next(iter(self._readers.values())).settings
        return json.dumps({"baud": settings.baud, "format": settings.format})

    @property
    def said(self) -> str:
        """Return the counters, and the last message."""
        return " - ".join(filter(None, [str(self._counters), self._console.said]))

    @property
    def is_over(self) -> bool:
        """Tell whether all ports are gone."""
        return self._capture.is_over

    def window(self) -> bytes:
        """Return the last records as a capture."""
        return self._sink.window.capture()

    @property
    def left_out(self) -> int:
        """Return how many records the window no longer has."""
        return self._sink.window.left_out

    def end(self) -> bytes:
        """End the capture; return its last blocks."""
        self._capture.end()
        return self._stream.take()


def _of_ports(wanted: dict[str, Any], *, is_auto: bool) -> list[WebReader]:
    settings = LineSettings.parse(9600 if is_auto else int(wanted["baud"]), wanted["format"])
    late_ns = int(wanted["late_ms"] * _MS)
    ports = wanted["ports"]
    lines = [0] if len(ports) == 1 else [1, 2]
    return [
        WebReader(line, port["name"], port["vendor"], settings, late_ns)
        for line, port in zip(lines, ports, strict=True)
    ]


def _interface(reader: WebReader, *, is_auto: bool) -> Interface:
    settings = "rate by --baud auto" if is_auto else str(reader.settings)
    baud = 0 if is_auto else reader.settings.baud
    return Interface(LINKTYPE_WIRESHARK_UPPER_PDU, reader.name, f"{settings}; {reader.timing}", baud, reader.adapter)
