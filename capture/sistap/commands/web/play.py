# SPDX-License-Identifier: GPL-2.0-or-later
"""The virtual bus in the page, in real time, with faults that are switched on and off while it plays."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from sisbus.playing.characters import Played
from sisbus.scenarios import scenario
from sisbus.scenarios.faults import Fault
from sisbus.scenarios.scenario import Playing, Scenario
from sisbus.table import Table
from sisbus.wires.recording import START_NS, Recording
from sistap.commands.web.window import Window
from sistap.dissected.captures.stream import Stream
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Record

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


@dataclass
class _Switch(Fault):
    """A fault that acts while it is switched on. Switched off, it changes nothing that is random."""

    switched_on: set[str] = field(default_factory=set)

    def meant(self, telegram: bytes, now_ns: int, scatter: object) -> bool:
        """Tell whether it affects this telegram."""
        return self.kind in self.switched_on and super().meant(telegram, now_ns, scatter)  # type: ignore[arg-type]


class _Tap(Recording):
    """A tap that also keeps the last records."""

    def __init__(self, stream: Stream, settings: LineSettings, text: str, seed: int, played: Scenario) -> None:
        begin_ns = START_NS if played.begin_ns is None else played.begin_ns
        super().__init__(stream, settings, text, seed, 1, played.cut, played.lines, begin_ns)
        self.window = Window(self.interfaces, self.started)

    def _write(self, record: Record) -> None:
        super()._write(record)
        self.window.add(record)


def listed() -> str:
    """Return the scenarios that the page can play, as JSON: name, title, and whether faults can be switched."""
    found = [(name, scenario.load(name)) for name in scenario.names()]
    return json.dumps([(name, one.title, not one.procedure) for name, one in found if one.is_complete])


class Play:
    """A scenario that is played. Times are those of the bus, in s."""

    def __init__(self, name: str, seed: int) -> None:
        self._switched_on: set[str] = set()
        played = scenario.load(name)
        tables = [Fault.of_table(Table(dict(table), name)) for name, table in SWITCHES.items()]
        switches = [_Switch(**vars(fault), switched_on=self._switched_on) for fault in tables]
        played = replace(played, faults=[*played.faults, *switches])
        self._stream = Stream()
        self._tap = _Tap(self._stream, played.settings, f"scenario {name}, seed {seed}", seed, played)
        self._played: Iterator[Played] = played.play(played.settings, Playing(seed))
        self._next: Played | None = next(self._played, None)

    def switch(self, kind: str, is_on: bool) -> None:
        """Switch a fault on or off."""
        (self._switched_on.add if is_on else self._switched_on.discard)(kind)

    def step(self, now_s: float) -> bytes:
        """Play up to a time; return the blocks that this adds to the capture."""
        while self._next and _end_s(self._next) <= now_s:
            self._tap.deliver(self._next)
            self._next = next(self._played, None)
        return self._stream.take()

    @property
    def is_over(self) -> bool:
        """Tell whether nothing follows."""
        return self._next is None

    @property
    def said(self) -> str:
        """Return the counters in words."""
        return self._tap.counters.text

    def window(self) -> bytes:
        """Return the last records as a capture."""
        return self._tap.window.capture()

    @property
    def left_out(self) -> int:
        """Return how many records the window no longer has."""
        return self._tap.window.left_out

    def end(self) -> bytes:
        """End the capture; return its last blocks."""
        self._tap.close()
        return self._stream.take()


def _end_s(played: Played) -> float:
    last_ns = played.characters[-1].time_ns if played.characters else played.time_ns
    return last_ns / 1e9
