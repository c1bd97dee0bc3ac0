# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a COM port of Windows."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

from sistap.line import ports
from sistap.line.clock import CLOCK
from sistap.line.clocks import STEADY, monotonic_ns
from sistap.line.ports import Adapter
from sistap.line.reader import latency
from sistap.line.reader.comm import CommPort, flags
from sistap.line.reader.contract import READ_SIZE, STEP_MS, PortError, PortLost
from sistap.line.reader.listening import closed_serial, configure
from sistap.line.reader.trouble import lost_text, url_trouble
from sistap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings, Read
from sistap.terminal.advice import advice

# The longest sleep without suspension: Windows may add a tick of its clock (15.6 ms) to each.
_SLEEP_NS = (STEP_MS + 16) * 1_000_000


class WindowsReader:
    """Reads through Windows itself, which reports line errors for a whole read, not for a character."""

    def __init__(
        self,
        port: str,
        settings: LineSettings,
        line: int = 0,
        behind: Adapter | None = None,
        comm: Callable[..., CommPort] = CommPort,
    ) -> None:
        """Open the port. May raise PortError. `behind` comes from the registry."""
        self.name = port
        self.settings = settings
        self.line = line
        self._behind = behind or ports.adapter(port)
        self.adapter = str(self._behind) if self._behind.name else port
        self._known = None if self._behind.latency_ms is None else latency.known()  # before the port is open
        self._latency_ns, how, self.notes = self._bound()
        self.timing = f"{how}; {STEADY}"
        self._emptied_ns = monotonic_ns()  # everything unread came after this
        try:
            self._device = closed_serial(port, settings)
            self._device.open()
            self._port = comm(self._device)
        except (OSError, ValueError) as error:
            raise PortError(url_trouble(port, settings, error)) from error
        self._is_lost = False

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""
        end_ns = monotonic_ns() + int(timeout_s * 1e9)
        try:
            while not self._is_lost:
                asked_ns = monotonic_ns()
                waiting = self._port.waiting()
                in_time = not waiting
                if in_time:
                    self._emptied_ns = asked_ns
                if in_time and not timeout_s:
                    return None
                if data := self._port.take(waiting):
                    return self._received(data, in_time=in_time)
                if monotonic_ns() >= end_ns:
                    return None
        except OSError:
            self._is_lost = True
        raise PortLost(lost_text(self.name, pseudo_terminal=False))

    def _received(self, data: bytes, *, in_time: bool) -> Read:
        """Add what came meanwhile: an error that Windows reports after a read may belong to these characters."""
        now_ns = monotonic_ns()
        since_ns = self._emptied_ns
        with suppress(OSError):  # what came before the port was lost is kept
            while len(data) < READ_SIZE:
                self._emptied_ns = monotonic_ns()
                if not (waiting := self._port.waiting()):
                    break
                data += self._port.take(waiting)
                now_ns = monotonic_ns()
        uncertainty_ns = latency.uncertainty_ns(
            self._latency_ns, self.settings, len(data), now_ns - since_ns, in_time=in_time, sleep_ns=_SLEEP_NS
        )
        marked = flags(self._port.errors(), len(data))
        return Read(self.line, CLOCK.wall_ns(now_ns), data, marked, uncertainty_ns, self.settings)

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from now on. PortError if the port does not support them: then the old settings
        stay.
        """
        try:
            configure(self._device, settings)
        except (OSError, ValueError) as error:
            with suppress(OSError, ValueError):
                configure(self._device, self.settings)
            raise PortError(url_trouble(self.name, settings, error)) from error
        finally:
            self._port.prepare()
        self.settings = settings
        self._latency_ns = self._bound()[0]

    def close(self) -> None:
        """Release the port."""
        self._port.close()

    def _bound(self) -> tuple[int, str, tuple[str, ...]]:
        """Return how late a character can be seen in ns, a phrase for its source, and messages for the user."""
        behind = self._behind
        if self._known is None or behind.latency_ms is None:
            note = f"{self.name}: without a known uncertainty no verdict on its times is possible: use an FTDI adapter"
            return UNCERTAINTY_UNKNOWN, "Windows does not report how exact its times are", (note,)
        bound = latency.bound(self._known, self.name, behind, self.settings)
        if behind.latency_ms <= 1:
            return bound
        cure = advice("win32").latency_timer.format(name=behind.name or self.name)
        note = f"{self.name}: its latency timer is {behind.latency_ms} ms, so times are up to that late: {cure}"
        return bound.ns, bound.how, (note, *bound.notes)
