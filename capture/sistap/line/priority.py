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
    if not take_real_time():  # `words` says so
        yield
        return
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


def take_real_time() -> bool:
    """Give this thread real-time priority; tell whether that is permitted."""
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


@contextmanager
def ordinary_children() -> Iterator[None]:
    """Start programs with ordinary priority, whatever this thread has.

    What a thread of real-time priority starts inherits that: a program that is busy would starve all others.
    """
    if sys.platform != "linux" or not is_real_time():
        yield
        return
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


def words() -> str:
    """Say at which priority this thread runs."""
    return "real-time priority" if is_real_time() else "ordinary priority"
