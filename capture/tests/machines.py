# SPDX-License-Identifier: GPL-2.0-or-later
"""A small machine in memory: masters, drives, a clock of its own; and what the engine says of it."""

from __future__ import annotations

import random
from collections.abc import Iterable, Sequence
from typing import Any

from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.episodes.lines import lines, verdict
from sistap.dissected.episodes.rules import Severity
from sistap.dissected.packets.dissection import Judged, Packet, Telegram
from sistap.dissected.wireshark.rows import EVENT, FRAME, OTHER
from sistap.tap.records.record import Event

PLC, PANEL, LAPTOP = 1, 2, 127
BEGIN_S = 1_795_500_000.0  # 2026-11-24 06:00:00 UTC
DEVICE = 4
RUNS, STANDS, FAULT, WARNING = 0xA0101, 0xA0012, 0xF2028, 0xE2051
DIAGNOSIS, SPEED = "S-0-0390", "S-0-0040"


def telegram(talker: int | None, listener: int | None, *, is_reaction: bool = False, **more: Any) -> Telegram:
    """Return a good one that reads a parameter; `more` says what is other."""
    said: dict[str, Any] = {
        "good": True,
        "service": 0x10,
        "talker": talker,
        "listener": listener,
        "is_reaction": is_reaction,
        "status": 0 if is_reaction else None,
        "phase": "",
        **dict.fromkeys(("is_refusal", "has_system_error", "is_repeat", "unanswered", "is_doubtful"), False),
        **dict.fromkeys(("command_in", "load_percent", "silence", "reaction", "pause", "cycle", "pause_position")),
    }
    return Telegram(**said | more)


def packet(epoch_s: float, *telegrams: Telegram, number: int = 1, **more: Any) -> Packet:
    """Return one of these telegrams; `more` says what else it is."""
    said: dict[str, Any] = {
        "interface": "",
        "type": FRAME,
        "format": "8E1",
        "text": "",
        "faults": (),
        "time_s": epoch_s,
        "intervals_s": [],
        **dict.fromkeys(("line", "framing", "event", "uncertainty_s")),
        **{"baud": 9600, "same_read": 0, "errors": 0},
    }
    return Packet(**said | {"number": number, "epoch_s": epoch_s, "telegrams": [*telegrams]} | more)


def raw(number: int, size: int) -> str:
    """Return the bytes of a number."""
    return number.to_bytes(size, "little", signed=number < 0).hex()


def access(station: int | str, ident: str, value: str | float, *, master: int | None = PLC, **more: Any) -> Access:
    """Return a read that the dissector has described: a number with a unit, or a text."""
    number = None if isinstance(value, str) else float(value)
    unit = "" if number is None else str(more.pop("unit", "rpm"))
    shown = str(value) if number is None else f"{value} {unit}"
    said: dict[str, Any] = {
        "parameter": Parameter(str(more.pop("port", "")), str(station), int(more.pop("device", DEVICE)), ident),
        "is_write": False,
        "master": master,
        "value": shown,
        "number": number,
        "data": None if number is None else raw(round(number * 10_000), 4),
        "text": shown if number is None else None,
        "unit": unit,
        **dict.fromkeys(("error", "name", "minimum", "maximum"), ""),
    }
    return Access(**said | more)


def diagnosis(station: int | str, code: int, **more: Any) -> Access:
    """Return what a drive says of itself, as the dissector shows it."""
    return access(station, DIAGNOSIS, f"0x{code:08X}", number=float(code), data=raw(code, 4), **more)


def undescribed(station: int, ident: str, data: bytes, **more: Any) -> Access:
    """Return a value of which nobody knows more than its bytes."""
    return access(station, ident, data.hex(" "), data=data.hex(), text=None, is_raw=True, **more)


class Machine:
    """A PLC that asks some drives, a panel that asks now and then."""

    def __init__(
        self,
        *drives: int,
        before: Engine | None = None,
        is_described: bool = True,
        **packets: Any,
    ) -> None:
        """Begin with drives that run; `packets` says what all packets have. If they are not described, nobody reads
        attributes.
        """
        self.engine = Engine(before)
        self.drives = drives or (3, 4, 5)
        self.now_s = self.begin_s = BEGIN_S
        self.says = dict.fromkeys(self.drives, RUNS)
        self.turns = dict.fromkeys(self.drives, 1000.0)
        self.more: dict[str, Any] = {}  # of the next reactions
        self.has_panel = True
        self._is_described = is_described
        self._packets = packets
        self.times_s = [0.0]  # of packets, by number
        self._chance = random.Random(1)

    def put(self, *telegrams: Telegram, accesses: Iterable[Access] = (), after_s: float = 0.0, **more: Any) -> None:
        """Let a packet come."""
        self.now_s += after_s
        port = (self._packets | more).get("interface", "")
        said = [one._replace(parameter=one.parameter._replace(port=port)) if port else one for one in accesses]
        more = self._packets | {"accesses": said, "number": len(self.times_s)} | more
        self.times_s.append(self.now_s)
        self.engine.add(packet(self.now_s, *telegrams, **more))

    def event(self, event: Event, text: str = "") -> None:
        """Let something happen to the tap."""
        self.put(type=EVENT, event=int(event), text=text)

    def ask(self, station: int, master: int | None = PLC, **more: Any) -> None:
        """Send a command."""
        self.put(telegram(master, station, **more), after_s=0.02)

    def answer(self, station: int, *accesses: Access, master: int | None = PLC, **more: Any) -> None:
        """Let a drive answer."""
        self.put(telegram(station, master, is_reaction=True, **self.more | more), accesses=accesses, after_s=0.01)

    def exchange(self, *accesses: Access, station: int | None = None, master: int | None = PLC, **more: Any) -> None:
        """Ask a drive and let it answer."""
        station = int(accesses[0].parameter.station.partition("/")[0]) if station is None else station
        self.ask(station, master, **{key: value for key, value in more.items() if key in ("service", "phase")})
        self.answer(station, *accesses, master=master, **more)

    def write(self, station: int, ident: str, value: str | float, *, master: int | None = PLC, **more: Any) -> None:
        """Write a parameter."""
        self.exchange(access(station, ident, value, master=master, is_write=True, **more), master=master)

    def refuse(self, station: int, ident: str, error: str, *, is_write: bool = False, master: int = PLC) -> None:
        """Let a drive refuse a parameter."""
        said = access(station, ident, "", error=error, is_write=is_write, master=master)
        self.exchange(said, master=master, is_refusal=True, status=1)

    def pause(self, seconds: float) -> None:
        """Let the bus be silent."""
        self.now_s += seconds

    def silent(self, station: int, commands: int = 1, *, every_s: float = 0.5, **more: Any) -> None:
        """Ask a drive that does not answer."""
        for _ in range(commands):
            self.put(telegram(PLC, station, unanswered=True, **more), after_s=every_s)

    def damage(self, station: int = 3, **more: Any) -> None:
        """Ask a drive, whose answer is damaged."""
        self.ask(station)
        self.put(telegram(station, PLC, is_reaction=True, good=False), after_s=0.01, **more)

    def noise(self, records: int = 1, *, every_s: float = 0.1) -> None:
        """Let records come that are no telegrams."""
        for _ in range(records):
            self.put(type=OTHER, after_s=every_s)

    def boot(self, *stations: int, stuck: int | None = None, switch: int = 0x1D) -> None:
        """Initialise drives: identification, times, phases by a service. One may stay in phase 2."""
        for station in stations or self.drives:
            self.exchange(station=station, service=0x00)
            self.exchange(station=station, service=0x03)
            for phase in ("2",) if station == stuck else ("2", "4"):
                self.exchange(station=station, service=switch, phase=phase)
                self.now_s += 1

    def run(self, seconds: float, *more: Access, every_s: float = 2.0) -> None:
        """Let the PLC ask all drives what they say and how fast they turn, for a time; and the panel, one of them."""
        end_s = self.now_s + seconds
        while self.now_s < end_s:
            cycle_s = self.now_s
            for station in self.drives:
                turns = self.turns[station] and self.turns[station] + self._chance.gauss(0, 1)
                self.exchange(self._diagnosis(station))
                self.exchange(self._speed(station, turns))
            if self.has_panel:
                self.exchange(self._diagnosis(self.drives[0]), master=PANEL)
            for one in more:
                self.exchange(one)
            self.now_s = max(self.now_s, cycle_s + every_s)

    def _diagnosis(self, station: int) -> Access:
        code = self.says[station]
        return (
            diagnosis(station, code)
            if self._is_described
            else undescribed(station, DIAGNOSIS, code.to_bytes(4, "little"))
        )

    def _speed(self, station: int, turns: float) -> Access:
        if self._is_described:
            return access(station, SPEED, turns)
        return undescribed(station, SPEED, round(turns * 10_000).to_bytes(4, "little", signed=True))

    def stop(self, seconds: float) -> None:
        """Let all drives stand for a time."""
        self.all(STANDS, 0.0)
        self.run(seconds)
        self.all(RUNS, 1000.0)

    def all(self, code: int, turns: float) -> None:
        """Let all drives say a diagnosis and turn so fast."""
        self.says, self.turns = dict.fromkeys(self.drives, code), dict.fromkeys(self.drives, turns)

    def finish(self) -> Sequence[Episode]:
        """Return what happened."""
        return self.engine.finish()

    def told(self) -> Told:
        """Return it in words, too."""
        return Told(self.finish(), self.begin_s, self.now_s)


class Told:
    """What is said of a machine."""

    def __init__(self, episodes: Sequence[Episode], begin_s: float, end_s: float) -> None:
        """Say it."""
        self.episodes = episodes
        self.verdict = verdict(episodes)
        self.lines = [line.text for line in lines(episodes, begin_s, end_s)]
        self.text = "\n".join(self.lines)

    @property
    def kinds(self) -> list[str]:
        """Return the kinds, in the order of their beginning."""
        return [one.kind for one in self.episodes]

    def of(self, kind: str) -> list[Episode]:
        """Return the episodes of a kind."""
        return [one for one in self.episodes if one.kind == kind]

    @property
    def worse(self) -> list[tuple[str, Severity]]:
        """Return all that is to be looked at."""
        return [(one.kind, one.severity) for one in self.episodes if one.severity >= Severity.WARNING]


def judged(time_s: float, limit_s: float | None, verdict: int) -> Judged:
    """Return a time with its limit."""
    return Judged(time_s, limit_s, verdict)
