# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters on their way to the line, where faults can still change them."""

from __future__ import annotations

from dataclasses import dataclass, field

from sistap.line.settings import LineSettings

CHECKSUM = 1  # its place in a telegram


@dataclass
class Slot:
    """One character, and its deviations."""

    value: int
    flags: int = 0  # of Flag.FROM_READER
    pause_ns: int = 0  # pause before it, beyond the usual one


@dataclass
class Sending:
    """What a station sends at once, and what happens to it on the line."""

    sent: bytes
    settings: LineSettings  # settings of the sender
    slots: list[Slot] = field(default_factory=list)
    before: list[Slot] = field(default_factory=list)  # what is on the line before it, from no sender
    marks: list[str] = field(default_factory=list)
    delay_ns: int = 0  # extra delay of a reaction
    silent: bool = False  # it is not sent at all
    colliding: bool = False  # another master sends at the same time
    damaged: bool = False  # no station understands it

    def __post_init__(self) -> None:
        self.slots = [Slot(value) for value in self.sent]

    def set_checksum(self, value: int) -> None:
        """Send another checksum."""
        self.sent = self.sent[:CHECKSUM] + bytes([value]) + self.sent[CHECKSUM + 1 :]
        self.slots[CHECKSUM].value = value
