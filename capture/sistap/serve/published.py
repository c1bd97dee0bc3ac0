# SPDX-License-Identifier: GPL-2.0-or-later
"""A reader that publishes what it reads, and the end of the capture that reads it."""

from __future__ import annotations

from sistap.line.clocks import monotonic_ns
from sistap.line.reader import Reader
from sistap.line.settings import Happening, LineSettings, Notice, Read
from sistap.records.record import Event, Record
from sistap.serve.listeners import Listeners

_MOST_NS = 50_000_000  # longest time that listeners wait while characters come without a pause

# Events at the tap that listeners cannot detect themselves.
_HAPPENINGS = {Event.MARKER: Happening.MARKER, Event.ADAPTER_LOST: Happening.GONE}


class PublishedReader:
    """A reader that reads as the reader behind it does. Listeners get their turn when nothing waits to be read."""

    def __init__(self, reader: Reader, listeners: Listeners) -> None:
        self._reader = reader
        self._listeners = listeners
        self._attended_ns = 0
        self.name = reader.name
        self.adapter = reader.adapter
        self.timing = reader.timing
        self.notes = reader.notes
        self.settings = reader.settings
        self.line = reader.line

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""
        asked_ns = monotonic_ns()
        read = self._published(0)
        if read is None or asked_ns - self._attended_ns >= _MOST_NS:
            self._attended_ns = asked_ns
            self._listeners.attend(asked_ns)
        return read or self._published(timeout_s)

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. May raise PortError."""
        self._reader.change(settings)
        self.settings = self._reader.settings

    def close(self) -> None:
        """Release the port."""
        self._reader.close()

    def _published(self, timeout_s: float) -> Read | None:
        read = self._reader.read(timeout_s)
        if read:
            self._listeners.publish(read)
        return read


class EventSink:
    """A sink that sends the events among the records to the listeners. They make all other records themselves."""

    def __init__(self, listeners: Listeners) -> None:
        self._listeners = listeners

    def begin(self, *started: Record) -> None:
        """Do nothing: the first message has said it."""

    def write(self, record: Record) -> bool:
        """Send an event; ignore other records."""
        if (happening := _HAPPENINGS.get(record.event)) is not None:
            self._listeners.notice(Notice(happening, record.data.decode()))
        return False

    def look(self, time_ns: int) -> None:
        """Do nothing: there is no file."""

    def end(self, time_ns: int) -> None:
        """Do nothing: no file to close."""
