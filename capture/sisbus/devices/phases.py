# SPDX-License-Identifier: GPL-2.0-or-later
"""Services 0x12 and 0x1D: the phase of a drive, or of all drives of a control (IF02 chapters 8.4 and 8.5)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from sisbus.devices.parameters import PARAMETER_MODE
from sisbus.service import Request, Service, ServiceFailed, Status

OPERATING_MODE = 4
_MS = 1_000_000

# Codes of fig. 8-49.
WRONG_PHASE = 0x8004
STILL_ACTIVE = 0xD005
DRIVE_ENABLED = 0xD006
MASTER_AXIS_TURNS = 0xD007


class _Switch(NamedTuple):
    before: int
    target: int
    begin_ns: int
    end_ns: int
    failure: int | None
    busy: bool = True  # whether parameters are inaccessible meanwhile


class Phases:
    """The phase and its switching, which takes time; service 0x12 asks for its progress."""

    def __init__(self, phase: int, takes_ms: int, hindrance: Callable[[int, int], int | None]) -> None:
        """Start in a phase.

        `hindrance` returns the code of fig. 8-49 that prevents a phase at a time in ns; None: nothing does.
        """
        self._power_on_phase = phase
        self._takes_ns = takes_ms * _MS
        self._hindrance = hindrance
        self.on_switch: list[Callable[[], None]] = []  # called when a switching begins
        self.restart()
        self.read_service = Service(0, 0, self._read)
        self.switch_service = Service(0, 1, self._begin)

    def restart(self) -> None:
        """Return to the phase after power-on."""
        self._switch = _Switch(self._power_on_phase, self._power_on_phase, 0, 0, None)

    def at(self, now_ns: int) -> int:
        """Return the phase; between 2 and 4 it is 3 for the second half of the time."""
        switch = self._switch
        if now_ns >= switch.end_ns:
            return switch.before if switch.failure else switch.target
        late = now_ns - switch.begin_ns >= (switch.end_ns - switch.begin_ns) // 2
        return 3 if late and switch.target == OPERATING_MODE and switch.before != OPERATING_MODE else switch.before

    def switching(self, now_ns: int) -> bool:
        """Tell whether the phase is being switched."""
        return now_ns < self._switch.end_ns

    def busy(self, now_ns: int) -> bool:
        """Tell whether the switching blocks access to the parameters."""
        return self.switching(now_ns) and self._switch.busy

    def command(self, target: int, now_ns: int) -> bool:
        """Switch for a procedure command; return False if something prevents it.

        The parameters stay accessible: a master asks there whether the command has been executed.
        """
        before = self.at(now_ns)
        if before == target and not self.switching(now_ns):
            return True
        if self.switching(now_ns) or self._hindrance(target, now_ns) is not None:
            return False
        self._switch = _Switch(before, target, now_ns, now_ns + self._takes_ns, None, busy=False)
        self._tell()
        return True

    def _tell(self) -> None:
        for listener in self.on_switch:
            listener()

    def _read(self, request: Request) -> bytes:
        """Return the phase, or why the last switching failed: a master that missed it can ask again."""
        if self._switch.failure and not self.switching(request.now_ns):
            raise self._failed(self._switch.failure, request.now_ns)
        return bytes([self.at(request.now_ns)])

    def _begin(self, request: Request) -> bytes:
        """Acknowledge the command, not the switching: a later request returns the drives' objections."""
        target, now_ns = request.body[0], request.now_ns
        if target not in (PARAMETER_MODE, OPERATING_MODE):
            raise self._failed(WRONG_PHASE, now_ns)
        if self.switching(now_ns):
            raise self._failed(STILL_ACTIVE, now_ns)
        before = self.at(now_ns)
        failure = self._hindrance(target, now_ns) if target != before else None
        end_ns = now_ns + (self._takes_ns if target != before else 0)
        self._switch = _Switch(before, target, now_ns, end_ns, failure)
        if target != before:
            self._tell()
        return b""

    def _failed(self, code: int, now_ns: int) -> ServiceFailed:
        return ServiceFailed(bytes([self.at(now_ns)]) + code.to_bytes(2, "little"), Status.PHASE_ERROR)
