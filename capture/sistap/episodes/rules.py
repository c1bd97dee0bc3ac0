# SPDX-License-Identifier: GPL-2.0-or-later
"""The kinds of episodes and the thresholds: the only place that says what is unusual.

What is wrong with a single telegram is said in plugin/protocol/faults.toml.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from sistap.sis.faults import FAULTS, WRITE


class Severity(enum.IntEnum):
    """How bad an episode is; from WARNING on, the night was not OK."""

    INFO, NOTE, WARNING, ERROR = range(4)


class Subject(enum.IntEnum):
    """The line of the answer in which a kind stands."""

    BUS, SILENT, DRIVES, CHANGED, LIMITS = range(5)


SUBJECTS = ("Bus", "Silent", "Drives", "Changed", "Limits")


class Rule(NamedTuple):
    """A kind of episode. Hits of the same kind and station are one episode if they are less than `join_s` apart."""

    subject: Subject
    severity: Severity  # of a hit that does not say its own
    title: str
    filter: str = ""  # finds all packets of this kind; empty: only their numbers do
    join_s: float = 30.0
    goes_on: bool = False  # for hours: then a recorder keeps its beginning


_FILTERS = {fault.name: fault.filter for fault in (*FAULTS, WRITE)}
_UNANSWERED = _FILTERS["unanswered"]

# In the order of the answer.
RULES: Mapping[str, Rule] = MappingProxyType(
    {
        "bus_silent": Rule(Subject.BUS, Severity.ERROR, "Bus silent", join_s=0),
        "rhythm": Rule(Subject.BUS, Severity.NOTE, "Bus silent in a rhythm", join_s=math.inf),
        "adapter": Rule(Subject.BUS, Severity.ERROR, "Adapter lost", "sertap.event == 4", join_s=0),
        "gap": Rule(Subject.BUS, Severity.WARNING, "Nothing was captured", join_s=0),
        "silent": Rule(Subject.SILENT, Severity.ERROR, "Station silent", _UNANSWERED, join_s=5),
        "changed": Rule(Subject.DRIVES, Severity.WARNING, "Value changed", join_s=0),
        "step": Rule(Subject.DRIVES, Severity.WARNING, "Step", join_s=30),
        "drift": Rule(Subject.DRIVES, Severity.WARNING, "Drift", join_s=0),
        "error": Rule(Subject.DRIVES, Severity.WARNING, "Reaction with an error", _FILTERS["error_reaction"]),
        "system_error": Rule(Subject.DRIVES, Severity.WARNING, "Error of a station", _FILTERS["system_error"]),
        "write": Rule(Subject.CHANGED, Severity.WARNING, "Write", _FILTERS["write"], join_s=0),
        "master": Rule(Subject.CHANGED, Severity.WARNING, "New master", join_s=600, goes_on=True),
        "phase": Rule(Subject.CHANGED, Severity.WARNING, "Phase", "sis.phase", join_s=0),
        "rate": Rule(Subject.CHANGED, Severity.WARNING, "Baud rate", join_s=0),
        "limits": Rule(Subject.CHANGED, Severity.WARNING, "Limit", "sis.service == 3", join_s=0),
        "late": Rule(Subject.LIMITS, Severity.ERROR, "Reaction later than TrS", "sis.trs.verdict > 0"),
        "interval": Rule(Subject.LIMITS, Severity.ERROR, "Interval longer than TzA", "sis.tza.verdict > 0"),
        "cycle": Rule(Subject.LIMITS, Severity.ERROR, "Master control word later than Tmas", "sis.tmas.verdict > 0"),
        "damaged": Rule(Subject.LIMITS, Severity.WARNING, "Damaged telegram", _FILTERS["damaged"]),
        "line_error": Rule(Subject.LIMITS, Severity.WARNING, "Line error", _FILTERS["line_error"]),
        "lost": Rule(Subject.LIMITS, Severity.WARNING, "Characters lost", _FILTERS["lost"]),
        "repeated": Rule(Subject.LIMITS, Severity.WARNING, "Sent again", f"{_UNANSWERED} || {_FILTERS['repeated']}"),
        "unanswered": Rule(Subject.LIMITS, Severity.WARNING, "Command without a reaction", _UNANSWERED),
        "clock": Rule(Subject.LIMITS, Severity.WARNING, "Clock", join_s=0),
    }
)


class Thresholds(NamedTuple):
    """From where on something is unusual."""

    bus_silent_s: float = 3.0  # shorter silences are none
    bus_silent_times: float = 3.0  # as long as the longest of the usual silences
    rhythm_times: int = 10  # as many silences as long and as far apart: the master pauses so
    rhythm_part: float = 0.1  # by which these differ
    silent_commands: int = 3  # in a row, without a reaction
    silent_s: float = 1.0  # from the first of them on
    clock_s: float = 0.5  # by which time stamps and measured intervals differ
    switching_s: float = 10.0  # after which a station has reached the phase that was asked for
    learning_commands: int = 200  # whoever asks in the first ones is a usual master
    rare_writes: int = 2  # a parameter that is written more often is usually written
    level_noise: float = 8.0  # a value farther from its level, in multiples of the usual scatter, is outside
    level_values: int = 3  # outside, in a row: a new level
    level_least: float = 0.05  # as a part of the usual level: smaller steps do not matter
    level_far: float = 3.0  # interquartile ranges beyond the quartiles of all levels
    level_s: float = 5.0  # shorter levels are a ramp
    few_levels: int = 6  # a value with no more levels rarely changes: then each of them is told
    lively: int = 200  # levels or states; a value with more just moves
    drift_least: float = 0.2  # as a part of the usual level, over the whole capture
    drift_noise: float = 6.0  # multiples of the scatter around the line
    drift_chance: float = 0.001  # that neighbours, dealt by chance, rise as often
    drift_s: float = 1800.0  # a shorter capture has no drift
    learning_s: float = 3600.0  # a recorder learns what is written, and the levels of values
    memory_s: float = 1e9  # levels and states of values that ended longer ago are forgotten


THRESHOLDS = Thresholds()


def changed(thresholds: Thresholds, text: str) -> Thresholds:
    """Return them with the one that NAME=VALUE says. ValueError says what is wrong."""
    name, _, value = text.partition("=")
    if name not in thresholds._fields:
        raise ValueError(f"'{text}' is not NAME=VALUE with a NAME of: {', '.join(thresholds._fields)}")
    kind = type(getattr(thresholds, name))
    try:
        number = kind(value)
    except ValueError:
        number = -1
    if not 0 <= number < math.inf:
        raise ValueError(f"{name} takes a {'whole ' if kind is int else ''}number from 0 on, not '{value}'")
    return thresholds._replace(**{name: number})
