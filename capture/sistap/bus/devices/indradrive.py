# SPDX-License-Identifier: GPL-2.0-or-later
"""An IndraDrive: a drive with commands that switch between operating and parameter mode, and with a status word."""

from __future__ import annotations

from sistap.bus.devices.drive import Drive
from sistap.bus.devices.parameters import PARAMETER_MODE, Parameter
from sistap.bus.devices.phases import OPERATING_MODE
from sistap.bus.devices.procedure import ENABLED, SET

# The commands that switch the phase, as 0x1D does.
_LEVELS = {"S-0-0420": PARAMETER_MODE, "S-0-0422": OPERATING_MODE}

# The status word, as a known client reads it: ready in bits 15 and 14, error in bit 13, drive halt in bit 4.
_STATUS_WORD = "P-0-0115"
_NOT_READY, _READY, _WITH_TORQUE = 0x0000, 0x8000, 0xC000
_ERROR, _HALTED = 0x2000, 0x0010
_ON, _NO_HALT = 0xC000, 0x2000  # of the master control word


class IndraDrive(Drive):
    """The same velocity drive, with parameters of IndraDrive."""

    def refresh(self, now_ns: int) -> None:
        """Update the status word as well."""
        super().refresh(now_ns)
        self._set(_STATUS_WORD, self._status(now_ns).to_bytes(2, "little"))

    def written(self, parameter: Parameter, now_ns: int) -> None:
        """Switch the phase if a command demands it; an obstacle makes the command fail."""
        super().written(parameter, now_ns)
        target = _LEVELS.get(parameter.ident)
        started = int.from_bytes(parameter.data, "little") == SET | ENABLED
        if target is not None and started and parameter.procedure:
            parameter.procedure.fails = not self.phases.command(target, now_ns)

    def _status(self, now_ns: int) -> int:
        if self.error:
            return _NOT_READY | _ERROR
        if self.phases.at(now_ns) != OPERATING_MODE:
            return _NOT_READY
        if self._control_word & _ON != _ON:
            return _READY
        return _WITH_TORQUE | (0 if self._control_word & _NO_HALT else _HALTED)
