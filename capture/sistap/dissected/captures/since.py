# SPDX-License-Identifier: GPL-2.0-or-later
"""From when on a capture is told: `06:00`, `8h`, or a date, counted back from its end."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

from sistap.dissected.captures import reading
from sistap.dissected.captures.joining import begin_ns
from sistap.tap.common.calendar import of_clock
from sistap.tap.terminal.exits import NotCaptured

Since = Callable[[datetime], datetime]  # of the end of the captures

_FIRST = datetime(1, 1, 2, tzinfo=UTC)  # in any time zone
_UNITS = {"m": "minutes", "h": "hours", "d": "days"}
_SPAN = re.compile(r"(\d{1,6}(?:\.\d{1,6})?)([mhd])")
_CLOCK = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)")


def parse(text: str) -> Since:
    """Read 8h, 06:00 or a date. ValueError says what is wrong."""
    if span := _SPAN.fullmatch(text):
        length = timedelta(**{_UNITS[span[2]]: float(span[1])})
        return lambda end: _before(end, length)
    if clock := _CLOCK.fullmatch(text):
        return lambda end: _last(end, int(clock[1]), int(clock[2]))
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        raise ValueError(f"'{text}' is not 8h, 30m, 2d, 06:00 or a date such as 2026-03-14T06:00") from None
    return lambda _: moment if moment.tzinfo else of_clock(moment)


def _before(end: datetime, length: timedelta) -> datetime:
    """Return the time so long before; that of the first year if it would be earlier: all is told then."""
    try:
        return end - length
    except OverflowError:
        return _FIRST


def _last(end: datetime, hour: int, minute: int) -> datetime:
    """Return the last time the clock showed this."""
    found = end.replace(hour=hour, minute=minute, second=0, microsecond=0)
    return found if found <= end else of_clock(found.replace(tzinfo=None) - timedelta(days=1))


def recent(captures: Sequence[Path], since: Since) -> tuple[list[Path], float]:
    """Return the captures, in order, that reach beyond that time, and the time in s since 1970. Raise NotCaptured."""
    last = deque((packet.time_ns for packet in reading.packets(captures[-1]) if packet.time_ns is not None), maxlen=1)
    try:
        from_s = since(datetime.fromtimestamp(last[0] / 1e9, UTC).astimezone()).timestamp()
    except (IndexError, ValueError, OverflowError, OSError):
        raise NotCaptured(f"{captures[-1]} has no time to count back from: leave out --since") from None
    begins = pairwise([*(begin_ns(capture) for capture in captures), None])
    kept = [
        capture for capture, (_, after) in zip(captures, begins, strict=True) if after is None or after > from_s * 1e9
    ]
    return kept, from_s
