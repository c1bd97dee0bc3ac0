# SPDX-License-Identifier: GPL-2.0-or-later
"""The two times between which the characters of a USB transfer were on the line. Nothing narrower is claimed."""

from __future__ import annotations

from collections.abc import Iterator

from sistap.imports.source import SENT
from sistap.imports.usb_transfers import Transfer
from sistap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings, Read

FRAME_NS = 1_000_000  # the host asks at least once in a frame (USB 2.0 chapter 5.8)
# USBPcap takes the time from the Windows clock, which advances in ticks. A stamp is too early by up to a tick.
WINDOWS_TICK_NS = 15_625_000
_MS = 1_000_000


def latest_ns(transfer: Transfer) -> int:
    """Return the latest time at which a transfer can have been stamped."""
    return transfer.time_ns + (WINDOWS_TICK_NS if transfer.by_windows else 0)


class Arrivals:
    """An upper bound on how long the contents of a completed transfer were in the adapter.

    With a latency timer (FTDI), a transfer comes at least once per period, even an empty one, as long as the host asks.
    If the host did not ask, the adapter collected since it was last emptied.
    """

    def __init__(self) -> None:
        """Start with an adapter of which nothing has been seen."""
        self._emptied_ns: int | None = None
        self._asked_ns: int | None = None

    def ask(self, transfer: Transfer) -> None:
        """Note that the host asks for characters."""
        self._asked_ns = transfer.time_ns

    def waited_ns(self, transfer: Transfer, latency_ms: int | None, *, is_full: bool) -> int:
        """Return that bound in ns for a completed transfer. `latency_ms` is None for an adapter without a timer.

        `is_full`: the transfer has no room for more, so the adapter may not be empty after it.
        """
        waited_ns = FRAME_NS if latency_ms is None else latency_ms * _MS
        if latency_ms is not None and self._emptied_ns is not None:
            collected_ns = max(transfer.time_ns - self._emptied_ns, 0)
            was_asked = self._asked_ns is not None and transfer.time_ns - self._asked_ns >= FRAME_NS
            waited_ns = min(waited_ns, collected_ns) if was_asked else collected_ns
        if not is_full:
            self._emptied_ns = transfer.time_ns
        return waited_ns + FRAME_NS + latest_ns(transfer) - transfer.time_ns


class Departures:
    """When characters that were handed to the adapter have left it: one after the other, once the line is free."""

    def __init__(self) -> None:
        self._free_ns = (0, 0)  # earliest and latest

    def sent(
        self, submitted: Transfer, completed: Transfer | None, flags: bytes, settings: LineSettings
    ) -> Iterator[Read]:
        """Yield each character when it has left; `flags` has one byte for each character.

        None begins before it was handed over. When the transfer is completed, all are in the adapter. Without a
        completion nobody knows.
        """
        earliest_ns = max(submitted.time_ns, self._free_ns[0])
        begun_ns = max(latest_ns(completed or submitted) + FRAME_NS, self._free_ns[1])
        uncertainty_ns = bounded(begun_ns - earliest_ns) if completed else UNCERTAINTY_UNKNOWN
        character_ns = settings.character_ns
        for number, flag in enumerate(flags):
            time_ns = begun_ns + (number + 1) * character_ns
            yield Read(SENT, time_ns, submitted.data[number : number + 1], bytes([flag]), uncertainty_ns, settings)
        self._free_ns = (earliest_ns + len(flags) * character_ns, begun_ns + len(flags) * character_ns)


def bounded(uncertainty_ns: int) -> int:
    """Return an uncertainty that fits into a record; a larger one becomes unknown."""
    return uncertainty_ns if 0 <= uncertainty_ns < UNCERTAINTY_UNKNOWN else UNCERTAINTY_UNKNOWN
