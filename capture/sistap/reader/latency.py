# SPDX-License-Identifier: GPL-2.0-or-later
"""How late a character can be seen: what the adapter adds, and what this process was measured to add."""

from __future__ import annotations

import functools
import os
import pty
import select
import threading
import time
import tty
from contextlib import suppress
from time import monotonic_ns

from sistap.line import UNCERTAINTY_UNKNOWN, LineSettings
from sistap.ports import Adapter
from sistap.reader.contract import READ_SIZE

MEASURE_NS = 200_000_000

# A 16550 raises its interrupt four character times after the last character if its trigger level is not reached.
_FIFO_TIMEOUT_CHARACTERS = 4


def bound(behind: Adapter, settings: LineSettings) -> tuple[int, str]:
    """Bound the time from a character's arrival to its time stamp: ns, and a phrase that says how."""
    own = measured_latency_ns()
    if own >= UNCERTAINTY_UNKNOWN:
        return UNCERTAINTY_UNKNOWN, "uncertainty unknown: there is no pseudo terminal to measure it with"
    held, why, note = 0, "", ""
    if behind.latency_ms is not None:
        held, why = behind.latency_ms * 1_000_000, behind.latency
    elif behind.fifo_trigger is not None and behind.fifo_trigger > 1:
        held, why = (
            _FIFO_TIMEOUT_CHARACTERS * settings.character_ns,
            f"FIFO time-out {_FIFO_TIMEOUT_CHARACTERS} characters",
        )
    elif behind.fifo_trigger is None and not behind.pseudo_terminal:
        note = "; what the adapter adds is not known"
    total = min(held + own, UNCERTAINTY_UNKNOWN)
    parts = f": {why} and {_ms(own)}" if why else ""
    return total, f"uncertainty {_ms(total)}{parts}, measured when the capture started{note}"


def _ms(ns: int) -> str:
    return f"{ns / 1e6:.2f} ms"


@functools.cache
def measured_latency_ns() -> int:
    """Measure how late, at worst, this process sees a character: MEASURE_NS on a pty of its own, once in its life.

    Fewer than a thousand samples: so the bound p99.9 is the largest. UNCERTAINTY_UNKNOWN without a pty.
    """
    try:
        master, slave = pty.openpty()
    except OSError:
        return UNCERTAINTY_UNKNOWN
    try:
        tty.setraw(slave)
        written: list[int] = []
        writer = threading.Thread(target=_write_for_measuring, args=(os.dup(master), written), daemon=True)
        writer.start()
        worst = _worst_delay(slave, written, writer)
        writer.join()
        return worst
    finally:
        os.close(master)
        os.close(slave)


def _write_for_measuring(master: int, written: list[int]) -> None:
    """Write a character now and then, to a descriptor of its own: after a signal the reader does not wait for this."""
    end = monotonic_ns() + MEASURE_NS
    with suppress(OSError), os.fdopen(master, "wb", buffering=0) as file:
        while (now := monotonic_ns()) < end:
            written.append(now)
            file.write(b"\0")
            time.sleep(0.0005)


def _worst_delay(slave: int, written: list[int], writer: threading.Thread) -> int:
    """Read what the writer writes; give the largest time from write to read, in ns."""
    poll = select.poll()
    poll.register(slave, select.POLLIN)
    worst = seen = 0
    while writer.is_alive() or seen < len(written):
        if poll.poll(10):
            count = len(os.read(slave, READ_SIZE))
            worst = max(worst, monotonic_ns() - written[seen])
            seen += count
    return worst
