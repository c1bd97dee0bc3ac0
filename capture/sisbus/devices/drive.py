# SPDX-License-Identifier: GPL-2.0-or-later
"""Drives: how their parameters act on them, and how they act on their parameters."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable

from sisbus.devices.device import Device
from sisbus.devices.parameters import ENABLED, PARAMETER_MODE, SET, Parameter, as_list, ident, number, text
from sisbus.devices.phases import DRIVE_ENABLED, OPERATING_MODE, WRONG_PHASE

_MS = 1_000_000
_ENABLE = 0xE000  # bits 13 to 15 of the master control word: halt off, enable, on
_COMMUNICATION_ERROR = 1 << 12  # of class 1 diagnostics

_MASTER_CONTROL_WORD = "S-0-0134"
_CLASS_1_DIAGNOSTICS = "S-0-0011"
_INVALID_LISTS = ("S-0-0021", "S-0-0022")
_ERROR_MEMORY = "P-0-0192"
_BASIC_LOAD = "S-0-0262"
_RESET = "S-0-0099"

# Lists of ident numbers that a drive makes itself, and their contents.
_IDENT_LISTS: dict[str, Callable[[Parameter], bool]] = {
    "S-0-0017": lambda parameter: True,
    "S-0-0025": lambda parameter: parameter.attribute.is_command,
    "S-0-0192": lambda parameter: not parameter.attribute.is_command and not parameter.attribute.is_read_only,
}

# Diagnostic number and message: for each phase, and for the error that this drive can have.
_DIAGNOSES = {
    0: (0xA000, "A000 Communication phase 0"),
    1: (0xA001, "A001 Communication phase 1"),
    2: (0xA002, "A002 Communication phase 2"),
    3: (0xA003, "A003 Communication phase 3"),
    4: (0xA101, "A101 Drive in velocity mode"),
}
_TMAS_EXCEEDED = (0xF401, "F401 Master control word missing")


class Drive(Device):
    """A velocity drive."""

    def __init__(
        self,
        parameters: Iterable[Parameter],
        seed: str,
        modulo: dict[str, str] | None = None,
        tmas_ms: Callable[[], int | None] = lambda: None,
    ) -> None:
        """Switch it on; `seed` decides how its feedback values scatter.

        While it is enabled, the master control word must come at least every `tmas_ms` (chapter 6, 0x03).
        """
        super().__init__(parameters, modulo)
        self._random = random.Random(seed)
        self._tmas_ms = tmas_ms
        self._control_word_ns = 0
        self.error: tuple[int, str] | None = None
        self._defaults = {number: parameter.data for number, parameter in self.parameters.items()}
        for name, belongs in _IDENT_LISTS.items():
            self._set(name, _ident_list(filter(belongs, self.parameters.values())))

    @property
    def enabled(self) -> bool:
        """Tell whether the master control word allows it to move."""
        return self._control_word & _ENABLE == _ENABLE

    @property
    def _control_word(self) -> int:
        word = self.named(_MASTER_CONTROL_WORD)
        return int.from_bytes(word.data, "little") if word else 0

    def hindrance(self, target: int, now_ns: int) -> int | None:
        """Return what prevents another phase (fig. 8-49).

        Invalid parameters have no code of their own there: the phase is wrong, and S-0-0022 lists them.
        """
        self.refresh(now_ns)
        if self.enabled:
            return DRIVE_ENABLED
        if target == OPERATING_MODE and not all(parameter.valid for parameter in self.parameters.values()):
            return WRONG_PHASE
        return None

    def refresh(self, now_ns: int) -> None:
        """Check for the master control word; update diagnosis and lists of invalid data."""
        self._watch(now_ns)
        diagnostic_number, message = self.error or _DIAGNOSES[self.phases.at(now_ns)]
        self._set("S-0-0095", text(message))
        self._set("S-0-0390", number(diagnostic_number))
        invalid = _ident_list(parameter for parameter in self.parameters.values() if not parameter.valid)
        for name in _INVALID_LISTS:
            self._set(name, invalid)

    def written(self, parameter: Parameter, now_ns: int) -> None:
        """Move, or execute a command."""
        if parameter.ident == "S-0-0036":
            self._move(int.from_bytes(parameter.data, "little", signed=True))
        elif parameter.ident == _MASTER_CONTROL_WORD:
            self._control_word_ns = now_ns
        elif parameter.ident == _RESET and parameter.data == b"\x03\x00":
            self.error = None
            self._set(_CLASS_1_DIAGNOSTICS, bytes(2))
        elif parameter.ident == _BASIC_LOAD and parameter.data == b"\x03\x00":
            self._load_defaults()

    def restart(self) -> None:
        """Stand still without an error."""
        super().restart()
        self.error = None
        self._set(_MASTER_CONTROL_WORD, bytes(2))

    def _watch(self, now_ns: int) -> None:
        """Stop if the master control word is late while the drive may move (chapter 6, Tmas)."""
        tmas_ms = self._tmas_ms()
        if tmas_ms is None or not self.enabled or now_ns - self._control_word_ns <= tmas_ms * _MS:
            return
        self._set(_MASTER_CONTROL_WORD, bytes(2))
        self._set(_CLASS_1_DIAGNOSTICS, _COMMUNICATION_ERROR.to_bytes(2, "little"))
        self.error = _TMAS_EXCEEDED
        memory = self.named(_ERROR_MEMORY)
        if memory:
            newest = self.error[0].to_bytes(4, "little")
            memory.data = memory.data[:4] + (newest + memory.data[4:])[: len(memory.data) - 4]

    def _move(self, velocity: int) -> None:
        """Follow a command velocity (0.0001 rpm) approximately, as a motor does."""
        feedback, position = self.named("S-0-0040"), self.named("S-0-0051")
        if feedback:
            feedback.data = number(velocity + self._random.randint(-15_000, 15_000))
        if position:
            moved = int.from_bytes(position.data, "little", signed=True) + velocity // 40
            position.data = number(moved % 3_600_000)  # one turn in 0.0001 degrees

    def _load_defaults(self) -> None:
        for parameter in self.parameters.values():
            if _IDENT_LISTS["S-0-0192"](parameter):
                parameter.data, parameter.valid = self._defaults[ident(parameter.ident)], True

    def _set(self, name: str, data: bytes) -> None:
        parameter = self.named(name)
        if parameter:
            parameter.data = data


def _ident_list(parameters: Iterable[Parameter]) -> bytes:
    return as_list(b"".join(ident(parameter.ident)[1:] for parameter in parameters if ident(parameter.ident)[0] == 0))


# -- An IndraDrive: commands that switch between operating and parameter mode, and a status word ---------------------

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
