# SPDX-License-Identifier: GPL-2.0-or-later
"""The virtual bus in the page, in real time, with faults that are switched on and off while it plays."""

from __future__ import annotations

import json

from sisbus.library import Live, answer, complete
from sistap.commands.web.window import Window
from sistap.dissected.captures.stream import Stream

# What each switch does: the table of a scenario.
SWITCHES: dict[str, dict[str, object]] = {
    "late": {"kind": "late", "ms": 60, "probability": 0.3},
    "silent": {"kind": "silent", "probability": 0.3},
    "pause": {"kind": "pause", "ms": 12, "probability": 0.2},
    "checksum": {"kind": "checksum", "probability": 0.2},
    "parity": {"kind": "parity", "probability": 0.2},
    "break": {"kind": "break", "probability": 0.1},
    "lost": {"kind": "lost", "probability": 0.2},
    "noise": {"kind": "noise", "probability": 0.1},
}


def listed() -> str:
    """Return the scenarios that the page can play, as JSON: name, title, and whether faults can be switched."""
    return json.dumps([(name, one.title, not one.procedure) for name, one in complete().items()])


WINDER = (3, 4, 5, 9)  # the drives of the course


def answered(command: str) -> str:
    """Return what a drive of the course answers to a command, both in hexadecimal; empty if nobody does."""
    return answer(bytes.fromhex(command), WINDER).hex()


class Play:
    """A scenario that is played. Times are those of the bus, in s."""

    def __init__(self, name: str, seed: int) -> None:
        self._stream = Stream()
        self._live = Live(name, seed, self._stream, lambda record: self._window.add(record), switches=SWITCHES)
        self.switch = self._live.switch
        self._window = Window(self._live.tap.interfaces, self._live.tap.started)

    def step(self, now_s: float) -> bytes:
        """Play up to a time; return the blocks that this adds to the capture."""
        self._live.play_until(now_s)
        return self._stream.take()

    @property
    def is_over(self) -> bool:
        """Tell whether nothing follows."""
        return self._live.is_over

    @property
    def said(self) -> str:
        """Return the counters in words."""
        return self._live.tap.counters.text

    def window(self) -> bytes:
        """Return the last records as a capture."""
        return self._window.capture()

    @property
    def left_out(self) -> int:
        """Return how many records the window no longer has."""
        return self._window.left_out

    def end(self) -> bytes:
        """End the capture; return its last blocks."""
        self._live.tap.close()
        return self._stream.take()
