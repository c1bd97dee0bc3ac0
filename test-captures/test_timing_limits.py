# SPDX-License-Identifier: GPL-2.0-or-later
"""Whatever a master sets, and whoever accepts it: the limits are those that the stations themselves would have.

A station keeps one value of each kind that is set and one that is valid (chapter 6); subservice 0xFF makes the one the
other. What all of them have was set for all and accepted by all.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from tables import shown

BUSES = 60
STEPS = 60
ALL, GROUP = 255, 200
NAMES = {0x01: "trs", 0x02: "tza"}

Values = dict[str, tuple[int, int]]  # by name: ms, and the number of the command that set them


@dataclass
class Station:
    """What a station was told."""

    told: Values = field(default_factory=dict)
    valid: Values = field(default_factory=dict)

    def take(self, subservice: int, milliseconds: int, number: int) -> None:
        """Take a value, or accept the values."""
        if subservice == 0xFF:
            self.valid |= self.told
        else:
            self.told = self.told | {NAMES[subservice]: (milliseconds, number)}


class Bus:
    """A bus of stations 3 to 5, what its master says, and which limits each telegram has."""

    def __init__(self, random: Random, first: int) -> None:
        """Say everything; telegrams are counted from `first`."""
        self._random = random
        self._number = first - 1
        self._stations = {address: Station() for address in (3, 4, 5, ALL)}
        self.lines: list[str] = []
        self.limits: dict[int, Values] = {}
        for _ in range(STEPS):
            address = random.choice((3, 4, 5, ALL, ALL, GROUP))
            random.choice((self._set, self._set, self._poll))(address)

    def _say(self, text: str, address: int, *, damaged: bool = False) -> int:
        """Say a telegram; return its number. Nothing certain is known of a damaged one, nor of who is in a group."""
        self._number += 1
        self.lines += [text, "byte 2 0x00"] if damaged else [text]
        station = self._stations[ALL if damaged or address == GROUP else address]
        names = NAMES.values() if text.startswith("reaction") and not damaged else ["tza"]
        self.limits[self._number] = {name: value for name, value in station.valid.items() if name in names}
        return self._number

    def _poll(self, address: int) -> None:
        self._say(f"command 16>{address} 12", address)
        if address < GROUP:
            self._say(f"reaction 16>{address} 12 00 04", address)

    def _set(self, address: int) -> None:
        random = self._random
        subservice, milliseconds = random.choice((0x01, 0x02, 0xFF, 0xFF)), random.randint(20, 99)
        cut, damaged = subservice != 0xFF and random.random() < 0.1, random.random() < 0.1
        data = "" if subservice == 0xFF else f"{milliseconds:02X}" if cut else f"{milliseconds:02X} 00"
        number = self._say(f"command 16>{address} 03 00 {subservice:02X} {data}", address, damaged=damaged)
        outcome = random.choice(("good", "good", "good", "refused", "damaged", "nothing"))
        told = list(self._stations.values()) if address == ALL else [self._stations[address]] if address < GROUP else []
        if not cut and not damaged and (address == ALL or outcome == "good"):
            for station in told:
                station.take(subservice, milliseconds, number)
        if address < GROUP and not damaged and outcome != "nothing":
            body = f"01 00 {subservice:02X} 00" if outcome == "refused" else f"00 00 {subservice:02X}"
            self._say(f"reaction 16>{address} 03 {body}", address, damaged=outcome == "damaged")


def shown_as(limits: Values) -> dict[str, str]:
    """Return the fields of these limits."""
    times = {f"{name}.limit": f"{milliseconds / 1000:.9f}" for name, (milliseconds, _) in limits.items()}
    return times | {f"{name}.set_in": str(number) for name, (_, number) in limits.items()}


def test_limits_are_those_of_the_stations(tshark: Tshark, tmp_path: Path) -> None:
    """Many buses in one capture, each an interface."""
    lines: list[str] = []
    limits: dict[int, Values] = {}
    for seed in range(BUSES):
        bus = Bus(Random(seed), len(limits) + 1)
        lines += [f"interface {seed}", *bus.lines]
        limits |= bus.limits
    (tmp_path / "limits.txt").write_text("\n".join(lines))
    capture = tmp_path / "limits.pcapng"
    capture.write_bytes(Scenario(tmp_path / "limits.txt").capture())
    frames = shown(tshark, capture, "tza.limit tza.set_in trs.limit trs.set_in")
    assert frames.keys() == limits.keys()
    wrong = [
        f"frame {number}: shows {cells}, expected {shown_as(limits[number])}"
        for number, cells in frames.items()
        if cells != shown_as(limits[number])
    ]
    assert not wrong, "\n".join(wrong)
