# SPDX-License-Identifier: GPL-2.0-or-later
"""The wire of a virtual bus as samples, and the real sigrok-cli that reads them instead of an analyser's."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import pytest

from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.record import Record, Type

NS = 1_000_000_000
SIGROK = shutil.which("sigrok-cli")
needs_sigrok = pytest.mark.skipif(SIGROK is None, reason="sigrok-cli is not installed (apt-get install sigrok-cli)")

# Stands for sigrok-cli: the real one, with the same options, but that its samples come from a file, or a pipe.
_WRAPPER = """\
#!/bin/sh
# sigrok-cli -d DRIVER --config samplerate=RATE --continuous ...
rate=${4#samplerate=}
shift 5
exec %s -i - -I binary:numchannels=8:samplerate=$rate "$@" < %s
"""


class Sent(NamedTuple):
    """A character on the wire: the middle of its stop bit, and its faults."""

    time_ns: Fraction
    value: int
    settings: LineSettings
    flag: Flag = Flag(0)
    without_stop: bool = False  # a framing error; else CHARACTER_ERROR is a wrong parity


def levels(character: Sent) -> list[int]:
    """Return start bit, data, parity, stop bit; a break is low throughout."""
    settings = character.settings
    if character.flag & Flag.BREAK:
        return [0] * (2 + settings.data_bits + (settings.parity != "N"))
    odd = character.value.bit_count() % 2
    parity = {"N": [], "E": [odd], "O": [1 - odd], "M": [1], "S": [0]}[settings.parity]
    if character.flag & Flag.CHARACTER_ERROR and not character.without_stop:
        parity = [1 - bit for bit in parity]
    data = [character.value >> place & 1 for place in range(settings.data_bits)]
    return [0, *data, *parity, 0 if character.without_stop else 1]


def edges(characters: Iterable[Sent]) -> Iterator[tuple[Fraction, int]]:
    """Yield the times at which the line changes, in ns, and the level from then on."""
    for character in characters:
        bits = levels(character)
        bit_ns = Fraction(NS, character.settings.baud)
        start_ns = character.time_ns - bit_ns * (len(bits) - Fraction(1, 2))
        for place, bit in enumerate(bits):
            yield start_ns + place * bit_ns, bit
        # High again a little before the next one can begin; a break goes on for two bits.
        end = len(bits) + (2 if character.flag & Flag.BREAK else 0) - (0 if bits[-1] else Fraction(1, 10))
        yield start_ns + end * bit_ns, 1


def sampled(
    lines: Iterable[Iterable[Sent]], samplerate: int, end_ns: int, glitches: Iterable[tuple[Fraction, int]] = ()
) -> bytes:
    """Return one byte for each sample: bit n is line n. A glitch begins at a time in ns, on line 0, and takes that many
    samples.

    A sample sees an edge that came at its time or before.
    """
    count = end_ns * samplerate // NS
    wires = []
    for line in lines:
        wire = bytearray()
        level = 1
        for time_ns, then in edges(line):
            sample = -(-time_ns * samplerate // NS)
            wire += bytes([level]) * (int(sample) - len(wire))
            del wire[int(sample) :]
            level = then
        wires.append((wire + bytes([level]) * (count - len(wire)))[:count])
    for time_ns, width in glitches:
        at = int(time_ns * samplerate // NS)
        wires[0][at : at + width] = bytes(1 - bit for bit in wires[0][at : at + width])
    mixed = int.from_bytes(wires[0], "big")
    for number, wire in enumerate(wires[1:], 1):
        mixed |= int.from_bytes(wire, "big") << number
    return mixed.to_bytes(count, "big")


def play(folder: Path, samples: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let sistap find a sigrok-cli with a simulated analyser that has these samples."""
    program = folder / "bin/sigrok-cli"
    program.parent.mkdir(exist_ok=True)
    program.write_text(_WRAPPER % (SIGROK, samples))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)


def of_records(records: Iterable[Record], begin_ns: int) -> list[Sent]:
    """Return the characters of a capture, whose times count from `begin_ns`."""
    sent = []
    for record in records:
        if record.type == Type.EVENT:
            continue
        time_ns = record.time_ns - begin_ns
        for place, value in enumerate(record.data):
            time_ns += record.intervals[place] if place else 0
            sent.append(Sent(Fraction(time_ns), value, record.settings, Flag(record.flags[place]) & Flag.FROM_READER))
    return sent
