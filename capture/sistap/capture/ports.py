# SPDX-License-Identifier: GPL-2.0-or-later
"""The ports of a capture: opened at its start, and again when they come back, if the capture waits for them."""

from __future__ import annotations

import time
from collections.abc import Callable

from sistap.capture.options import CaptureOptions
from sistap.line.reader import Distant, PortError, Reader, open_reader
from sistap.line.settings import LineSettings

PAUSE_S = 1.0


class Ports:
    """All open ports."""

    def __init__(self, options: CaptureOptions) -> None:
        self._options = options
        self._open: list[Reader] = []

    def open(self, settings: LineSettings, say: Callable[[str], None]) -> list[Reader]:
        """Open all ports. May raise PortError; a capture that waits for ports ends only by Stopped."""
        for line, port in zip(self._options.lines, self._options.ports, strict=True):
            said = ""
            while True:
                try:
                    reader = open_reader(port, settings, line)
                    break
                except PortError as error:
                    if not self._options.wait_for_port:
                        raise
                    if str(error) != said:
                        said = str(error)
                        say(f"{said}. Waiting for it")
                time.sleep(PAUSE_S)
            self._open.append(reader)
            self._check_steering(reader)
        return list(self._open)

    def reopen(self, lost: Reader, settings: LineSettings) -> Reader:
        """Open a port again. PortError while it is not back."""
        if lost in self._open:  # its device gets the same name only after the old one is closed
            self._open.remove(lost)
            lost.close()
        reader = open_reader(lost.name, settings, lost.line)
        self._open.append(reader)
        return reader

    def close(self) -> None:
        """Close all ports."""
        while self._open:
            self._open.pop().close()

    def _check_steering(self, reader: Reader) -> None:
        options = self._options
        steered = "--follow-baud" if options.follow_baud else "--baud auto" if options.formats else ""
        if steered and isinstance(reader, Distant):
            raise PortError(f"{reader.name}: the tap there sets the rate: give {steered} to `sistap serve`, not here")
