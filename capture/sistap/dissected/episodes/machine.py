# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether a machine runs or stands, as its drives say: in some recipes only a part of them runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from sistap.dissected.accesses.access import Parameter
from sistap.dissected.episodes.masters import drive_of
from sistap.dissected.episodes.readings import ValueReading, code_of, is_running
from sistap.dissected.episodes.standard import FORMS

MOST = 2000  # changes that are remembered
_ENABLED = 0xE000  # bits 15 to 13 of the master control word
_IN_OPERATION = 0xC000  # bits 15 and 14 of the drive status
_SPEED = "S-0-0040"
_REST = 0.01  # of the fastest: slower is at rest
_REST_S = 15.0  # an indexing axis rests for less
_PART = 3  # a machine runs if one of so many drives runs
_FRESH_S = 60.0  # an older reading does not count while a fresh one of another parameter is there
_AGAIN = 2  # usual pauses between two readings: after so many, the last one is old
_LEAST_S = 5.0  # shorter stops and runs are none
# Of FORMS, and the speed. The drive itself says it best; its master may write what a drive does not obey.
_BEST_FIRST = ("status_word", "control_word", "diagnosis", "diagnosis_text", "speed")


_Change = tuple[float, bool]  # since when it runs, or not


@dataclass
class _Said:
    """What one parameter of a drive says."""

    running: bool
    at_s: float  # when it was read
    pause_s: float = 0.0  # since the reading before

    def is_fresh(self, now_s: float) -> bool:
        return now_s - self.at_s < max(_FRESH_S, _AGAIN * self.pause_s)


@dataclass
class _Drive:
    """What is known of a drive."""

    said: dict[str, _Said] = field(default_factory=dict)  # by form
    unit: str = ""  # of the speed
    fastest: float = 0.0
    rest_s: float | None = None  # since when it rests
    was: bool | None = None  # whether it ran when it was last looked at

    def take(self, form: str, running: bool | None, now_s: float) -> None:
        """Note what a parameter says; None says nothing."""
        if running is None:
            return
        said = self.said.get(form)
        if said is None:
            self.said[form] = _Said(running, now_s)
        else:
            said.running, said.at_s, said.pause_s = running, now_s, now_s - said.at_s

    def is_running(self, now_s: float) -> bool | None:
        """Tell it by what says it best of all that was read lately; else by the last one. None: not known."""
        newest: _Said | None = None
        for form in _BEST_FIRST:
            said = self.said.get(form)
            if said and said.is_fresh(now_s):
                return said.running
            if said and (newest is None or said.at_s > newest.at_s):
                newest = said
        return newest.running if newest else None


@dataclass
class Machine:
    """The drives of a bus."""

    is_running: bool | None = None  # None: not known
    changes: list[_Change] = field(default_factory=list)
    _drives: dict[tuple[str, int], _Drive] = field(default_factory=dict)

    def add(self, now_s: float, parameter: Parameter, said: ValueReading) -> None:
        """Take what a drive says of one of LOOKED_AT."""
        drive = self._drives.setdefault(drive_of(parameter), _Drive())
        form = LOOKED_AT[parameter.ident]
        running, since_s = _SAY[form](drive, now_s, parameter.ident, said)
        drive.take(form, running, now_s)
        running = drive.is_running(now_s)
        if running != drive.was:
            drive.was = running
            self._count(since_s)

    def _count(self, since_s: float) -> None:
        states = [drive.was for drive in self._drives.values() if drive.was is not None]
        running = _PART * sum(states) >= len(states)
        if running == self.is_running:
            return
        self.is_running = running
        if len(self.changes) < MOST:
            last_s = self.changes[-1][0] if self.changes else since_s
            self.changes.append((max(since_s, last_s), running))

    def stops(self, begin_s: float, end_s: float) -> list[tuple[float, float]]:
        """Return from when to when it stood. Until it is known for the first time, it did as then."""
        lasting: list[_Change] = []
        for (since_s, running), until_s in _with_ends(self.changes, end_s):
            if until_s - since_s >= _LEAST_S and (not lasting or lasting[-1][1] != running):
                lasting.append((since_s, running))
        stops = [(since_s, until_s) for (since_s, running), until_s in _with_ends(lasting, end_s) if not running]
        if stops and lasting[0] == (stops[0][0], False):
            stops[0] = begin_s, stops[0][1]
        return stops if any(running for _, running in lasting) else []


def _with_ends(changes: Sequence[_Change], end_s: float) -> Iterable[tuple[_Change, float]]:
    """Pair each change with the beginning of the next one."""
    return zip(changes, [*(since_s for since_s, _ in changes[1:]), end_s], strict=False)


_Saying = tuple[bool | None, float]  # whether a drive runs, and since when


def _word(bits: int, drive: _Drive, now_s: float, ident: str, said: ValueReading) -> _Saying:
    """Take a word. A drive runs if all these bits of it are set."""
    return None if said.bits is None else said.bits & bits == bits, now_s


def _diagnosis(drive: _Drive, now_s: float, ident: str, said: ValueReading) -> _Saying:
    return is_running(code_of(ident, said.text)), now_s


def _speed(drive: _Drive, now_s: float, ident: str, said: ValueReading) -> _Saying:
    if said.unit != drive.unit:  # its attribute was read: now it has another scale
        drive.unit, drive.fastest = said.unit, 0.0
    speed = abs(said.number or 0.0)
    drive.fastest = max(drive.fastest, speed)
    if not drive.fastest:
        return None, now_s
    if speed > _REST * drive.fastest:
        drive.rest_s = None
        return True, now_s
    drive.rest_s = now_s if drive.rest_s is None else drive.rest_s
    return False if now_s - drive.rest_s >= _REST_S else None, drive.rest_s


_SAY: Mapping[str, Callable[[_Drive, float, str, ValueReading], _Saying]] = {
    "status_word": partial(_word, _IN_OPERATION),
    "control_word": partial(_word, _ENABLED),
    "diagnosis": _diagnosis,
    "diagnosis_text": _diagnosis,
    "speed": _speed,
}
LOOKED_AT = {ident: form for ident, form in FORMS.items() if form in _SAY} | {_SPEED: "speed"}
