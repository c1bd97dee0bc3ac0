# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters on their way to the line, where faults still can change them."""

from __future__ import annotations

from dataclasses import dataclass, field

from sistap.line.settings import LineSettings

CHECKSUM = 1  # its place in a telegram


@dataclass
class Slot:
    """One character, and what is different about it."""

    value: int
    flags: int = 0  # of Flag.FROM_READER
    pause_ns: int = 0  # in front of it, more than usual


@dataclass
class Sending:
    """What a station sends in one go, and what becomes of it on the line."""

    sent: bytes
    settings: LineSettings  # with which it is sent
    slots: list[Slot] = field(default_factory=list)
    before: list[Slot] = field(default_factory=list)  # what is on the line before it, and is nobody's
    marks: list[str] = field(default_factory=list)
    delay_ns: int = 0  # of a reaction, more than usual
    silent: bool = False  # it is not sent at all
    colliding: bool = False  # another master sends at the same time
    damaged: bool = False  # no station understands it

    def __post_init__(self) -> None:
        self.slots = [Slot(value) for value in self.sent]

    def set_checksum(self, value: int) -> None:
        """Send another checksum."""
        self.sent = self.sent[:CHECKSUM] + bytes([value]) + self.sent[CHECKSUM + 1 :]
        self.slots[CHECKSUM].value = value
