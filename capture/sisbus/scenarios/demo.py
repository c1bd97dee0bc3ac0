# SPDX-License-Identifier: GPL-2.0-or-later
"""The script of the demo's master: its commands, in order."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator, Sequence

from sisbus.devices.parameters import Element, control, ident, number
from sisbus.playing.conducting import Rate, Script
from sisbus.playing.player import Times
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.rates import BAUD_MASKS
from sistap.tap.sis.telegram import BROADCAST, build

MASTER = 16
DRIVES = (3, 4)
ROUTE = (2, 8)  # below drive 3, as in fig. 2-10

DESCRIBED = ("S-0-0044", "S-0-0036", "S-0-0040", "S-0-0051", "S-0-0095")
MISSING = "P-0-0999"
COMMAND_SET, COMMAND_CLEAR = b"\x03\x00", b"\x00\x00"

TEST_MS = 500  # how long a timed test of a rate lasts

_VELOCITY_STEP = 400_000  # 0.0001 rpm
_VELOCITY_LIMIT = 29_000_000


def commands(settings: LineSettings, seed: int, cycles: int, rates: Sequence[int] = ()) -> Script:
    """Play the demo: the start-up, then the loop `cycles` times (0: endlessly).

    After each loop the bus changes to the next of `rates` (of RATES), in turn.
    """
    for drive in DRIVES:
        yield from _identification(drive)
    for drive in DRIVES:
        yield from _initialization(drive, settings)
    yield build(0x03, MASTER, BROADCAST, b"\x00\xff")  # fig. 6-24: accept the values, all of you
    velocities = _velocities(random.Random(f"{seed} master"))
    for cycle in range(cycles) if cycles else itertools.count():
        yield from _cycle(cycle, next(velocities))
        if rates:
            before = rates[(cycle - 1) % len(rates)] if cycle else settings.baud
            yield from _change_of_rate(before, rates[cycle % len(rates)])


def _identification(drive: int) -> Iterator[bytes]:
    for subservice in (0x01, 0x03, 0x04):
        yield build(0x00, MASTER, drive, bytes([drive, subservice]))


def _initialization(drive: int, settings: LineSettings) -> Iterator[bytes]:
    if settings.baud in BAUD_MASKS:  # other rates have no code
        yield build(0x03, MASTER, drive, bytes([drive, 0x07, BAUD_MASKS[settings.baud]]))
    for subservice, milliseconds in enumerate(Times.for_line(settings), start=0x01):
        yield build(0x03, MASTER, drive, bytes([drive, subservice]) + milliseconds.to_bytes(2, "little"))


def _velocities(scatter: random.Random) -> Iterator[int]:
    """Yield a slowly varying velocity in 0.0001 rpm."""
    velocity = 10_000_000
    while True:
        yield velocity
        velocity += scatter.randint(-_VELOCITY_STEP, _VELOCITY_STEP)
        velocity = max(-_VELOCITY_LIMIT, min(velocity, _VELOCITY_LIMIT))


def _cycle(cycle: int, velocity: int) -> Iterator[bytes]:
    described = DESCRIBED[cycle % len(DESCRIBED)]
    for drive in DRIVES:
        # So that a listener who joins at any time learns how to show every value.
        for element in (Element.ATTRIBUTE, Element.NAME, Element.UNIT, Element.DATA):
            yield read_parameter(drive, described, element)
    for drive in DRIVES:
        # Number 0 would mean: do not keep the reaction.
        yield write_parameter(drive, "S-0-0036", number(velocity), number_of_telegram=cycle % 255 + 1)
        yield read_parameter(drive, "S-0-0040")
        yield read_parameter(drive, "S-0-0051")
        yield build(0x12, MASTER, drive)
    yield read_parameter(DRIVES[cycle % 2], MISSING)
    yield from _command(DRIVES[(cycle + 1) % 2], "S-0-0099")
    yield build(0x00, MASTER, DRIVES[0], bytes([ROUTE[-1], 0x01]), subaddresses=bytes(ROUTE))


def _change_of_rate(before: int, baud: int) -> Iterator[bytes | Rate]:
    """Test a rate with one drive (fig. 6-18), then broadcast it: set (fig. 6-12), accept (fig. 6-24)."""
    drive, mask = DRIVES[0], bytes([BAUD_MASKS[baud]])
    yield build(0x03, MASTER, drive, bytes([drive, 0x08]) + TEST_MS.to_bytes(2, "little") + mask)
    yield Rate(baud)
    yield build(0x12, MASTER, drive)
    yield read_parameter(drive, "S-0-0040")
    yield Rate(before, TEST_MS)
    yield build(0x12, MASTER, drive)
    yield build(0x03, MASTER, BROADCAST, b"\x00\x07" + mask)
    yield build(0x03, MASTER, BROADCAST, b"\x00\xff")
    yield Rate(baud)


def _command(drive: int, parameter: str) -> Iterator[bytes]:
    """Start a SERCOS command, ask for its data status (fig. 8-42), clear it."""
    yield write_parameter(drive, parameter, COMMAND_SET)
    yield write_parameter(drive, parameter, ident(parameter)[1:], Element.IDENT_NUMBER)
    yield write_parameter(drive, parameter, COMMAND_CLEAR)


def read_parameter(drive: int, parameter: str, element: Element = Element.DATA) -> bytes:
    """Return a command of service 0x10."""
    return build(0x10, MASTER, drive, bytes([control(element), drive]) + ident(parameter))


def write_parameter(
    drive: int, parameter: str, data: bytes, element: Element = Element.DATA, number_of_telegram: int | None = None
) -> bytes:
    """Return a command of service 0x1F."""
    body = bytes([control(element), drive]) + ident(parameter) + data
    return build(0x1F, MASTER, drive, body, number=number_of_telegram)
