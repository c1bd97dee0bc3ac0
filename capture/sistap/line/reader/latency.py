# SPDX-License-Identifier: GPL-2.0-or-later
"""How late a character can be seen: the delay of the adapter, and the measured delay of this computer.

The computer is measured with characters through a pseudo terminal, or through a socket where there is none.
"""

from __future__ import annotations

import functools
import random
import socket
import sys
import threading
import time
from array import array
from contextlib import suppress
from typing import NamedTuple

from sistap.line import measurement, ports
from sistap.line.clock import monotonic_ns
from sistap.line.ports import Adapter
from sistap.line.reader.contract import STEP_MS
from sistap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings

_PATIENCE_S = 1.0  # longest wait for a byte


def through_socket(duration_ns: int) -> array[int]:
    """Send bytes one by one through a socket of our own; return the time of each in ns. May raise OSError."""
    reading, writing = socket.socketpair()
    with reading, writing:
        reading.settimeout(_PATIENCE_S)
        for end in (reading, writing):
            with suppress(OSError):  # not TCP
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        written = array("q")
        writer = threading.Thread(target=_write, args=(writing, written, monotonic_ns() + duration_ns), daemon=True)
        writer.start()
        delays = array("q")
        while data := reading.recv(4096):
            now_ns = monotonic_ns()
            delays.extend(now_ns - sent for sent in written[len(delays) : len(delays) + len(data)])
        writer.join()
    return delays


def _write(writing: socket.socket, written: array[int], end_ns: int) -> None:
    """Write a byte now and then at random times; then end the connection."""
    with suppress(OSError):
        while (now_ns := monotonic_ns()) < end_ns:
            written.append(now_ns)
            writing.send(b"@")
            time.sleep(random.uniform(0.0002, 0.0008))
        writing.shutdown(socket.SHUT_WR)


MEASURE_NS = 200_000_000

# A 16550 raises its interrupt at its trigger level, or four character times after the last character. In the first
# case, the first of trigger - 1 characters has waited for trigger - 2 more.
_FIFO_TIMEOUT_CHARACTERS = 4


class Known(NamedTuple):
    """What is known before a port is opened: the delay of this computer, and the self-tests."""

    machine_ns: int
    how: str  # "measured when the capture started"
    results: list[measurement.Result]
    notes: tuple[str, ...] = ()


class Bound(NamedTuple):
    """The longest time from a character's arrival to its time stamp in ns, a phrase for its source, and notes."""

    ns: int
    how: str
    notes: tuple[str, ...] = ()


def known() -> Known:
    """Take the computer's part from a self-test that holds here, else measure it for MEASURE_NS."""
    results, trouble = measurement.load()
    result, misfit = measurement.fitting(results, measurement.MACHINE, measurement.conditions())
    notes = tuple(note for note in (trouble, misfit) if note)
    if result:
        return Known(result.p999_ns, f"measured by selftest on {result.date}", results, notes)
    return Known(measured_latency_ns(), "measured when the capture started", results, notes)


def bound(before: Known, port: str, behind: Adapter, settings: LineSettings) -> Bound:
    """Bound computer and adapter together; a self-test of the port itself can only increase the bound."""
    if before.machine_ns >= UNCERTAINTY_UNKNOWN:
        return Bound(UNCERTAINTY_UNKNOWN, "uncertainty unknown: there is no pseudo terminal to measure with")
    place = ports.identity(port, behind)
    result, misfit = measurement.fitting(before.results, place, port_conditions(behind, settings))
    notes = (*before.notes, misfit) if misfit else before.notes
    held_ns, why = _held(behind, settings)
    total_ns = min(held_ns + before.machine_ns, UNCERTAINTY_UNKNOWN)
    if result and result.p999_ns >= total_ns:
        return Bound(
            result.p999_ns,
            f"uncertainty {_ms(result.p999_ns)}, measured by selftest of the port on {result.date}",
            notes,
        )
    parts = f": {why} and {_ms(before.machine_ns)}" if why else ""
    silent = not result and not why and behind.fifo_trigger is None and not behind.pseudo_terminal
    unknown = ""
    if silent:
        unknown = "; what the adapter adds is not known"
        notes = (*notes, _unknown(port))
    return Bound(total_ns, f"uncertainty {_ms(total_ns)}{parts}, {before.how}{unknown}", notes)


def uncertainty_ns(  # noqa: PLR0913 - everything known about a read
    latency_ns: int,
    settings: LineSettings,
    count: int,
    unseen_ns: int,
    *,
    in_time: bool,
    sleep_ns: int = STEP_MS * 1_000_000,
) -> int:
    """Bound how long characters had waited; for `unseen_ns` nobody had read, or the reader slept until they came.

    The latency is no bound in three cases. They were there before the read began. That many characters take longer than
    the latency. Or the sleep exceeded `sleep_ns`, so the process was suspended. Then their arrival is unknown.
    """
    character_ns = settings.character_ns
    if not in_time or (count - 1) * character_ns > latency_ns or unseen_ns > sleep_ns + latency_ns:
        return min(latency_ns + unseen_ns, UNCERTAINTY_UNKNOWN)
    # Several at once: the reader was woken late, and the last character waited for up to one more.
    return min(latency_ns + (character_ns if count > 1 else 0), UNCERTAINTY_UNKNOWN)


def port_conditions(behind: Adapter, settings: LineSettings) -> measurement.Conditions:
    """Return what a self-test of a port depends on; the adapter must be tuned."""
    return measurement.conditions(adapter=str(behind), line=f"{settings.baud} Bd {settings.format}")


def held_by_fifo_ns(trigger: int, settings: LineSettings) -> int:
    """Return how long a 16550 keeps a character until its interrupt, at most, in ns."""
    return (trigger - 2 + _FIFO_TIMEOUT_CHARACTERS) * settings.character_ns


def _held(behind: Adapter, settings: LineSettings) -> tuple[int, str]:
    """Return how long the adapter holds characters back, as far as known, in ns, and why."""
    if behind.latency_ms is not None:
        return behind.latency_ms * 1_000_000, behind.latency
    if behind.fifo_trigger is not None and behind.fifo_trigger > 1:
        return held_by_fifo_ns(behind.fifo_trigger, settings), f"FIFO trigger {behind.fifo_trigger}"
    return 0, ""


def _unknown(port: str) -> str:
    return (
        f"{port}: the delay of its adapter is not known and not in the uncertainty; off the bus, "
        f"with its wires joined, `sistap selftest -i {port} --transmit` measures it"
    )


def _ms(ns: int) -> str:
    return f"{ns / 1e6:.2f} ms"


@functools.cache
def measured_latency_ns() -> int:
    """Measure, once for MEASURE_NS, how late this process sees a character in the worst case.

    There are fewer than a thousand samples, so the bound p99.9 is the largest. UNCERTAINTY_UNKNOWN if it cannot be
    measured.
    """
    if sys.platform == "win32":
        with suppress(OSError):
            return max(through_socket(MEASURE_NS), default=UNCERTAINTY_UNKNOWN)
        return UNCERTAINTY_UNKNOWN
    from sistap.line.reader import delay

    try:
        return max(delay.through_pty(MEASURE_NS))
    except OSError:
        return UNCERTAINTY_UNKNOWN
