# SPDX-License-Identifier: GPL-2.0-or-later
"""Judges a capture by what was really sent: characters with line errors, breaks and losses among them."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Sequence

from sistap.line.drivers import Driver, Place
from sistap.line.settings import Flag

# Line status of a UART; LOST: characters were lost before this one.
LOST, PARITY, FRAMING, BREAK = 0x02, 0x04, 0x08, 0x10
DAMAGED = PARITY | FRAMING | BREAK

Character = tuple[int, int]  # value, line status
_LOCATED = Flag.CHARACTER_ERROR | Flag.BREAK
_KINDS = (0, PARITY, FRAMING, PARITY | FRAMING, FRAMING | BREAK, LOST)
_OFTEN = (960, 16, 8, 4, 8, 4)


def traffic(count: int, seed: int = 1) -> list[Character]:
    """Make characters, many of them such as drivers treat in a special way, 3 % with an error, a break or a loss."""
    chance = random.Random(seed)
    made = [(0x02, 0)]
    while len(made) < count:
        status = chance.choices(_KINDS, _OFTEN)[0]
        value = chance.choice((0, 0xFF, 0xEC, chance.randrange(256), chance.randrange(256)))
        made.append((0 if status & BREAK else value, status))
    return made


def bursts(line: Sequence[Character], seed: int = 1) -> list[Sequence[Character]]:
    """Cut them into what comes without a pause."""
    chance = random.Random(seed)
    cut, at = [], 0
    while at < len(line):
        size = chance.randint(1, 100)
        cut.append(line[at : at + size])
        at += size
    return cut


def judged(line: Sequence[Character], found: Sequence[tuple[int, Flag]], driver: Driver, *, doubts_00: bool) -> str:
    """Return the counts in words; AssertionError if the capture says more than the driver, or less.

    `doubts_00`: the driver can make another character 00, if it marks it.
    """
    assert len(found) == len(line), f"{len(found)} characters instead of {len(line)}"
    counts: Counter[str] = Counter()
    trouble: list[str] = []
    first = 0  # of its read
    for at, ((value, status), (captured, flags)) in enumerate(zip(line, found, strict=True)):
        if not flags & Flag.SAME_READ:
            first = at
        changed = captured != value
        counts["changed by Linux"] += changed
        wrong = changed and not (doubts_00 and captured == 0 and flags & Flag.UNLOCATED_ERROR and not flags & _LOCATED)
        verdicts = {
            "a wrong character": wrong,
            "a false break": flags & Flag.BREAK and not status & BREAK,
            "an innocent": flags & _LOCATED and not status & DAMAGED,
            "a missing error": status & DAMAGED and not flags & ~Flag.SAME_READ and driver.place != Place.NOWHERE,
            "an error without its place": status & DAMAGED and not flags & _LOCATED and driver.place == Place.CHARACTER,
            "a missing loss": status & LOST and driver.counts and not found[first][1] & Flag.LOST_BEFORE,
        }
        trouble += [f"{what} at {at}" for what, is_so in verdicts.items() if is_so]
        if status & DAMAGED:
            counts["errors"] += 1
            counts["at their place"] += bool(flags & _LOCATED)
            counts["breaks"] += bool(status & BREAK)
            counts["told as breaks"] += bool(flags & Flag.BREAK)
        else:
            counts["good ones marked somewhere"] += bool(flags & Flag.UNLOCATED_ERROR)
        counts["losses"] += bool(status & LOST)
        counts["told"] += bool(status & LOST and found[first][1] & Flag.LOST_BEFORE)
    assert not trouble, f"{len(trouble)} times: {'; '.join(trouble[:5])}"
    return ", ".join(f"{count} {what}" for what, count in counts.items())
