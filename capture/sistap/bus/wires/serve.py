# SPDX-License-Identifier: GPL-2.0-or-later
"""Delivers what is played to listeners, at its time."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Protocol

from sistap.bus.ending import Refusal
from sistap.bus.playing.played import Played
from sistap.bus.wires.log import Log
from sistap.bus.wires.pace import Pace
from sistap.bus.wires.port_wire import PortWire
from sistap.files.output import OutputError
from sistap.terminal.advice import shell_word
from sistap.terminal.exits import FAILED


class Wire(Protocol):
    """A way to listeners."""

    name: str  # address for a listener

    def wait_for_listener(self) -> None:
        """Return when somebody listens; the bus then starts."""

    def deliver(self, played: Played) -> list[str]:
        """Deliver all characters at their times; return marks for lost ones."""

    @property
    def deserted(self) -> bool:
        """Tell whether nobody listens, so that the bus can stop."""

    def close(self) -> None:
        """Deliver everything to all listeners, then disconnect them."""


def play(wire: Wire, pace: Pace, telegrams: Iterable[Played], log: Log | None = None, about: str = "") -> None:
    """Play everything once somebody listens; `about` begins the log. May raise Refusal, PortError or PortLost."""
    try:
        try:
            if wire.name:
                print(wire.name, flush=True)
                if not isinstance(wire, PortWire):
                    _say_what_to_type(wire.name)
            wire.wait_for_listener()
            if log:
                log.begin(f"{about}, time 0 is {pace.wall_ns()} ns since 1970")
            serve(wire, telegrams, log)
        finally:
            wire.close()
    except OutputError as error:
        raise Refusal(FAILED, str(error)) from error
    except OSError as error:
        saved = "; the log has what was played before" if log else ""
        raise Refusal(FAILED, f"the bus stopped: {error.strerror or error}{saved}") from error


def _say_what_to_type(name: str) -> None:
    """Tell a person how to capture it; a program that reads standard output wants the name alone."""
    if sys.stdout.isatty():
        print(f"listen to it in another terminal: sistap capture -i {shell_word(name)}", file=sys.stderr)


def serve(wire: Wire, telegrams: Iterable[Played], log: Log | None) -> None:
    """Deliver everything to a wire whose bus has started. May raise OSError."""
    for played in telegrams:
        marks = wire.deliver(played)
        if log:
            log.add(played, marks)
        if wire.deserted:
            break
