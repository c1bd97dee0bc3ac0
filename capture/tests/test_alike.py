# SPDX-License-Identifier: GPL-2.0-or-later
"""What is said of a machine does not depend on other buses, other stations, the numbers of all of them, or files.

What the tests of kinds and words let happen, happens here once more: beside something else, or under other numbers.
"""

from __future__ import annotations

import heapq
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import chain
from operator import attrgetter
from typing import Any

import pytest
import test_kinds
import test_verdicts
from machines import BEGIN_S, PLC, Machine, packet
from test_kinds import Play

from sistap.dissected.accesses.access import Access
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.episodes.episode import Episode
from sistap.dissected.packets.dissection import Packet
from sistap.dissected.wireshark.rows import EVENT
from sistap.tap.records.record import Event

Heard = Iterable[Packet]
Said = tuple[str, str, str, float, int]

CASES = [(case.kind, case.happens) for case in test_kinds.CASES] + [
    (case.kind, case.play) for case in test_verdicts.CASES
]
KINDS = [kind for kind, _ in CASES]
PLAYS = [  # the quick tests try the first of each kind, the thorough tests all others
    pytest.param(play, id=kind, marks=pytest.mark.thorough if kind in KINDS[:place] else ())
    for place, (kind, play) in enumerate(CASES)
]
of_each_play = pytest.mark.parametrize("play", PLAYS, scope="module")  # one after another: each is heard once
STATIONS = {0: 100, 3: 103, 4: 104, 5: 105, 9: 109}  # and those that do the same beside them


class _Kept(Engine):
    """Keeps the packets that it is given."""

    def __init__(self) -> None:
        super().__init__()
        self.packets: list[Packet] = []

    def add(self, packet: Packet) -> None:
        self.packets.append(packet)


@cache
def packets(play: Play) -> Sequence[Packet]:
    """Return what is heard."""
    machine = Machine()
    machine.engine = kept = _Kept()
    play(machine)
    return kept.packets


def episodes(heard: Heard) -> Sequence[Episode]:
    """Return what happened."""
    engine = Engine()
    for one in heard:
        engine.add(one)
    return engine.finish()


@cache
def alone(play: Play) -> Sequence[Episode]:
    """Return what happened if nothing else did."""
    return episodes(packets(play))


def said(found: Iterable[Episode], *ports: str) -> Sequence[Said]:
    """Return what a person reads, of some ports."""
    return sorted(
        (one.kind, one.who, one.detail, round(one.from_s - BEGIN_S, 1), one.count)
        for one in found
        if not ports or one.hit.port in ports
    )


def on(port: str, heard: Heard, line: int | None = None) -> Sequence[Packet]:
    """Return it as another adapter hears it, of both directions or of one."""

    def at(access: Access) -> Access:
        return access._replace(parameter=access.parameter._replace(port=port))

    return [replace(one, interface=port, line=line, accesses=[*map(at, one.accesses)]) for one in heard]


def renamed(heard: Heard, names: Mapping[int, int]) -> Sequence[Packet]:
    """Return it with other numbers of stations and masters."""

    def number(one: int | None) -> int | None:
        return None if one is None else names.get(one, one)

    def of(access: Access) -> Access:
        station, *behind = access.parameter.station.split("/")
        parameter = access.parameter._replace(station="/".join([str(number(int(station))), *behind]))
        return access._replace(parameter=parameter, master=number(access.master))

    return [
        replace(
            one,
            telegrams=[replace(it, talker=number(it.talker), listener=number(it.listener)) for it in one.telegrams],
            accesses=[*map(of, one.accesses)],
        )
        for one in heard
    ]


def in_words(said: Iterable[Said], names: Mapping[int, int]) -> Sequence[Said]:
    """Return what a person reads with other numbers of stations and masters."""

    def number(found: re.Match[str]) -> str:
        numbers = sorted(names.get(int(one), int(one)) for one in found[2].split(", "))
        return f"{found[1]} {', '.join(map(str, numbers))}"

    def words(text: str) -> str:
        return re.sub(r"\b(stations?|master) (\d+(?:, \d+)*)", number, text)

    return sorted((kind, words(who), words(detail), at_s, count) for kind, who, detail, at_s, count in said)


def exchanges(heard: Heard) -> Sequence[Sequence[Packet]]:
    """Return each command with what comes before the next one."""
    found: list[list[Packet]] = []
    for one in heard:
        if not found or any(not it.is_reaction for it in one.telegrams):
            found.append([])
        found[-1].append(one)
    return found


def of_each(found: Iterable[Episode], stations: Iterable[int]) -> Sequence[tuple[int, str, str, float]]:
    """Return for each station what happened to it, and when: by its place among the stations."""
    return sorted(
        (place, one.kind, one.hit.parameter, one.from_s - BEGIN_S)
        for one in found
        for place, station in enumerate(stations)
        if station in one.stations
    )


@of_each_play
def test_a_bus_knows_nothing_of_another_one(play: Play) -> None:
    """The same happens on two of them at once, something else on the third."""
    other = test_verdicts.CASES[0].play
    ports = {"a": play, "b": play, "c": other}
    heard = heapq.merge(*(on(port, packets(one)) for port, one in ports.items()), key=attrgetter("epoch_s"))
    found = episodes(heard)
    assert {port: said(found, port) for port in ports} == {port: said(alone(one)) for port, one in ports.items()}


@of_each_play
def test_both_directions_are_one_bus(play: Play) -> None:
    """A full-duplex tap has an interface for each."""
    ports = {1: "commands", 2: "reactions"}
    lines = ((1 + any(it.is_reaction for it in one.telegrams), one) for one in packets(play))
    heard = chain.from_iterable(on(ports[line], [one], line=line) for line, one in lines)
    assert said(episodes(heard), *ports.values()) == said(alone(play))


@of_each_play
def test_master_0_is_one_as_any_other(play: Play) -> None:
    names = {PLC: 0, 0: PLC}
    assert said(episodes(renamed(packets(play), names))) == in_words(said(alone(play)), names)


@of_each_play
def test_two_stations_of_which_the_same_is_true(play: Play) -> None:
    """The master asks one after the other."""
    heard = packets(play)
    beside = [replace(one, epoch_s=one.epoch_s + 0.0149) for one in renamed(heard, STATIONS)]
    both = zip(exchanges(heard), exchanges(beside), strict=True)
    found = episodes(one for pair in both for exchange in pair for one in exchange)
    if "recipe" in {one.kind for one in found} - {one.kind for one in alone(play)}:
        pytest.skip("two writes beside two others are a recipe")
    for stations in (STATIONS.keys(), STATIONS.values()):
        expected, here = of_each(alone(play), STATIONS), of_each(found, stations)
        assert [one[:3] for one in here] == [one[:3] for one in expected]
        assert [one[3] for one in here] == pytest.approx([one[3] for one in expected], abs=0.03)


@of_each_play
def test_files_of_a_ring_are_one_capture(play: Play) -> None:
    """Each begins with the event that began the first one, and somebody marks it; here in seven places at most."""

    def begins(first: Packet) -> Sequence[Packet]:
        said: dict[str, Any] = {"type": EVENT, "baud": first.baud, "is_again": first is not heard[0]}
        return [packet(first.epoch_s, event=int(code), **said) for code in (Event.CAPTURE_STARTED, Event.MARKER)]

    heard = packets(play)
    length = max(3, len(heard) // 7)
    files = (heard[place : place + length] for place in range(0, len(heard), length))
    assert said(episodes(chain.from_iterable((*begins(one[0]), *one) for one in files))) == said(alone(play))
