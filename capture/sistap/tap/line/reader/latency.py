# SPDX-License-Identifier: GPL-2.0-or-later
"""How late a character can be seen: the delay of the adapter, and that of this computer."""

from __future__ import annotations

import sys
from typing import NamedTuple

from sistap.tap.line import measurement, ports
from sistap.tap.line.ports import Adapter
from sistap.tap.line.reader.computer import measured_ns
from sistap.tap.line.reader.contract import STEP_MS
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings, in_ms

# A 16550 raises its interrupt at its trigger level, or four character times after the last character. In the first
# case, the first of trigger - 1 characters has waited for trigger - 2 more.
_FIFO_TIMEOUT_CHARACTERS = 4

_SINCE = "" if sys.platform == "win32" else " and ever since"  # by the Computer of a reader


class Known(NamedTuple):
    """What is known before a port is opened: the delay of this computer, and the self-tests."""

    machine_ns: int
    how: str  # "measured when the capture started"
    results: list[measurement.Result]
    notes: tuple[str, ...] = ()


class Bound(NamedTuple):
    """The longest time from a character's arrival to its time stamp: how it comes about, in words, and notes."""

    held_ns: int  # by the adapter, as far as known
    least_ns: int  # by a self-test of the port
    how: str
    notes: tuple[str, ...] = ()

    def ns(self, machine_ns: int) -> int:
        """Return it in ns, with the delay of this computer that holds now."""
        bound_ns = self.held_ns + machine_ns
        if self.least_ns <= bound_ns <= UNCERTAINTY_UNKNOWN:
            return bound_ns
        return min(max(bound_ns, self.least_ns), UNCERTAINTY_UNKNOWN)


def known() -> Known:
    """Take the computer's part from a self-test that holds here, else measure it at once."""
    results, trouble = measurement.load()
    result, misfit = measurement.fitting(results, measurement.MACHINE, measurement.conditions())
    notes = tuple(note for note in (trouble, misfit) if note)
    if result:
        return Known(result.p999_ns, f"measured by selftest on {result.date}{_SINCE}", results, notes)
    return Known(measured_ns(), f"measured when the capture started{_SINCE}", results, notes)


def bound(before: Known, port: str, behind: Adapter, settings: LineSettings) -> Bound:
    """Bound computer and adapter together; a self-test of the port itself can only increase the bound."""
    machine_ns = before.machine_ns
    if machine_ns >= UNCERTAINTY_UNKNOWN:
        return Bound(0, UNCERTAINTY_UNKNOWN, "uncertainty unknown: there is no pseudo terminal to measure with")
    place = ports.identity(port, behind)
    result, misfit = measurement.fitting(before.results, place, port_conditions(behind, settings))
    notes = (*before.notes, misfit) if misfit else before.notes
    held_ns, why = _held(behind, settings)
    least_ns = result.p999_ns if result else 0
    if result and least_ns >= held_ns + machine_ns:
        how = f"uncertainty {in_ms(least_ns)}, measured by selftest of the port on {result.date}{_SINCE}"
        return Bound(held_ns, least_ns, how, notes)
    parts = f": {why} and {in_ms(machine_ns)}" if why else ""
    silent = not result and not why and behind.fifo_trigger is None and not behind.pseudo_terminal
    unknown = ""
    if silent:
        unknown = "; what the adapter adds is not known"
        notes = (*notes, _unknown(port))
    return Bound(held_ns, least_ns, f"uncertainty {in_ms(held_ns + machine_ns)}{parts}, {before.how}{unknown}", notes)


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
    character_ns = settings.character_ns if count > 1 else 0
    if not in_time or (count - 1) * character_ns > latency_ns or unseen_ns > sleep_ns + latency_ns:
        latency_ns += unseen_ns
    else:  # several at once: the reader was woken late, and the last character waited for up to one more
        latency_ns += character_ns
    return latency_ns if latency_ns < UNCERTAINTY_UNKNOWN else UNCERTAINTY_UNKNOWN


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
