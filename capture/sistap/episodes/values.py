# SPDX-License-Identifier: GPL-2.0-or-later
"""Values that are not as usual: texts and bits that changed, numbers that stepped or drifted."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from sistap.accesses.access import Access, Parameter
from sistap.accesses.listing import MOST
from sistap.episodes.episode import ARROW, Hit
from sistap.episodes.levels import Levels
from sistap.episodes.masters import station_of
from sistap.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.episodes.trend import Trend
from sistap.packets.dissection import Packet, Telegram
from sistap.sis.faults import WRITE
from sistap.wireshark.rows import passes

# Feedback values and the command values that they follow: where the bus carries the command, their difference counts.
FOLLOWS = {"S-0-0040": "S-0-0036", "S-0-0084": "S-0-0080"}
_HOUR_S = 3600.0
_LARGEST = 1e100  # nothing that a drive measures; and squares of it are still numbers
_SHOWN = 40  # characters of a text
_DIAGNOSIS = "S-0-0390"
_STILL = "still so when last read"
_FAULT = re.compile(r"0x0*F[0-9A-F]{3,4}")  # as the drive shows it: F228, F2028; a warning begins with E


@dataclass
class _State:
    """A text that held for a time."""

    value: str
    from_s: float
    to_s: float
    packet: int


@dataclass
class _Followed:
    """What is known of a parameter."""

    levels: Levels
    unit: str = ""
    command: float | None = None  # of what it follows
    is_command_lost: bool = False  # it was written without a reaction: nobody knows whether the drive took it
    states: list[_State] = field(default_factory=list)
    is_written: bool = False


class Values:
    """All of a capture, in bounded memory."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS) -> None:
        """Begin with none."""
        self._thresholds = thresholds
        self._followed: dict[Parameter, _Followed] = {}

    def add(self, packet: Packet) -> Sequence[Parameter]:
        """Take the values in a packet; return the parameters of which a state begins, or a level lasts."""
        begun: list[Parameter] = []
        if packet.is_kept_apart:
            self._lose_commands(packet.interface)
        for telegram in packet.telegrams:
            if telegram.unanswered and telegram.good and passes(WRITE.tests, telegram.columns):
                self._lose_command(packet.interface, telegram)
        for access in packet.accesses:
            is_known = not access.error and access.value and not access.is_raw
            if is_known and self._take(packet, access):
                begun.append(access.parameter)
        return begun

    def _take(self, packet: Packet, access: Access) -> bool:
        """Take a value; tell whether a state begins with it, or a level lasts."""
        followed = self._of(access.parameter)
        if followed is None:
            return False
        followed.unit = access.unit or followed.unit
        followed.is_written |= access.is_write
        if access.is_write:
            self._command(access)
            return False
        if access.number is None or access.value.startswith("0x"):
            return self._state(followed, packet, access.value)
        if abs(access.number) >= _LARGEST or followed.is_command_lost:
            return False
        return followed.levels.add(packet.epoch_s, access.number - (followed.command or 0.0), packet.number)

    def followed(self) -> Iterator[tuple[Parameter, _Followed]]:
        """Yield what is known of each parameter."""
        yield from self._followed.items()

    def _of(self, parameter: Parameter) -> _Followed | None:
        followed = self._followed.get(parameter)
        if followed is None and len(self._followed) < MOST:
            followed = self._followed[parameter] = _Followed(self._levels())
        return followed

    def _levels(self) -> Levels:
        return Levels(self._thresholds)

    def _command(self, access: Access) -> None:
        """Note a command for what follows it. What came before the first command was another quantity."""
        for measured, command in FOLLOWS.items():
            if access.parameter.ident == command and access.number is not None:
                followed = self._of(access.parameter._replace(ident=measured))
                if followed is not None:
                    if followed.command is None:
                        followed.levels = self._levels()
                    followed.command, followed.is_command_lost = access.number, False
                    followed.levels.scale = max(followed.levels.scale, abs(access.number))

    def _lose_commands(self, port: str) -> None:
        """Forget commands: nobody has heard the last ones."""
        for parameter, followed in self._followed.items():
            followed.is_command_lost |= parameter.port == port and followed.command is not None

    def _lose_command(self, port: str, telegram: Telegram) -> None:
        for parameter, followed in self._followed.items():
            is_here = (parameter.port, station_of(parameter)) == (port, telegram.listener)
            if is_here and FOLLOWS.get(parameter.ident) == telegram.columns.get("sis.parameter"):
                followed.is_command_lost = followed.command is not None

    def _state(self, followed: _Followed, packet: Packet, value: str) -> bool:
        """Take a state; tell whether it begins."""
        states = followed.states
        if states and states[-1].value == value:
            states[-1].to_s = packet.epoch_s
            return False
        while states and states[0].to_s < packet.epoch_s - self._thresholds.memory_s:
            del states[0]
        if len(states) > self._thresholds.lively:
            return False
        states.append(_State(value, packet.epoch_s, packet.epoch_s, packet.number))
        return True

    def under_way(self, begun: Iterable[Parameter]) -> Iterator[Hit]:
        """Yield what is not as usual of the last state or level of these."""
        for parameter in begun:
            followed = self._followed[parameter]
            if not followed.is_written:
                states_s = [state.from_s for state in followed.states[-1:]]
                last_s = max([*states_s, followed.levels.began_s])
                found = [*_changes(parameter, followed, self._thresholds.few_levels), *_steps(parameter, followed)]
                yield from (hit._replace(outcome="") for hit in found if hit.from_s >= last_s)

    def finish(self) -> Iterator[Hit]:
        """Yield what was not as usual."""
        for parameter, followed in self._followed.items():
            if not followed.is_written:
                yield from _changes(parameter, followed, self._thresholds.few_levels)
                yield from _steps(parameter, followed)
                yield from _drifts(parameter, followed)


def _changes(parameter: Parameter, followed: _Followed, few_levels: int) -> Iterator[Hit]:
    """Yield states that are not the usual one."""
    states = followed.states
    if not 1 < len(states) <= few_levels * 4:
        return
    spans: dict[str, float] = {}
    for state in states:
        spans[state.value] = spans.get(state.value, 0.0) + state.to_s - state.from_s
    usual = max(spans, key=lambda value: spans[value])
    for before, state, after in zip([states[0], *states], states, [*states[1:], states[-1]], strict=False):
        if state.value != usual:
            was = f"{before.value[:_SHOWN]}{ARROW}" if before is not state else ""
            hit = _hit("changed", parameter, state.packet, state.from_s, max(after.from_s, state.to_s))
            if state is after:
                hit = hit._replace(outcome=_STILL)
            is_fault = parameter.ident == _DIAGNOSIS and _FAULT.fullmatch(state.value)
            hit = hit._replace(detail=f"{was}{'fault ' if is_fault else ''}{state.value[:_SHOWN]}")
            yield hit._replace(severity=Severity.ERROR) if is_fault else hit


def _steps(parameter: Parameter, followed: _Followed) -> Iterator[Hit]:
    command = followed.command
    for level, severity in followed.levels.unusual():
        usual = followed.levels.usual
        hit = _hit("step", parameter, level.packet, level.from_s, level.to_s)
        if level.from_s == followed.levels.began_s:
            hit = hit._replace(outcome=_STILL)
        if command is None:
            detail = f"{_number(level.value)} {followed.unit}, usually {_number(usual)}"
        else:
            where = "below" if level.value < 0 else "above"
            detail = f"{_number(abs(level.value))} {followed.unit} {where} {FOLLOWS[parameter.ident]}"
        yield hit._replace(detail=detail.replace("  ", " "), worst=level.value, severity=severity)


def _drifts(parameter: Parameter, followed: _Followed) -> Iterator[Hit]:
    drift = followed.levels.drift()
    if drift is None:
        return
    points, found = drift
    hit = _hit("drift", parameter, 0, points[0][0], points[-1][0])
    span = f"{_number(points[0][1])}{ARROW}{_number(points[-1][1])} {followed.unit}".rstrip()
    yield hit._replace(detail=_drift(found, followed.unit, span), worst=found.slope * _HOUR_S)


def _drift(found: Trend, unit: str, span: str) -> str:
    likely = f"by chance 1 in {1 / found.chance:.0f}" if found.chance > 1e-6 else "not by chance"
    return f"{found.slope * _HOUR_S:+.3g} {unit}/h, {span} ({likely})"


def _number(value: float) -> str:
    return f"{value:.4g}"


def _hit(kind: str, parameter: Parameter, packet: int, from_s: float, to_s: float) -> Hit:
    topic = str(parameter)
    return Hit(kind, packet, from_s, to_s, station_of(parameter), parameter.ident, port=parameter.port, topic=topic)
