# SPDX-License-Identifier: GPL-2.0-or-later
"""Whether a machine runs or stands, as its drives say: in some recipes only a part of them runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

from sistap.dissected.accesses.access import Parameter
from sistap.dissected.episodes.readings import ValueReading, code_of, is_running
from sistap.dissected.episodes.standard import FORMS

MOST = 2000  # changes that are remembered
_ENABLED = 0xE000  # bits 15 to 13 of the master control word
_IN_OPERATION = 0xC000  # bits 15 and 14 of the drive status
_SPEED = "S-0-0040"
_REST = 0.01  # of the fastest: slower is at rest
_REST_S = 15.0  # an indexing axis rests for less
_PART = 3  # a machine runs if one of so many drives runs
_FRESH_S = 60.0  # a diagnosis that is older says less than a speed; a word, less than the other word
_LEAST_S = 5.0  # shorter stops and runs are none


@dataclass
class _Drive:
    """What is known of a drive; None: nothing."""

    words: dict[str, tuple[float, bool]] = field(default_factory=dict)  # what control and status word say, and when
    code: bool | None = None  # of the diagnosis
    code_s: float = 0.0  # when it was read
    speed: bool | None = None
    unit: str = ""  # of the speed
    fastest: float = 0.0
    rest_s: float | None = None  # since when it rests
    was: bool | None = None  # whether it ran when it was last looked at

    def is_running(self, now_s: float) -> bool | None:
        """Tell it by what says it best. A panel may read diagnoses only now and then."""
        if self.words:
            newest_s = max(said_s for said_s, _ in self.words.values())
            return all(running for said_s, running in self.words.values() if newest_s - said_s < _FRESH_S)
        is_fresh = self.speed is None or now_s - self.code_s < _FRESH_S
        return self.code if self.code is not None and is_fresh else self.speed


@dataclass
class Machine:
    """The drives of a bus."""

    is_running: bool | None = None  # None: not known
    changes: list[tuple[float, bool]] = field(default_factory=list)  # since when it runs, or not
    _drives: dict[tuple[str, int], _Drive] = field(default_factory=dict)  # by station and device

    def add(self, now_s: float, parameter: Parameter, said: ValueReading) -> None:
        """Take what a drive says of one of LOOKED_AT."""
        drive = self._drives.setdefault((parameter.station, parameter.device), _Drive())
        since_s = LOOKED_AT[parameter.ident](drive, now_s, parameter.ident, said)
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
        lasting: list[tuple[float, bool]] = []
        ends = [*(since_s for since_s, _ in self.changes[1:]), end_s]
        for (since_s, running), until_s in zip(self.changes, ends, strict=False):
            if until_s - since_s >= _LEAST_S and (not lasting or lasting[-1][1] != running):
                lasting.append((since_s, running))
        ends = [*(since_s for since_s, _ in lasting[1:]), end_s]
        stops = [(since_s, until_s) for (since_s, running), until_s in zip(lasting, ends, strict=False) if not running]
        if stops and lasting[0] == (stops[0][0], False):
            stops[0] = begin_s, stops[0][1]
        return stops if any(running for _, running in lasting) else []


def _word(bits: int, drive: _Drive, now_s: float, ident: str, said: ValueReading) -> float:
    """Take a word. A drive runs if all these bits of it are set."""
    if said.bits is not None:
        drive.words[ident] = now_s, said.bits & bits == bits
    return now_s


def _diagnosis(drive: _Drive, now_s: float, ident: str, said: ValueReading) -> float:
    running = is_running(code_of(ident, said.text))
    if running is not None:
        drive.code, drive.code_s = running, now_s
    return now_s


def _speed(drive: _Drive, now_s: float, _: str, said: ValueReading) -> float:
    """Take a speed."""
    if said.unit != drive.unit:  # its attribute was read: now it has another scale
        drive.unit, drive.fastest = said.unit, 0.0
    speed = abs(said.number or 0.0)
    drive.fastest = max(drive.fastest, speed)
    if not drive.fastest:
        return now_s
    if speed > _REST * drive.fastest:
        drive.rest_s, drive.speed = None, True
        return now_s
    drive.rest_s = now_s if drive.rest_s is None else drive.rest_s
    if now_s - drive.rest_s >= _REST_S:
        drive.speed = False
    return drive.rest_s


_Looks = Callable[[_Drive, float, str, ValueReading], float]  # returns since when it is so
_BY_FORM: Mapping[str, _Looks] = {
    "control_word": partial(_word, _ENABLED),
    "status_word": partial(_word, _IN_OPERATION),
    **dict.fromkeys(("diagnosis", "diagnosis_text"), _diagnosis),
}
LOOKED_AT: Mapping[str, _Looks] = {
    **{ident: _BY_FORM[form] for ident, form in FORMS.items() if form in _BY_FORM},
    _SPEED: _speed,
}
WRITTEN = {ident for ident, form in FORMS.items() if form == "control_word"}  # by a master, in each cycle
