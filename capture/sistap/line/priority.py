# SPDX-License-Identifier: GPL-2.0-or-later
"""The priority at which this process runs: a small real-time one keeps other programs from making it late."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

PRIORITY = 1  # the smallest: it goes before every ordinary program, and before nothing else (sched(7))


@contextmanager
def real_time() -> Iterator[None]:
    """Run with real-time priority where that is permitted, and as before afterwards; also a decorator."""
    if sys.platform != "linux" or is_real_time():
        yield
        return
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:  # not permitted: `words` says so
        yield
        return
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


def is_real_time() -> bool:
    """Tell whether this thread has a real-time priority."""
    return sys.platform == "linux" and os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR)


def words() -> str:
    """Say at which priority this thread runs."""
    return "real-time priority" if is_real_time() else "ordinary priority"
