# SPDX-License-Identifier: GPL-2.0-or-later
"""Judges a capture by what was really sent: characters with line errors, breaks and losses among them."""

from __future__ import annotations

import bisect
import itertools
import random
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from sistap.tap.line.drivers import Driver, ErrorPlace
from sistap.tap.line.settings import Flag

# Line status of a UART; LOST: characters were lost before this one.
LOST, PARITY, FRAMING, BREAK = 0x02, 0x04, 0x08, 0x10
DAMAGED = PARITY | FRAMING | BREAK

Character = tuple[int, int]  # value, line status
_LOCATED = Flag.CHARACTER_ERROR | Flag.BREAK
_KINDS = (0, PARITY, FRAMING, PARITY | FRAMING, FRAMING | BREAK, LOST)
_OFTEN = (960, 16, 8, 4, 8, 4)
_BAD, _GOOD = 500, 1500  # characters: so many with errors among them, then so many without any, again and again
_FAR = 600  # characters; an error that far away is no reason to mark one ...
_MOST_FAR = 0.5  # ... but in a slow guest a tap that is late marks more: so large a part of such characters


def traffic(count: int, seed: int = 1) -> list[Character]:
    """Make characters, many of them such as drivers treat in a special way. Of the bad parts, 4 % have an error, a
    break or a loss.
    """
    chance = random.Random(seed)
    made = [(0x02, 0)]
    while len(made) < count:
        is_bad = len(made) % (_BAD + _GOOD) < _BAD
        status = chance.choices(_KINDS, _OFTEN)[0] if is_bad else 0
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


def _far(line: Sequence[Character]) -> list[bool]:
    """Tell of each character whether no error is near."""
    bad = [at for at, (_, status) in enumerate(line) if status]
    places = [bisect.bisect(bad, at) for at in range(len(line))]
    return [all(abs(at - near) > _FAR for near in bad[max(i - 1, 0) : i + 1]) for at, i in enumerate(places)]


def _without_errors(line: Sequence[Character], found: Sequence[tuple[int, Flag]]) -> list[bool]:
    """Tell of each character whether its read has no error."""
    numbers = list(itertools.accumulate(not flags & Flag.SAME_READ for _, flags in found))
    bad = {number for number, (_, status) in zip(numbers, line, strict=True) if status}
    return [number not in bad for number in numbers]


class Figures(NamedTuple):
    """What was told of the errors, in characters; a loss is one, too. The names are those of a table."""

    errors: int = 0
    exact: int = 0  # at their place
    somewhere: int = 0
    missing: int = 0
    innocents: int = 0  # good characters marked at their place
    doubted: int = 0  # good characters marked "somewhere", in a read without any error
    false_breaks: int = 0
    losses: int = 0
    told: int = 0  # losses
    made_00: int = 0  # by Linux


def judged(line: Sequence[Character], found: Sequence[tuple[int, Flag]], driver: Driver, *, doubts_00: bool) -> Figures:
    """Return the figures; AssertionError if the capture says more than the driver, or less.

    `doubts_00`: the driver can make another character 00, if it marks it.
    """
    assert len(found) == len(line), f"{len(found)} characters instead of {len(line)}"
    counts: Counter[str] = Counter()
    trouble: list[str] = []
    far, clean = _far(line), _without_errors(line, found)
    first = 0  # of its read
    for at, ((value, status), (captured, flags)) in enumerate(zip(line, found, strict=True)):
        if not flags & Flag.SAME_READ:
            first = at
        is_told = bool(found[first][1] & Flag.LOST_BEFORE)
        verdicts = _verdicts(value, status, captured, flags)
        counts.update(name for name, is_so in verdicts.items() if is_so)
        counts["doubted"] += verdicts["unlocated"] and clean[at]
        counts["doubted far away"] += verdicts["unlocated"] and far[at]
        counts["losses"] += bool(status & LOST)
        counts["told"] += bool(status & LOST) and is_told
        is_dark = captured == 0 and verdicts["unlocated"] and doubts_00
        faults = {
            "a wrong character": verdicts["made_00"] and not is_dark,
            "a false break": verdicts["false_breaks"],
            "an innocent": verdicts["innocents"],
            "a missing error": verdicts["missing"] and driver.place != ErrorPlace.NOWHERE,
            "an error without its place": verdicts["somewhere"] and driver.place == ErrorPlace.CHARACTER,
            "a missing loss": status & LOST and driver.counts and not is_told,
        }
        trouble += [f"{what} at {at}" for what, is_so in faults.items() if is_so]
    assert counts["doubted far away"] <= _MOST_FAR * sum(far), f"{counts['doubted far away']} doubts without a reason"
    assert not trouble, f"{len(trouble)} times: {'; '.join(trouble[:5])}"
    return Figures(**{name: counts[name] for name in Figures._fields})


def _verdicts(value: int, status: int, captured: int, flags: Flag) -> dict[str, bool]:
    is_damaged, is_located = bool(status & DAMAGED), bool(flags & _LOCATED)
    is_unlocated = bool(flags & Flag.UNLOCATED_ERROR) and not is_located
    return {
        "errors": is_damaged,
        "exact": is_damaged and is_located,
        "somewhere": is_damaged and is_unlocated,
        "missing": is_damaged and not is_located and not is_unlocated,
        "innocents": is_located and not is_damaged,
        "unlocated": is_unlocated,
        "false_breaks": bool(flags & Flag.BREAK) and not status & BREAK,
        "made_00": captured != value,
    }
