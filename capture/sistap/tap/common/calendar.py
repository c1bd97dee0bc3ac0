# SPDX-License-Identifier: GPL-2.0-or-later
"""Local time, in every system. Windows knows no time before 1970, and none after the year 3000.

Logs without dates are of 1970-01-01. In Windows, `astimezone` fails for a time of that day that has no zone yet.
"""

from __future__ import annotations

import time
from datetime import UTC, datetime


def local(epoch_s: float) -> datetime | None:
    """Return seconds since 1970 as local time; None if no calendar has it."""
    try:
        return datetime.fromtimestamp(epoch_s, UTC).astimezone()
    except (ValueError, OverflowError, OSError):
        return None


def of_clock(naive: datetime) -> datetime:
    """Return what the clock here shows as local time; as UTC where no calendar has it, as no packet is of that time."""
    try:
        moment = local(time.mktime(naive.timetuple()))
    except OverflowError:
        moment = None
    return moment.replace(microsecond=naive.microsecond) if moment else naive.replace(tzinfo=UTC)
