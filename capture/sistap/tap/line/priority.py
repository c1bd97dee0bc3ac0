# SPDX-License-Identifier: GPL-2.0-or-later
"""The priority of this process: a low real-time priority is enough to keep other programs from delaying it."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

PRIORITY = 1  # the lowest: it goes before ordinary programs only (sched(7))


@contextmanager
def real_time() -> Iterator[None]:
    """Run with real-time priority if permitted, and restore the priority afterwards; also a decorator."""
    if sys.platform != "linux" or is_real_time():
        yield
        return
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    if not take_real_time():  # `words` tells it
        yield
        return
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


def take_real_time() -> bool:
    """Give this thread real-time priority; return whether that is permitted."""
    if sys.platform != "linux":
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:
        return False
    return True


def is_real_time() -> bool:
    """Tell whether this thread has a real-time priority."""
    return sys.platform == "linux" and os.sched_getscheduler(0) in (os.SCHED_FIFO, os.SCHED_RR)


def words() -> str:
    """Describe the priority of this thread."""
    return "real-time priority" if is_real_time() else "ordinary priority"
