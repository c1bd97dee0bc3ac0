# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenarios: who is on the bus, what the masters say and what goes wrong, from a TOML file (README.md beside them)."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

from sisbus.playing.characters import NO_FAULTS, Faults, Played
from sisbus.playing.conducting import MasterLine, Script, conduct, repeating
from sisbus.playing.player import Player, Times
from sisbus.procedure3964 import procedure
from sisbus.procedure3964.procedure import Procedure
from sisbus.scenarios.faults import Disturbances, Fault
from sisbus.scenarios.steps import Master, Step, script, step
from sisbus.stations.making import make
from sisbus.stations.station import Station
from sisbus.table import RATE, STATION, Table, characters, each, flag, instant_ns, text, whole
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.cut import ASCII, PROCEDURE_3964R, SIS, Cut

DEFAULT = "demo"
_SUFFIX = ".toml"
_LONGEST = 10_000_000  # bytes of a file
_MS = 1_000_000
_FOLDER = resources.files("sisbus.scenarios")


@dataclass(frozen=True)
class Playing:
    """How a scenario is played."""

    seed: int = 1
    cycles: int = 0  # passes of a loop, 0: endless
    tap_faults: Faults = NO_FAULTS
    rates: Sequence[int] = ()  # rates to change to after each loop of the demo
    end_ns: float = math.inf  # time of the bus


@dataclass(frozen=True)
class _MasterTable:
    address: int
    repeats: int
    steps: Sequence[Step]


@dataclass(frozen=True)
class Scenario:
    """The contents of a file. It can be played again and again."""

    title: str
    settings: LineSettings
    times: Mapping[str, int]  # TrS, TzA and TwM in ms, if the file has them
    ascii_first: bytes
    masters: Sequence[_MasterTable]
    station_tables: Sequence[Mapping[str, object]]
    faults: Sequence[Fault]
    procedure: Procedure | None = None  # of a scenario of 3964R: all that is played
    begin_ns: int | None = None  # since 1970: its time 0, where time is simulated
    is_typed: bool = False  # a master speaks the ASCII protocol

    @property
    def cut(self) -> Cut:
        """Return how a tap cuts what it hears."""
        return PROCEDURE_3964R if self.procedure else ASCII if self.is_typed else SIS

    @property
    def lines(self) -> Sequence[int]:
        """Return their numbers: a shared bus, or the directions of a full-duplex line."""
        return (1, 2) if self.procedure and self.procedure.duplex else (0,)

    @property
    def has_masters(self) -> bool:
        """Tell whether it has masters."""
        return bool(self.masters or (self.procedure and self.procedure.steps))

    @property
    def has_stations(self) -> bool:
        """Tell whether it has stations."""
        return bool(self.station_tables or (self.procedure and self.procedure.has_ppc))

    @property
    def is_complete(self) -> bool:
        """Tell whether it has both masters and stations."""
        return self.has_masters and self.has_stations

    def stations(self, seed: int) -> list[Station]:
        """Return the stations, as they are after power-on."""
        return make(self.station_tables, seed)

    def times_for(self, settings: LineSettings) -> Times:
        """Return the times on the line: those of the file, or what the line can keep."""
        usual = Times.for_line(settings)
        return usual._replace(**{name: self.times[name] for name in ("trs", "tza") if name in self.times})

    def scripts(self, line: MasterLine, how: Playing) -> dict[int, Script]:
        """Return the scripts of the masters on this line, by address."""
        twm_ns = self.times.get("twm", self.times_for(line.settings).trs) * _MS
        return {
            master.address: repeating(
                script(master.steps, Master(master.address, line, how.seed, how.cycles, how.rates)),
                master.repeats,
                twm_ns,
            )
            for master in self.masters
        }

    def play(self, settings: LineSettings, how: Playing) -> Iterator[Played]:
        """Play it on a simulated line; yield all that is sent, in order."""
        if self.procedure:
            yield from self.procedure.play(settings, how.seed, how.cycles, how.tap_faults, how.end_ns)
            return
        disturb = Disturbances(self.faults, how.seed)
        line = Player(settings, how.tap_faults, how.seed, self.stations(how.seed), self.times_for(settings), disturb)
        if self.ascii_first:
            yield from line.send(self.ascii_first)
        yield from conduct(line, self.scripts(line, how), how.end_ns)


def names() -> list[str]:
    """Return the names of the built-in scenarios."""
    return sorted(file.name.removesuffix(_SUFFIX) for file in _FOLDER.iterdir() if file.name.endswith(_SUFFIX))


def load(name: str) -> Scenario:
    """Read a built-in scenario or a file. ValueError or OSError; the text has the file, the key and the cure."""
    if name.endswith(_SUFFIX) or "/" in name:
        data = _contents(Path(name))
    elif name in names():
        data = (_FOLDER / f"{name}{_SUFFIX}").read_bytes()
    else:
        raise ValueError(f"{name} is neither FILE.toml nor a built-in scenario: {', '.join(names())}")
    try:
        content = tomllib.loads(data.decode("utf-8-sig"))  # Windows editors add a byte order mark
        scenario = _read(Table(content, "the scenario"))
        masters = content.get("master")
        scenario = replace(scenario, is_typed=any(True for _ in _values(masters, "type")))
        _check(scenario, set(_values(masters, "token")))
    except UnicodeDecodeError as error:
        raise ValueError(f"{name}: byte {error.start} is no UTF-8: save the file as UTF-8") from None
    except RecursionError:
        raise ValueError(f"{name}: tables in tables in tables; use fewer levels") from None
    except ValueError as error:  # also from tomllib, with line and column
        one_line = str(error).replace("\n", "\\n")  # keys and values can have several lines
        raise ValueError(f"{name}: {one_line}") from None
    return scenario


def _contents(path: Path) -> bytes:
    """Read a file. ValueError if it is endless, such as /dev/zero, or far too long for a scenario."""
    with path.open("rb") as file:
        data = file.read(_LONGEST + 1)
    if len(data) > _LONGEST:
        raise ValueError(f"{path} is longer than {_LONGEST} bytes, and so no scenario: name another FILE.toml")
    return data


def _read(table: Table) -> Scenario:
    line = table.take("line", lambda value: Table(value, "[line]"), Table({}, "[line]"))
    if "s5" in table or "ppc" in table:
        return _read_procedure(table, line)
    settings, times = _line(line)
    scenario = Scenario(
        table.need("title", text),
        settings,
        times,
        table.take("ascii_first", characters, b""),
        table.each("master", "[[master]]", _master),
        table.take("station", _list, []),
        table.each("fault", "[[fault]]", Fault.of_table),
        begin_ns=table.take("begin", instant_ns, None),
    )
    table.end()
    return scenario


def _read_procedure(table: Table, line: Table) -> Scenario:
    """Read a scenario of 3964R."""
    title, duplex = table.need("title", text), line.take("duplex", flag, False)
    faults = table.each("fault", "[[fault]]", procedure.fault)
    settings, times = _line(line)
    scenario = Scenario(title, settings, times, b"", [], [], [], procedure.read(table, duplex, faults))
    if times:
        raise ValueError("[line]: trs_ms, tza_ms and twm_ms are for SIS: leave them out")
    table.end()
    return scenario


def _list(value: object) -> list[Mapping[str, object]]:
    if not isinstance(value, list):
        raise ValueError("write [[station]]")
    return value


def _line(table: Table) -> tuple[LineSettings, dict[str, int]]:
    baud = table.take("baud", RATE, 9600)
    settings = table.take("format", lambda value: character_format(baud, text(value)), LineSettings(baud))
    times = {name: ms for name in ("trs", "tza", "twm") if (ms := table.take(f"{name}_ms", whole(1, 60_000), 0))}
    table.end()
    return settings, times


def character_format(baud: int, format: str) -> LineSettings:
    """Read rate and format. ValueError if they are invalid, or without 8 data bits."""
    settings = LineSettings.parse(baud, format)
    if settings.data_bits != 8:
        raise ValueError("SIS needs 8 data bits (for example 8E1)")
    return settings


def _master(table: Table) -> _MasterTable:
    address = table.need("address", STATION)
    repeats = table.take("repeats", whole(0, 100), 2)
    return _MasterTable(address, repeats, table.need("script", each(f"{table.where}, step", step)))


def _values(content: object, key: str) -> Iterator[object]:
    """Yield the values of a key, anywhere in scripts."""
    if isinstance(content, Mapping):
        if key in content:
            yield content[key]
        content = list(content.values())
    if isinstance(content, list):
        for item in content:
            yield from _values(item, key)


def _check(scenario: Scenario, tokens: Set[object]) -> None:
    """Refuse contradictions. ValueError says which."""
    scenario.stations(0)
    addresses = [master.address for master in scenario.masters]
    if len(set(addresses)) < len(addresses):
        raise ValueError("two [[master]] have one address: give each another")
    if strangers := tokens - set(addresses):
        raise ValueError(f"token = {min(strangers, key=str)}: there is no such master; add a [[master]]")
    if not addresses and not scenario.has_stations and not scenario.procedure:
        raise ValueError("nobody is on the bus: add [[station]] or [[master]]")
    if not scenario.is_complete and (scenario.faults or scenario.ascii_first):
        raise ValueError(
            "sistap does not disturb a real bus: [[fault]] and ascii_first need [[master]] and [[station]]"
        )
    if len(addresses) < 2 and any(fault.kind == "collision" for fault in scenario.faults):
        raise ValueError('[[fault]] kind = "collision" needs a second [[master]]')
