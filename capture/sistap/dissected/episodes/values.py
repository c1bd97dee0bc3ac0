# SPDX-License-Identifier: GPL-2.0-or-later
"""Values that are not as usual: states that changed, numbers that stepped or drifted, each beside its like.

Levels are learned apart for a machine that runs and one that stands.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import MOST
from sistap.dissected.episodes.diagnoses import STILL
from sistap.dissected.episodes.episode import ARROW, Hit
from sistap.dissected.episodes.levels import Levels
from sistap.dissected.episodes.masters import station_of
from sistap.dissected.episodes.readings import RAW, ValueReading, raw_number
from sistap.dissected.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.dissected.episodes.standard import FOLLOWS, FORMS
from sistap.dissected.episodes.trend import Trend
from sistap.dissected.packets.dissection import Packet, Telegram
from sistap.dissected.wireshark.rows import passes
from sistap.tap.sis.faults import WRITE

_COMMANDS = {command: measured for measured, command in FOLLOWS.items()}
_HOUR_S = 3600.0
_LARGEST = 1e100  # nothing that a drive measures; and squares of it are still numbers
_SHOWN = 40  # characters of a text
_FEW_VALUES = 8  # a number with no more of them is a state
_READ_AGAIN = 4  # times as many reads as values
_RISES = 20  # of a value that never falls, but to its beginning: a counter
_WRAPPED = 0.7  # of its range: a counter that falls so far begins anew
_FALLS = 0.01  # of its rises: fewer are such wraps, or somebody has reset it
_TEMPERATURE = re.compile(r"(°|deg ?)[CF]|K")
_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?(e[-+]?\d+)?")
_NEAR, _REST = 0.1, 0.01  # of the command; of the greatest one: so much moves what rests
BELOW = "below"  # how a value is apart from its command
_KNOWN = 50  # readings until it is known to follow
APART_S, _APART = 20.0, 8  # seconds and readings: shorter is a ramp
_FOLLOWS_USUALLY = 0.9  # of the readings near the command
_CHATTERS, _CHATTER_S = 6, 300.0  # changes within a time, of a state that otherwise rests


@dataclass
class _State:
    """A text that held for a time."""

    value: str
    from_s: float
    to_s: float
    packet: int


@dataclass
class _Beside:
    """A value beside the command that it follows."""

    command: int | None = None  # bytes as a number: both have the same scale (S-0-0044 to S-0-0046)
    greatest: int = 0  # command until now
    near: int = 0
    far: int = 0  # until now, without those in a row
    row: int = 0
    since_s: float | None = None  # since when it is far
    packet: int = 0


@dataclass
class _Followed:
    """What is known of a parameter."""

    levels: Levels  # while the machine runs, or if nobody knows
    stopped: Levels
    unit: str = ""
    command: float | None = None  # of what it follows
    is_command_lost: bool = False  # it was written without a reaction: nobody knows whether the drive took it
    states: list[_State] = field(default_factory=list)
    values: set[str] = field(default_factory=set)  # different ones, while they are few
    reads: int = 0
    is_written: bool = False
    last: float | None = None
    rises: int = 0
    falls: int = 0
    low: float = math.inf
    high: float = -math.inf
    beside: _Beside = field(default_factory=_Beside)

    @property
    def is_state(self) -> bool:
        """Tell whether it takes few values."""
        return len(self.values) <= _FEW_VALUES

    @property
    def is_known_state(self) -> bool:
        """Tell whether they were read again and again. Three numbers that differ say nothing."""
        return self.last is None or self.reads >= _READ_AGAIN * len(self.values)

    @property
    def is_counter(self) -> bool:
        """Tell whether it only rises. A machine that warms up is no counter."""
        is_rising = self.rises >= _RISES and self.falls <= _FALLS * self.rises
        return is_rising and not _TEMPERATURE.search(self.unit)

    def lose_command(self) -> None:
        """Forget what is commanded: values are compared again from the next command on."""
        self.is_command_lost |= self.command is not None
        self.beside.command = None


class Values:
    """All of a capture, in bounded memory."""

    def __init__(
        self, thresholds: Thresholds = THRESHOLDS, since_s: float = -math.inf, before: Values | None = None
    ) -> None:
        """Begin with none. A drift never begins before `since_s`; one that a good capture has is usual."""
        self._thresholds = thresholds
        self._since_s = since_s
        self._drifting = before.drifting() if before else set()
        self._followed: dict[Parameter, _Followed] = {}
        self._raw: set[Parameter] = set()

    @property
    def undescribed(self) -> int:
        """Return the number of parameters of which only bytes are known."""
        return len(self._raw)

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Forget commands that the drive perhaps did not take."""
        if packet.is_unheard:
            self._lose_commands()
        for telegram in packet.telegrams:
            if telegram.unanswered and telegram.good and passes(WRITE.tests, telegram.columns):
                self._lose_command(telegram)
        return ()

    def take(self, packet: Packet, access: Access, said: ValueReading, *, is_running: bool | None) -> bool:
        """Take a reading; tell whether a state begins with it, or a level lasts."""
        parameter = access.parameter
        followed = self._of(parameter)
        if followed is None:
            return False
        if followed.unit and followed.unit != said.unit and RAW in (followed.unit, said.unit):
            beside = followed.beside  # in bytes, as ever
            followed = self._followed[parameter] = self._begin()  # its attribute was read: now it has another scale
            followed.beside = beside
        followed.unit = said.unit
        if access.is_raw and parameter.ident not in FORMS:
            self._raw.add(parameter)
        elif self._raw:
            self._raw.discard(parameter)
        if parameter.ident in _COMMANDS:
            self._command(access, said)
        if access.is_write:
            followed.is_written = True
            return False
        followed.reads += 1
        is_new = len(followed.values) <= _FEW_VALUES and self._state(followed, packet, said.text)
        if said.number is None:
            return is_new
        if abs(said.number) >= _LARGEST or followed.is_command_lost:
            return is_new
        _rise(followed, said.number)
        levels = followed.stopped if is_running is False else followed.levels
        lasts = levels.add(packet.epoch_s, said.number - (followed.command or 0.0), packet.number)
        return is_new or lasts

    def judge(self, packet: Packet, access: Access, said: ValueReading, *, is_running: bool | None) -> Iterable[Hit]:
        """Return what is surely wrong with a number: beyond the limits that the drive told, or far from its command."""
        if access.is_write:
            return ()
        has_limits = said.number is not None and (access.minimum or access.maximum)
        hits = [*_beyond(packet, access, said.number or 0.0)] if has_limits else []
        if is_running is not False:
            followed = self._followed.get(access.parameter)
            raw = raw_number(access)
            if followed and raw is not None and followed.beside.command is not None:
                hits += _apart(followed.beside, packet, access.parameter, raw, followed.beside.command)
        return hits

    def followed(self) -> Iterator[tuple[Parameter, _Followed]]:
        """Yield what is known of each parameter."""
        yield from self._followed.items()

    def _of(self, parameter: Parameter) -> _Followed | None:
        followed = self._followed.get(parameter)
        if followed is None and len(self._followed) < MOST:
            followed = self._followed[parameter] = self._begin()
        return followed

    def _begin(self) -> _Followed:
        return _Followed(Levels(self._thresholds), Levels(self._thresholds))

    def _command(self, access: Access, said: ValueReading) -> None:
        """Note a command for what follows it. What came before the first command was another quantity."""
        followed = self._of(access.parameter._replace(ident=_COMMANDS[access.parameter.ident]))
        if followed is None:
            return
        raw = raw_number(access)
        if raw != followed.beside.command:
            followed.beside.command, followed.beside.row, followed.beside.since_s = raw, 0, None
            followed.beside.greatest = max(followed.beside.greatest, abs(raw or 0))
        followed.is_command_lost = False
        if said.number is None or said.unit == RAW:
            return
        if followed.command is None:
            followed.levels, followed.stopped = Levels(self._thresholds), Levels(self._thresholds)
        followed.command = said.number
        for levels in (followed.levels, followed.stopped):
            levels.scale = max(levels.scale, abs(said.number))

    def _lose_commands(self) -> None:
        """Forget commands: nobody has heard the last ones."""
        for followed in self._followed.values():
            followed.lose_command()

    def _lose_command(self, telegram: Telegram) -> None:
        written = telegram.columns.get("sis.parameter")
        for parameter, followed in self._followed.items():
            if FOLLOWS.get(parameter.ident) == written and station_of(parameter) == telegram.listener:
                followed.lose_command()

    def _state(self, followed: _Followed, packet: Packet, value: str) -> bool:
        """Take a state; tell whether it begins."""
        states = followed.states
        if states and states[-1].value == value:
            states[-1].to_s = packet.epoch_s
            return False
        while states and states[0].to_s < packet.epoch_s - self._thresholds.memory_s:
            del states[0]
        followed.values.add(value)
        if not followed.is_state or len(states) > self._thresholds.lively:
            return False
        states.append(_State(value, packet.epoch_s, packet.epoch_s, packet.number))
        return True

    def under_way(self, begun: Iterable[Parameter]) -> Iterator[Hit]:
        """Yield what is not as usual of the last state or level of these."""
        for parameter in begun:
            followed = self._followed[parameter]
            states_s = [state.from_s for state in followed.states[-1:]]
            last_s = max([*states_s, followed.levels.began_s])
            found = self._unusual(parameter, followed)
            yield from (hit._replace(outcome="") for hit in found if hit.from_s >= last_s)

    def _unusual(self, parameter: Parameter, followed: _Followed) -> Iterator[Hit]:
        if followed.is_written or parameter.ident in _TOLD_ELSEWHERE:
            return
        if followed.is_state:
            if followed.is_known_state:
                yield from _changes(parameter, followed, self._thresholds)
        elif not followed.is_counter:
            yield from _steps(parameter, followed, followed.levels)
            yield from _steps(parameter, followed, followed.stopped)
            for blip in followed.levels.blips():
                hit = _hit("blip", parameter, blip.packet, blip.from_s, blip.to_s)
                usual = followed.levels.usual
                yield hit._replace(detail=_beside(blip.value, usual, followed.unit), worst=abs(blip.value - usual))

    def finish(self) -> Iterator[Hit]:
        """Yield what was not as usual."""
        for parameter, followed in self._followed.items():
            yield from self._unusual(parameter, followed)
            is_place = FORMS.get(parameter.ident) == "position"
            is_usual = is_place or parameter._replace(port="") in self._drifting
            if not (followed.is_written or followed.is_state or followed.is_counter or is_usual):
                yield from _drifts(parameter, followed, self._since_s)

    def drifting(self) -> set[Parameter]:
        """Return the parameters that drift, without their port."""
        return {one._replace(port="") for one, followed in self._followed.items() if followed.levels.drift()}


# What tells a diagnosis, and what is only obeyed.
_TOLD_ELSEWHERE = {ident for ident, form in FORMS.items() if form != "bits"}


def _rise(followed: _Followed, number: float) -> None:
    last, followed.last = followed.last, number
    followed.high = max(number, followed.high)
    followed.low = min(number, followed.low)
    if last is not None and number != last:
        if number > last:
            followed.rises += 1
        elif last - number < _WRAPPED * (followed.high - followed.low) or followed.rises < _RISES:
            followed.falls += 1


def _beyond(packet: Packet, access: Access, number: float) -> Iterator[Hit]:
    limits = [_NUMBER.match(text) for text in (access.minimum, access.maximum)]
    if limits[0] and limits[1] and float(limits[0][0]) > float(limits[1][0]):
        return  # the drive tells its maximum in another way than its value
    for limit, text, sign, name in zip(
        limits, (access.minimum, access.maximum), (-1, 1), ("minimum", "maximum"), strict=True
    ):
        if limit and sign * (number - float(limit[0])) > 0:
            hit = _hit("beyond", access.parameter, packet.number, packet.epoch_s, packet.epoch_s)
            yield hit._replace(detail=f"{access.value}, its {name} is {text}", worst=abs(number - float(limit[0])))


def _apart(beside: _Beside, packet: Packet, parameter: Parameter, raw: int, command: int) -> Iterator[Hit]:
    """Yield that a value is far from its command for a while, if it usually follows it."""
    apart = raw - command
    if abs(apart) <= max(_NEAR * abs(command), _REST * beside.greatest):
        beside.near += 1
        beside.far += beside.row
        beside.row, beside.since_s = 0, None
        return
    if beside.since_s is None:
        beside.since_s, beside.packet = packet.epoch_s, packet.number
    beside.row += 1
    follows = beside.near >= _KNOWN and beside.near >= _FOLLOWS_USUALLY * (beside.near + beside.far)
    if follows and beside.row >= _APART and packet.epoch_s - beside.since_s >= APART_S:
        hit = _hit("apart", parameter, beside.packet, beside.since_s, packet.epoch_s)
        part = f"{abs(apart) / abs(command):.0%} " if command else ""
        where = BELOW if abs(raw) < abs(command) else "above"
        yield hit._replace(
            detail=f"{part.replace('%', ' %')}{where} {FOLLOWS[parameter.ident]}", worst=float(abs(apart))
        )


def _changes(parameter: Parameter, followed: _Followed, thresholds: Thresholds) -> Iterator[Hit]:
    """Yield states that are not the usual one; one that goes to and fro for a while, as that."""
    states = followed.states
    if len(states) < 2:
        return
    chatter = _chatter(states)
    if chatter:
        hit = _hit("chatter", parameter, chatter[0].packet, chatter[0].from_s, chatter[-1].from_s)
        values = " and ".join(sorted({state.value[:_SHOWN] for state in chatter}))
        yield hit._replace(detail=f"{len(chatter)} changes between {values}")
        return
    if len(states) > thresholds.few_levels * 4:
        return
    spans: dict[str, float] = {}
    for state in states:
        spans[state.value] = spans.get(state.value, 0.0) + state.to_s - state.from_s
    usual = max(spans, key=lambda value: spans[value])
    for before, state, after in zip([states[0], *states], states, [*states[1:], states[-1]], strict=False):
        if not _is_like(state.value, usual, thresholds.level_least):
            was = f"{before.value[:_SHOWN]}{ARROW}" if before is not state else ""
            hit = _hit("changed", parameter, state.packet, state.from_s, max(after.from_s, state.to_s))
            if state is after:
                hit = hit._replace(outcome=STILL)
            unit = f" {RAW}" if followed.unit == RAW else ""
            yield hit._replace(detail=f"{was}{state.value[:_SHOWN]}{unit}")


def _is_like(value: str, usual: str, least: float) -> bool:
    """Tell whether two states are the same, or begin with numbers that differ by no more than a part. What follows
    these is a unit, which perhaps is not known of both, or the rest of bits or of a list.
    """
    one, other = _NUMBER.match(value), _NUMBER.match(usual)
    if not one or not other:
        return value == usual
    rests = {value[one.end() :], usual[other.end() :]}
    if len(rests) > 1 and not ("" in rests and max(rests).startswith(" ")):
        return False
    return abs(float(one[0]) - float(other[0])) <= least * abs(float(other[0]))


def _chatter(states: Sequence[_State]) -> Sequence[_State]:
    """Return the states of a short time with nearly all changes of a value that otherwise rests."""
    begun = states[1:]
    for first in range(len(begun) - _CHATTERS + 1):
        within = [one for one in begun[first:] if one.from_s - begun[first].from_s <= _CHATTER_S]
        rest_s = states[-1].to_s - states[0].from_s - (within[-1].from_s - within[0].from_s)
        is_most = len(within) >= _FOLLOWS_USUALLY * len(begun)
        if is_most and rest_s > within[-1].from_s - within[0].from_s:
            return within
    return ()


def _steps(parameter: Parameter, followed: _Followed, levels: Levels) -> Iterator[Hit]:
    command = followed.command
    for level, severity in levels.unusual():
        usual = levels.usual
        hit = _hit("step", parameter, level.packet, level.from_s, level.to_s)
        if level.from_s == levels.began_s:
            hit = hit._replace(outcome=STILL)
        if command is None:
            detail = _beside(level.value, usual, followed.unit)
        else:
            where = "below" if level.value < 0 else "above"
            detail = f"{_number(abs(level.value))} {followed.unit} {where} {FOLLOWS[parameter.ident]}"
        far = abs(level.value - usual) / (max(abs(usual), levels.scale) or 1.0)
        is_small = severity < Severity.WARNING
        yield hit._replace(detail=detail.replace("  ", " "), worst=far, severity=Severity.NOTE if is_small else None)


def _drifts(parameter: Parameter, followed: _Followed, since_s: float) -> Iterator[Hit]:
    drift = followed.levels.drift(since_s)
    if drift is None:
        return
    points, found = drift
    hit = _hit("drift", parameter, 0, points[0][0], points[-1][0])
    first, last = points[0][1], points[-1][1]
    span = f"{_number(first)}{ARROW}{_number(last)} {followed.unit}".rstrip()
    far = abs(last - first) / (min(abs(first), abs(last)) or 1.0)
    yield hit._replace(detail=_drift(found, followed.unit, span), worst=far)


def _drift(found: Trend, unit: str, span: str) -> str:
    likely = f"by chance 1 in {1 / found.chance:.0f}" if found.chance > 1e-6 else "not by chance"
    slope = found.slope * _HOUR_S
    return f"{'+' * (slope > 0)}{_number(slope, 3)} {unit}/h, {span} ({likely})".replace(" /h", "/h")


def _number(value: float, digits: int = 4) -> str:
    """Write a number without an exponent."""
    return f"{value:.0f}" if abs(value) >= 10.0 ** (digits - 1) else f"{value:.{digits}g}"


def _beside(value: float, usual: float, unit: str) -> str:
    """Write a value beside the usual one."""
    return f"{_number(value)} {unit}, usually {_number(usual)}".replace(" ,", ",")


def _hit(kind: str, parameter: Parameter, packet: int, from_s: float, to_s: float) -> Hit:
    topic = str(parameter)
    return Hit(kind, packet, from_s, to_s, station_of(parameter), parameter.ident, port=parameter.port, topic=topic)


def unlike(good: Values, bad: Values) -> Iterator[Hit]:
    """Yield the levels of the bad side that are far from all of the good one. Other work may have other levels."""
    # Ports are left out: the tap may be at another port today.
    usual = {parameter._replace(port=""): followed for parameter, followed in good.followed()}
    for parameter, followed in bad.followed():
        before = usual.get(parameter._replace(port=""))
        if before is None or before.is_written or followed.is_written:
            continue
        if (before.command is None) != (followed.command is None) or before.unit != followed.unit:
            continue  # only one side tells what it follows, or how large it is
        if followed.levels.drift():
            continue  # that is told
        beside = "" if followed.command is None else f" beside {FOLLOWS[parameter.ident]}"
        for level in followed.levels.unlike(before.levels):
            detail = (
                f"{_number(level.value)} {followed.unit}{beside}, {_number(before.levels.usual)} in the good capture"
            )
            where = station_of(parameter), parameter.ident, detail.replace("  ", " ").replace(" ,", ",")
            place = "step", level.packet, level.from_s, level.to_s
            yield Hit(*place, *where, level.value, Severity.NOTE, parameter.port, str(parameter))
