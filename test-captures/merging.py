# SPDX-License-Identifier: GPL-2.0-or-later
"""Joins several captures for tests of all of them: starting tshark takes longer than dissecting a small capture.

Every capture keeps its own interfaces, and so is a separate bus.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from make import Scenario, scenarios
from sistap.files import pcapng


@dataclass(frozen=True)
class Group:
    """Captures that are dissected together."""

    name: str
    paths: tuple[Path, ...]
    options: tuple[str, ...] = ()

    def write(self, capture: Path) -> None:
        """Write all of them into one capture."""
        capture.write_bytes(b"".join(_merged(self.paths)))

    def whose(self, number: int) -> str:
        """Return the capture, and the packet in it, of packet `number`; both count from 1."""
        for path in self.paths:
            count = len(Scenario(path).items)
            if number <= count:
                return f"{path.stem} packet {number}"
            number -= count
        raise IndexError(number)


def groups() -> list[Group]:
    """Return all captures that can be joined, once without options, and once with the options of all of them."""
    all_of_them = [Scenario(path) for path in scenarios()]
    together = [scenario for scenario in all_of_them if not _is_apart(scenario)]
    paths = tuple(scenario.path for scenario in together)
    options = tuple(word for scenario in together for word in scenario.options)
    return [Group("plain", paths), Group("all-options", paths, options)]


def apart() -> list[Group]:
    """Return each of the other captures alone."""
    return [Group(path.stem, (path,)) for path in scenarios() if _is_apart(Scenario(path))]


def _is_apart(scenario: Scenario) -> bool:
    """Tell whether joined captures would be one TCP connection, or lose their sections."""
    return scenario.link == "tcp" or any(item.section for item in scenario.items)


def _merged(paths: tuple[Path, ...]) -> Iterator[bytes]:
    yield pcapng.section_header("test-captures/merging.py", "")
    packets: list[bytes] = []
    interfaces = 0
    for path in paths:
        first = interfaces
        for kind, block in _blocks(path.with_suffix(".pcapng").read_bytes()):
            if kind == pcapng.INTERFACE_DESCRIPTION:
                interfaces += 1
                yield block
            elif kind == pcapng.ENHANCED_PACKET:
                (interface,) = struct.unpack_from("<I", block, 8)
                packets.append(block[:8] + struct.pack("<I", first + interface) + block[12:])
    yield from packets


def _blocks(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield kind and bytes of each block of a capture that make.py wrote."""
    offset = 0
    while offset < len(data):
        kind, length = struct.unpack_from("<II", data, offset)
        yield kind, data[offset : offset + length]
        offset += length
