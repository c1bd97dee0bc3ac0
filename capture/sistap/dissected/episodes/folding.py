# SPDX-License-Identifier: GPL-2.0-or-later
"""What belongs together is told once: the state of a machine, with all that it explains.

1. The same from two sources (S-0-0390 and S-0-0095), or of several stations at once, becomes one.
2. An emergency stop is its fault in two drives at once; a machine that was switched off is a silence and a boot.
3. What a state explains is left out, by the table EXPLAINS, but not what says more of a drive: _says_more.
4. What is only bad in numbers (damaged telegrams) gets its severity.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from sistap.dissected.episodes.boots import AGAIN
from sistap.dissected.episodes.episode import ARROW, Episode
from sistap.dissected.episodes.rules import Severity, Thresholds
from sistap.dissected.episodes.silence import AT_FIRST
from sistap.dissected.episodes.standard import FOLLOWS
from sistap.dissected.episodes.values import APART_S, BELOW

SOON_S = 60.0  # values of a panel are read so late; a cause and its effect are so far apart
_BOOT_S = 180.0  # from the end of a silence to the first initialisation
_ESTOP = {"F434", "F4034"}  # the faults that an emergency stop makes (ECODRIVE, IndraDrive)
_ALIKE = 1.2  # a drift that is so many times another one is no longer like it
_MANY = 3  # stations: a short peak of one alone means nothing
_STATIONS_AT_ONCE_S = 10.0


class _Explained(NamedTuple):
    """What a state explains, if it is from `before_s` before it to `after_s` after its end."""

    kinds: frozenset[str]
    before_s: float = 5.0
    after_s: float = SOON_S
    same_station: bool = False


_VALUES = frozenset({"step", "blip", "changed"})
_NO_ANSWER = frozenset({"unanswered", "repeated"})
_WRITTEN = frozenset({"write", "limit_write", "limits", "recipe"})
_BOOT = _VALUES | _NO_ANSWER | _WRITTEN | {"silent", "phase", "error", "restart", "early", "cycle"}

# What is told by a state is not told again.
EXPLAINS: dict[str, _Explained] = {
    "foreign": _Explained(frozenset({"damaged", "line_error", "lost", "unreadable", "bus_silent"})),
    "off": _Explained(
        _BOOT | {"boot", "bus_silent", "stopped", "apart", "vanished", "damaged", "line_error", "homing"}, SOON_S
    ),
    "boot": _Explained(_BOOT, SOON_S),
    "restart": _Explained(_BOOT - {"restart"}, SOON_S, SOON_S, same_station=True),
    "estop": _Explained(_VALUES | {"stopped", "fault", "system_error", "write", "recipe"}, SOON_S, 2 * SOON_S),
    "stopped": _Explained(_VALUES | {"apart"}, SOON_S),
    "unreadable": _Explained(_NO_ANSWER | {"damaged", "line_error", "lost", "silent", "bus_silent"}, 5.0, 5.0),
    "rate": _Explained(_NO_ANSWER | {"damaged", "line_error", "silent", "unreadable"}, 30.0, 5.0),
    "adapter": _Explained(frozenset({"gap", "bus_silent"}), 5.0, 5.0),
    "bus_silent": _Explained(_NO_ANSWER | _VALUES | {"silent"}, 5.0, SOON_S),
    "fault": _Explained(_VALUES | {"system_error", "apart", "fault"}, SOON_S, SOON_S, same_station=True),
    "warning": _Explained(frozenset({"warning_bit"}), 2 * SOON_S, 2 * SOON_S, same_station=True),
    "recipe": _Explained(_VALUES, 5.0, SOON_S),
    "again": _Explained(_NO_ANSWER, same_station=True),
    "early": _Explained(_NO_ANSWER, same_station=True),
}
_BY_AN_EDGE = {"step", "blip", "changed"}  # a level lasts as long as its state, or until the next one
_BOOTS = {"boot", "off"}
_LASTING = {"silent", "fault", "warning", "homing"}  # what a drive still is
_UP_S = 20.0  # a drive may be up so much later than the others
_SOON_OFF_S = 5.0  # drives may fall silent so long before their bus does
_ALONE = "alone"  # topic of a silence that began before a machine was off, while most drives answered

# Of several stations they are one, if they begin and end within so many seconds of one another.
_TOGETHER: dict[str, float] = {
    "silent": _STATIONS_AT_ONCE_S,
    "cycle": _STATIONS_AT_ONCE_S,
    "fault": SOON_S,
    "warning": SOON_S,
    "homing": SOON_S,
    "limits": SOON_S,
    "write": _STATIONS_AT_ONCE_S,
    "step": SOON_S,
    "blip": SOON_S,
    "changed": SOON_S,
    "drift": 1e9,
    "never": 1e9,
}
_SAME_DETAIL = {"fault", "warning", "never", "limits"}
DAMAGE = {"damaged", "line_error", "lost", "repeated", "unanswered"}
_BY_NUMBER = DAMAGE | {"busy"}  # bad only if there are many


def fold(episodes: Sequence[Episode], telegrams: int, thresholds: Thresholds) -> list[Episode]:
    """Return what is told of episodes, both in the order of their beginning. `telegrams` are all good ones."""
    found = _each_once(episodes)
    found = _emergency_stops(found)
    found = _switched_off(found)
    found = _restarts(found)
    found = list(_unexplained(_cut_stops(found)))
    found = [one for one in _of_several_stations(found) if one.kind != "blip" or len(one.stations) >= _MANY]
    found = _weighed(found, telegrams, thresholds)
    _find_causes(found)
    return sorted(found, key=_begin)


def _begin(episode: Episode) -> float:
    return episode.from_s


def _joined(episodes: Iterable[Episode], is_one: Callable[[Episode, Episode], bool]) -> list[Episode]:
    """Join each episode with an earlier one, where they are one."""
    found: list[Episode] = []
    for one in episodes:
        like = next((other for other in reversed(found) if is_one(other, one)), None)
        if like:
            like.join(one)
        else:
            found.append(one)
    return found


def _each_once(episodes: Sequence[Episode]) -> list[Episode]:
    """Join what two parameters of a drive tell."""

    def is_one(one: Episode, other: Episode) -> bool:
        is_same = (one.kind, one.station, one.hit.topic) == (other.kind, other.station, other.hit.topic)
        return is_same and other.from_s <= one.to_s + SOON_S

    told = [one for one in episodes if one.kind in ("fault", "warning")]
    joined = _joined(told, is_one)
    for one in joined:
        one.count = 1
    return [*(one for one in episodes if one.kind not in ("fault", "warning")), *joined]


def _emergency_stops(episodes: Sequence[Episode]) -> list[Episode]:
    """Make one of the faults of several drives that came and went together."""
    faults = [one for one in episodes if one.hit.topic in _ESTOP]
    stops: list[Episode] = []
    for group in _at_once(faults):
        stations = set[int]().union(*(one.stations for one in group))
        if len(stations) < 2:
            continue
        first, to_s = group[0], max(one.to_s for one in group)
        outcome = next((one.outcome for one in group if one.outcome), "")
        over_s = max((one.to_s for one in group if not one.outcome), default=to_s)
        if to_s - over_s > SOON_S:  # the drives that still say so have a fault of their own
            to_s, outcome = over_s, ""
        hit = first.hit._replace(kind="estop", to_s=to_s, station=None, parameter="", detail=first.hit.topic)
        stops.append(replace(Episode.of(hit), stations=stations, outcome=outcome))
    return [*episodes, *stops]


def _at_once(episodes: Sequence[Episode]) -> Iterator[list[Episode]]:
    group: list[Episode] = []
    for one in episodes:
        if group and one.from_s - group[0].from_s > SOON_S:
            yield group
            group = []
        group.append(one)
    if group:
        yield group


def _switched_off(episodes: Sequence[Episode]) -> list[Episode]:
    """Make one of a silence of the bus and the boot after it."""
    silences = [one for one in episodes if one.kind == "bus_silent"]
    made: list[Episode] = []
    for boot in (one for one in episodes if one.kind == "boot"):
        before = [one for one in silences if boot.from_s - _BOOT_S <= one.to_s <= boot.to_s]
        if before:
            from_s = before[-1].from_s
            hit = boot.hit._replace(kind="off", from_s=from_s, outcome="")
            made.append(Episode.of(hit))
            _mark_alone(episodes, made[-1])
    return [*episodes, *made]


def _mark_alone(episodes: Sequence[Episode], off: Episode) -> None:
    """Mark the silences that began before a machine was off, if most drives answered until then."""
    silent = (one for one in episodes if one.kind == "silent" and one.hit.topic != AT_FIRST)
    gone = [one for one in silent if 0 < off.from_s - _SOON_OFF_S - one.from_s <= SOON_S]
    if 2 * len(set[int]().union(*(one.stations for one in gone))) < (off.hit.worst or 0):
        for one in gone:
            one.hit = one.hit._replace(topic=_ALONE)


def _restarts(episodes: Sequence[Episode]) -> list[Episode]:
    """Begin a restart with the silence before it. Without one it is none."""
    found: list[Episode] = []
    for one in episodes:
        if one.kind != "restart":
            found.append(one)
            continue
        silences = [
            other
            for other in episodes
            if other.kind in ("silent", "unanswered", "repeated")
            and other.station == one.station
            and other.to_s >= one.from_s - SOON_S
            and other.from_s <= one.to_s
            and other.to_s <= one.to_s + SOON_S
        ]
        if silences:
            silence = max(silences, key=lambda other: other.to_s - other.from_s)
            from_s = min(one.from_s, silence.from_s)
            lasted = f"silent for {silence.to_s - silence.from_s:.0f} s, "
            found.append(Episode.of(one.hit._replace(from_s=from_s, detail=lasted + one.hit.detail)))
    return found


def _cut_stops(episodes: Sequence[Episode]) -> list[Episode]:
    """Let a stop begin after what tells that the machine stands: switched off, or an emergency stop."""
    told = [one for one in episodes if one.kind in ("off", "estop", "boot")]
    found = []
    for one in episodes:
        is_cut = False
        for state in told if one.kind == "stopped" else ():
            if state.from_s - SOON_S <= one.from_s <= state.to_s:
                one.from_s, is_cut = state.to_s, True
        if not is_cut or one.to_s - one.from_s > SOON_S:
            found.append(one)
    return found


def _unexplained(episodes: Sequence[Episode]) -> Iterator[Episode]:
    """Yield what no state explains."""
    states = [(state, EXPLAINS[state.kind]) for state in episodes if state.kind in EXPLAINS]
    for one in episodes:
        if not any(_is_explained(one, state, explained) for state, explained in states):
            yield one


def _is_explained(one: Episode, state: Episode, explained: _Explained) -> bool:
    if one is state or one.kind not in explained.kinds or _is_of_others(one, state, explained):
        return False
    if (one.kind == "fault" and not _is_told_by(one, state)) or _is_set_by_somebody(one) or _says_more(one, state):
        return False
    begin_s, end_s = state.from_s - explained.before_s, state.to_s + explained.after_s
    begins, ends = begin_s <= one.from_s <= end_s, begin_s <= one.to_s <= end_s
    if one.kind == "homing":  # an axis is homed any time later
        return begins
    if one.hit.topic == AT_FIRST and state.kind in _BOOTS and not state.hit.topic:  # a panel may ask for hours
        return ends
    return begins or ends if one.kind in _BY_AN_EDGE else begins and ends


def _is_of_others(one: Episode, state: Episode, explained: _Explained) -> bool:
    """Tell whether it is of stations that the state says nothing of."""
    if state.kind in _BOOTS:
        alone = {int(number) for number in state.hit.topic.split() if number != AGAIN}  # if others ran
        is_new = one.hit.topic == AT_FIRST and one.from_s >= state.from_s
        return one.kind in ("silent", "phase") and bool(alone) and not one.stations <= alone and not is_new
    return explained.same_station and not one.stations <= state.stations


def _is_set_by_somebody(one: Episode) -> bool:
    """Tell whether it is no write of a usual master that only switches on: a limit that had another value is none."""
    is_by_a_visitor = one.kind == "write" and one.severity >= Severity.WARNING
    return is_by_a_visitor or (one.kind == "limit_write" and ARROW in one.hit.detail)


def _says_more(one: Episode, state: Episode) -> bool:
    """Tell whether it lasts longer than the state, or came too long before it to be a part of it."""
    later_s = _UP_S if state.kind in _BOOTS or state.kind == "bus_silent" else 0.0
    if one.kind in _LASTING and one.outcome and one.to_s > state.to_s + later_s and not state.outcome:
        return True
    if one.kind == "apart":  # an axis that coasts is above its command
        return state.kind == "stopped" and BELOW in one.hit.detail and one.from_s < state.from_s - APART_S
    if one.kind != "silent" or one.severity < Severity.ERROR or one.hit.topic == AT_FIRST:
        return False
    if state.kind == "off":
        return one.hit.topic == _ALONE or one.to_s < state.from_s - _SOON_OFF_S
    return state.kind == "boot" and one.from_s < state.from_s


def _is_told_by(fault: Episode, state: Episode) -> bool:
    """Tell whether a fault is one of an emergency stop, or only a bit beside the code of a diagnosis."""
    is_code = fault.hit.topic[:1] == "F"
    if state.kind == "estop":
        return not is_code or fault.hit.topic in _ESTOP
    return not is_code and state.hit.topic[:1] == "F"


def _of_several_stations(episodes: Sequence[Episode]) -> list[Episode]:
    """Join what several stations have at once."""

    def is_one(one: Episode, other: Episode) -> bool:
        if one.kind in DAMAGE:
            return other.from_s <= one.to_s + one.rule.join_s
        apart_s = _TOGETHER[one.kind]
        is_same = _what(one) == _what(other)
        is_near = abs(one.from_s - other.from_s) <= apart_s and abs(one.to_s - other.to_s) <= apart_s
        is_like = one.kind not in _SAME_DETAIL or one.hit.topic == other.hit.topic
        is_like = is_like and (one.kind != "drift" or _is_as_far(one, other))
        is_like = is_like and (one.kind != "write" or _written(one) == _written(other))
        return is_same and is_near and is_like and not one.stations & other.stations

    several = sorted((one for one in episodes if one.kind in _TOGETHER or one.kind in DAMAGE), key=_begin)
    by_kind: defaultdict[str, list[Episode]] = defaultdict(list)
    for one in several:
        by_kind[one.kind].append(one)
    joined = [one for same in by_kind.values() for one in _joined(same, is_one)]
    for one in joined:
        if one.kind == "write" and len(one.stations) > 1:
            one.hit = one.hit._replace(detail=_written(one))  # each may have had another value before
    return [*(one for one in episodes if one.kind not in by_kind), *joined]


def _written(write: Episode) -> str:
    """Return what is written, and by whom."""
    return write.hit.detail.rpartition(ARROW)[2]


def _what(one: Episode) -> tuple[object, ...]:
    return one.hit.parameter, one.severity, one.outcome


def _is_as_far(one: Episode, other: Episode) -> bool:
    """Tell whether two drifts are alike: one drive that gets far hotter than the others is told apart."""
    far = sorted((one.hit.worst or 0.0, other.hit.worst or 0.0))
    return far[1] <= _ALIKE * far[0]


def _weighed(episodes: Sequence[Episode], telegrams: int, thresholds: Thresholds) -> list[Episode]:
    """Set the severity of what is bad only in numbers. What is bad all the time is one."""
    counts: defaultdict[str, int] = defaultdict(int)
    for one in episodes:
        if one.kind in _BY_NUMBER:
            counts[one.kind] += one.count
    parts = {
        kind: count / max(telegrams, 1) if count >= thresholds.damage_least else 0.0 for kind, count in counts.items()
    }
    often = {kind for kind, part in parts.items() if part >= thresholds.damage_part}
    found = [one for one in episodes if one.kind not in often]
    found += _joined((one for one in episodes if one.kind in often), lambda one, other: one.kind == other.kind)
    again = sum(one.count for one in found if one.kind == "again")
    for one in found:
        if one.kind == "again" and again < thresholds.again:
            one.severity = Severity.NOTE
        elif one.kind in DAMAGE and parts.get(one.kind, 0.0) >= thresholds.damage_bad:
            one.severity = Severity.ERROR
        elif one.kind in often or (one.kind in DAMAGE and one.count >= thresholds.damage_burst):
            one.severity = Severity.WARNING
    return found


def _find_causes(episodes: Sequence[Episode]) -> None:
    """Name the write of a command shortly before what follows it changes."""
    writes = [one for one in episodes if one.kind in ("write", "limit_write", "conflict")]
    for effect in (one for one in episodes if one.kind in ("step", "apart")):
        for write in writes:
            is_followed = FOLLOWS.get(effect.hit.parameter) == write.hit.parameter
            is_same = write.stations == effect.stations
            if is_followed and is_same and 0 <= effect.from_s - write.from_s < SOON_S:
                effect.cause = f"soon after the write of {write.hit.parameter}"
