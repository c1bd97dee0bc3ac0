# SPDX-License-Identifier: GPL-2.0-or-later
"""Joins several captures for tests of all of them: starting tshark takes longer than dissecting a small capture.

Every capture is a section with its own interfaces, and so is a separate bus.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from make import CLIENT_PORT, Scenario, scenarios


@dataclass(frozen=True)
class Group:
    """Captures that are dissected together."""

    name: str
    paths: tuple[Path, ...]
    options: tuple[str, ...] = ()

    def write(self, capture: Path) -> None:
        """Write all of them into one capture, each as a section of its own."""
        capture.write_bytes(b"".join(_as_section(path, number) for number, path in enumerate(self.paths)))

    def whose(self, number: int) -> str:
        """Return the capture, and the packet in it, of packet `number`; both count from 1."""
        for path in self.paths:
            count = len(Scenario(path).items)
            if number <= count:
                return f"{path.stem} packet {number}"
            number -= count
        raise IndexError(number)


@cache
def groups() -> tuple[Group, Group, Group]:
    """Return all captures once without options, and once with the options of all of them; last those of TCP."""
    all_of_them = [Scenario(path) for path in scenarios()]
    over_tcp = [scenario for scenario in all_of_them if scenario.link == "tcp"]
    others = [scenario for scenario in all_of_them if scenario.link != "tcp"]
    paths = tuple(scenario.path for scenario in others)
    with_options = Group("all-options", paths, _options(others))
    return Group("plain", paths), with_options, Group("tcp", tuple(one.path for one in over_tcp), _options(over_tcp))


def _options(scenarios: list[Scenario]) -> tuple[str, ...]:
    return tuple(word for scenario in scenarios for word in scenario.options)


def _as_section(path: Path, number: int) -> bytes:
    """Return a capture; where it is one of several over TCP, with a client's port of its own."""
    scenario = Scenario(path)
    for item in scenario.items if scenario.link == "tcp" else ():
        item.raw = (item.raw or b"").replace(CLIENT_PORT.to_bytes(2), (CLIENT_PORT + number).to_bytes(2))
    return scenario.capture()
