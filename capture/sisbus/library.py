# SPDX-License-Identifier: GPL-2.0-or-later
"""The virtual bus for other programs: `sistap.play`, the page, the course, completion, and the demo in Wireshark."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from sisbus.playing.characters import NO_FAULTS, Faults, Played
from sisbus.scenarios.faults import Fault, Switch
from sisbus.scenarios.scenario import DEFAULT, Playing, Scenario, load, names
from sisbus.stations.making import make
from sisbus.table import Table
from sisbus.wires.place import ANY_LOCAL, serve
from sisbus.wires.recording import Recording
from sisbus.wires.taps import Taps
from sisbus.wires.wire import Pace
from sistap.tap.files.output import Output
from sistap.tap.records.cut import Cut
from sistap.tap.records.record import Record

__all__ = ["DEFAULT", "Live", "answer", "complete", "demo", "framing", "names"]

_NO_SWITCHES: Mapping[str, Mapping[str, object]] = {}


def complete() -> dict[str, Scenario]:
    """Return the built-in scenarios with masters and stations, by name."""
    return {name: scenario for name in names() if (scenario := load(name)).is_complete}


def answer(command: bytes, addresses: Iterable[int]) -> bytes:
    """Return the reaction of drives that were just switched on to a command; nothing if nobody answers."""
    stations = make([{"address": address} for address in addresses], _SEED)
    return next(filter(None, (station.react(command, 0) for station in stations)), b"")


class Live:
    """A scenario that is played into an output, as far as is asked for."""

    def __init__(  # noqa: PLR0913 - what is played, and how it is heard
        self,
        name: str,
        seed: int,
        output: Output,
        heard: Callable[[Record], object],
        end_ns: float = math.inf,
        switches: Mapping[str, Mapping[str, object]] = _NO_SWITCHES,
    ) -> None:
        """Begin; `heard` gets each record. `switches` are tables [[fault]] that act while they are switched on.

        May raise ValueError or OSError.
        """
        self._switched_on: set[str] = set()
        tables = [Fault.of_table(Table(table, name)) for table in switches.values()]
        scenario = load(name)
        faults = [Switch(**vars(fault), switched_on=self._switched_on) for fault in tables]
        scenario = replace(scenario, faults=[*scenario.faults, *faults])
        self.tap = Recording(output, scenario, name, seed, heard=heard)
        self._played = scenario.play(scenario.settings, Playing(seed, end_ns=end_ns))
        self._next = next(self._played, None)

    def switch(self, kind: str, is_on: bool) -> None:
        """Switch a fault on or off."""
        (self._switched_on.add if is_on else self._switched_on.discard)(kind)

    def play_until(self, time_s: float) -> None:
        """Play everything that is over at that time of the bus."""
        while self._next and _end_s(self._next) <= time_s:
            self.play_next()

    def play_next(self) -> None:
        """Play what is sent next, unless nothing is."""
        if self._next:
            self.tap.deliver(self._next)
            self._next = next(self._played, None)

    @property
    def is_over(self) -> bool:
        """Tell whether nothing follows."""
        return self._next is None


def _end_s(played: Played) -> float:
    last_ns = played.characters[-1].time_ns if played.characters else played.time_ns
    return last_ns / 1e9


# -- The demo: played in this process, for as long as the process lives ----------------------------------------------

_DEMO_FAULTS = "checksum=0.04,parity=0.003,pause=0.001"  # of the default scenario: some in each second
_SEED = 1
_A_CHARACTER = 1  # at a time, as on a line


def framing(name: str) -> Cut:
    """Return how a tap must cut what is played. ValueError: there is no such scenario."""
    return load(name or DEFAULT).cut


def demo(name: str, faults: str) -> str:
    """Start a bus that waits for its listener; return the address for -i. ValueError: an option is wrong."""
    played = load(name or DEFAULT)
    if name in ("", DEFAULT):
        faults = faults or _DEMO_FAULTS
    how = Playing(_SEED, tap_faults=Faults.parse(faults) if faults else NO_FAULTS)
    telegrams = played.play(played.settings, how)
    wire = Taps(Pace(), ANY_LOCAL, _SEED, _A_CHARACTER)

    def play() -> None:
        wire.wait_for_listener()
        serve(wire, telegrams, None)

    threading.Thread(target=play, daemon=True).start()
    return wire.name
