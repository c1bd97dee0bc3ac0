# SPDX-License-Identifier: GPL-2.0-or-later
"""The demo bus: a virtual bus played in this process, for as long as the process lives."""

from __future__ import annotations

import threading

from sisbus.playing.characters import NO_FAULTS, Faults
from sisbus.scenarios.scenario import DEFAULT, Playing, load
from sisbus.wires.place import serve
from sisbus.wires.taps import Taps
from sisbus.wires.wire import Pace
from sistap.tap.records.cut import Cut

FAULTS = "checksum=0.04,parity=0.003,pause=0.001"  # of the default scenario: some in each second
_SEED = 1
_A_CHARACTER = 1  # at a time, as on a line


def framing(scenario: str) -> Cut:
    """Return how a tap must cut what is played. ValueError: there is no such scenario."""
    return load(scenario or DEFAULT).cut


def start(faults: str, scenario: str) -> str:
    """Start a bus that waits for its listener; return the address for -i. ValueError: an option is wrong."""
    played = load(scenario or DEFAULT)
    if not scenario or scenario == DEFAULT:
        faults = faults or FAULTS
    how = Playing(_SEED, tap_faults=Faults.parse(faults) if faults else NO_FAULTS)
    telegrams = played.play(played.settings, how)
    wire = Taps(Pace(), "127.0.0.1:0", _SEED, _A_CHARACTER)

    def play() -> None:
        wire.wait_for_listener()
        serve(wire, telegrams, None)

    threading.Thread(target=play, daemon=True).start()
    return wire.name
