# SPDX-License-Identifier: GPL-2.0-or-later
"""The kinds of episodes, how bad each is and what to do; and the thresholds that --rule changes.

What is wrong with a single telegram is said in plugin/protocol/faults.toml.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from sistap.tap.sis.faults import FAULTS, WRITE


class Severity(enum.IntEnum):
    """How bad an episode is. An error makes the answer NOT OK; a warning is to be looked at; a note is the life of a
    machine.
    """

    NOTE, WARNING, ERROR = range(1, 4)


class Subject(enum.IntEnum):
    """The line of the answer in which a kind stands."""

    BUS, SILENT, DRIVES, CHANGED, LIMITS = range(5)


SUBJECTS = ("Bus", "Silent", "Drives", "Changed", "Limits")


class Rule(NamedTuple):
    """A kind of episode. Hits of the same kind and station are one episode if they are less than `join_s` apart."""

    subject: Subject
    severity: Severity  # of a hit that does not say its own
    title: str
    means: str
    do: str = ""  # what a technician does about it
    filter: str = ""  # finds all packets of this kind; empty: only their numbers do
    join_s: float = 30.0
    goes_on: bool = False  # for hours: then a recorder keeps its beginning
    is_kept: bool = True  # by a recorder, if the hit does not say its own severity


_FILTERS = {fault.name: fault.filter for fault in (*FAULTS, WRITE)}
_DO = {fault.name: fault.do for fault in FAULTS}
_UNANSWERED = _FILTERS["unanswered"]
_ALWAYS = math.inf
_LINE = "Check cable, termination, ground and shield; what is switched at these times?"

_BUS, _SILENT, _DRIVES, _CHANGED, _LIMITS = Subject
_NOTE, _WARNING, _ERROR = Severity

# In the order of the answer: within a severity, the first comes first.
RULES: Mapping[str, Rule] = MappingProxyType(
    {
        # the bus as a whole
        "foreign": Rule(
            *(_BUS, _ERROR, "No SIS"),
            "At least five records, and none is a telegram of SIS.",
            "Check protocol, baud rate and format: try --baud auto. USIP, USS and others begin with 02, too.",
            join_s=_ALWAYS,
        ),
        "bus_silent": Rule(
            *(_BUS, _ERROR, "Bus silent"),
            "No character for 3 s, and three times as long as usual; no boot follows. A note, if too little was heard.",
            "Look for a master that stopped, or a loose cable.",
            join_s=0,
        ),
        "unreadable": Rule(
            *(_BUS, _ERROR, "Bus unreadable"),
            "At least 20 records in 3 s or more, and most are no telegrams.",
            "Look for a wrong baud rate, or a short circuit of the bus.",
            join_s=30,
        ),
        "adapter": Rule(
            *(_BUS, _ERROR, "Adapter lost"),
            "The tap has lost its adapter.",
            "Check the USB plug of the tap.",
            filter="sertap.event == 4",
            join_s=0,
        ),
        "gap": Rule(
            *(_BUS, _WARNING, "Nothing was captured"),
            "Between two captures.",
            "Nobody knows what happened in this time.",
            join_s=0,
        ),
        "estop": Rule(
            *(_BUS, _WARNING, "Emergency stop"),
            "Several drives have the fault F434 or F4034 at once.",
            "Ask who pressed it, and why.",
            join_s=0,
            is_kept=False,
        ),
        "rhythm": Rule(
            *(_BUS, _NOTE, "Bus silent in a rhythm"),
            "Silences after ten others in a rhythm. Perhaps the master asks once a minute, or a cable is loose.",
            join_s=_ALWAYS,
            is_kept=False,
        ),
        "off": Rule(
            *(_BUS, _NOTE, "Machine off"),
            "The bus was silent; then most stations were initialised.",
            join_s=0,
            is_kept=False,
        ),
        "boot": Rule(
            *(_BUS, _NOTE, "Stations initialised"),
            "Most stations switched phases, or were identified and got their times, one after the other.",
            join_s=0,
            is_kept=False,
        ),
        "stopped": Rule(
            *(_BUS, _NOTE, "Machine stopped"),
            "Most drives stand, as control word, drive status, diagnosis or speed says.",
            join_s=0,
            is_kept=False,
        ),
        # who does not speak
        "silent": Rule(
            *(_SILENT, _ERROR, "Station silent"),
            "A station left at least three commands without a reaction, for at least a second.",
            "Check supply, address, baud rate and cable of this station.",
            filter=_UNANSWERED,
            join_s=5,
        ),
        "vanished": Rule(
            *(_SILENT, _WARNING, "Master gone"),
            "A usual master, or one of the good capture, asks nothing any more, while others do.",
            "Look whether this master still runs.",
            join_s=0,
            is_kept=False,
        ),
        "restart": Rule(
            *(_SILENT, _WARNING, "Station restarted"),
            "One station was silent, then identified or initialised again.",
            "Check the 24 V supply of this station.",
            join_s=0,
            is_kept=False,
        ),
        # what drives say
        "fault": Rule(
            *(_DRIVES, _ERROR, "Fault"),
            "S-0-0390 or S-0-0095 begins with F, S-0-0011 is not 0, or bit 13 of S-0-0135 is set.",
            "Look up the code in the manual of the drive.",
            join_s=5,
        ),
        "homing": Rule(
            *(_DRIVES, _ERROR, "Position not referenced"),
            "Bit 0 of S-0-0403 was 1, and is 0.",
            "Home this axis.",
            join_s=0,
        ),
        "system_error": Rule(
            *(_DRIVES, _ERROR, "Error of a station"),
            "The telegram control says that the sender has an error.",
            _DO["system_error"],
            filter=_FILTERS["system_error"],
            join_s=60,
        ),
        "warning": Rule(
            *(_DRIVES, _WARNING, "Warning"),
            "S-0-0390 or S-0-0095 begins with E, or S-0-0012 is not 0.",
            "Look up the code in the manual of the drive.",
            join_s=5,
        ),
        "warning_bit": Rule(
            *(_DRIVES, _WARNING, "Warning bit of a station"),
            "The telegram control says that the sender has a warning.",
            "Read S-0-0390 or S-0-0095 of this station.",
            filter="sis.control.warning.set",
            join_s=60,
        ),
        "stuck": Rule(
            *(_DRIVES, _WARNING, "Not ready"),
            "After a boot, a station has not reached phase 4, as others have.",
            "Read S-0-0390 or S-0-0095 of this station.",
            join_s=0,
            is_kept=False,
        ),
        "beyond": Rule(
            *(_DRIVES, _WARNING, "Value beyond its limit"),
            "A value is beyond the minimum or maximum that the drive told.",
            "Compare it with the limits it tells.",
            join_s=60,
        ),
        "apart": Rule(
            *(_DRIVES, _WARNING, "Value far from its command"),
            "S-0-0040 or S-0-0084 usually follows its command, and is away from it for 20 s: by more than 10 %, and "
            "by more than 1 % of the greatest command.",
            "Look for load, brake or limit.",
            join_s=60,
        ),
        "chatter": Rule(
            *(_DRIVES, _WARNING, "Value changes to and fro"),
            "A state that otherwise rests changes six times or more within five minutes.",
            "Check this switch and its wires.",
            join_s=0,
        ),
        "error": Rule(
            *(_DRIVES, _WARNING, "Reaction with an error"),
            "A station refuses what it answered before, or a write.",
            "Read the code: what does the station refuse, and since when?",
            filter=_FILTERS["error_reaction"],
            join_s=300,
        ),
        "never": Rule(
            *(_DRIVES, _NOTE, "Not known to the station"),
            "A station refuses to read a parameter that it never gave.",
            "Nothing, or take it off the list of the master.",
            filter=_FILTERS["error_reaction"],
            join_s=_ALWAYS,
            is_kept=False,
        ),
        "busy": Rule(
            *(_DRIVES, _NOTE, "Busy"),
            "A station was busy, and the master has to ask again. To look at: 20, and 0.1 % of all telegrams.",
            "Look who else asks this station.",
            filter=_FILTERS["error_reaction"],
        ),
        "slower": Rule(
            *(_DRIVES, _WARNING, "Answers slower"),
            "The reaction time rose by half, and by 5 ms: steadily, or at once, until the end.",
            "Look for load of this station.",
            join_s=0,
        ),
        "drift": Rule(
            *(_DRIVES, _NOTE, "Drift"),
            "A value rose or fell by a fifth, for half an hour or more, and does so to the end.",
            join_s=0,
        ),
        "step": Rule(
            *(_DRIVES, _NOTE, "Step"),
            "Three values in a row are far from all others of a machine that runs, or that stands.",
            join_s=30,
        ),
        "blip": Rule(
            *(_DRIVES, _NOTE, "Peak or dip"),
            "At least three stations have a short peak of the same parameter at once.",
            join_s=0,
            is_kept=False,
        ),
        "changed": Rule(
            *(_DRIVES, _NOTE, "Value changed"),
            "A text, bits, or one of few numbers is not the usual one.",
            join_s=0,
        ),
        # who changed what
        "conflict": Rule(
            *(_CHANGED, _WARNING, "Two masters write it"),
            "Two masters write different values again and again, each after the other.",
            "Decide which of the masters sets this parameter.",
            filter=_FILTERS["write"],
            join_s=_ALWAYS,
        ),
        "limit_write": Rule(
            *(_CHANGED, _WARNING, "Limit of a drive written"),
            "A usual master changed a limit of a drive, such as S-0-0091. By a new master, it is a write.",
            "Compare it with the machine's data sheet.",
            filter=_FILTERS["write"],
            join_s=0,
        ),
        "exchanged": Rule(
            *(_CHANGED, _WARNING, "Another device"),
            "The firmware or the type key at an address is another one.",
            "Compare all its parameters with a backup.",
            join_s=0,
        ),
        "other": Rule(
            *(_CHANGED, _WARNING, "Value other than before"),
            "A parameter was read as it was written; now it is another, and nobody wrote it.",
            "Was a drive exchanged, or reset?",
            join_s=0,
        ),
        "write": Rule(
            *(_CHANGED, _WARNING, "Write"),
            "A master that did not ask at the beginning wrote. A note: a usual master wrote what it rarely writes.",
            "Ask who wrote it, and why.",
            filter=_FILTERS["write"],
            join_s=600,
        ),
        "master": Rule(
            *(_CHANGED, _NOTE, "New master"),
            "A master that did not ask at the beginning: who, from when to when, how much.",
            "Ask who it is.",
            join_s=600,
            goes_on=True,
        ),
        "phase": Rule(
            *(_CHANGED, _WARNING, "Phase"),
            "The phase of a station changed, and it was not initialised.",
            "Look who switched the phase.",
            filter="sis.phase",
            join_s=0,
        ),
        "rate": Rule(
            *(_CHANGED, _WARNING, "Baud rate"),
            "The baud rate of the tap changed.",
            "Look who set it.",
            join_s=0,
        ),
        "limits": Rule(
            *(_CHANGED, _WARNING, "Limit"),
            "TzA or TrS of a station changed, and it was not initialised.",
            "Look who set it.",
            filter="sis.service == 3",
            join_s=0,
        ),
        "recipe": Rule(
            *(_CHANGED, _NOTE, "Recipe"),
            "A usual master wrote at least four parameters one after the other.",
            join_s=0,
            is_kept=False,
        ),
        # times and telegrams
        "again": Rule(
            *(_LIMITS, _ERROR, "Answered twice"),
            "A command was answered twice, at least three times in all.",
            "Look for two stations with this address.",
            filter="sis.reaction.again",
            join_s=60,
        ),
        "late": Rule(
            *(_LIMITS, _ERROR, "Reaction later than TrS"),
            "TrS is exceeded; a note: perhaps.",
            _DO["trs_exceeded"],
            filter="sis.trs.verdict > 0",
            join_s=300,
        ),
        "interval": Rule(
            *(_LIMITS, _ERROR, "Interval longer than TzA"),
            "TzA is exceeded; a note: perhaps.",
            _DO["tza_exceeded"],
            filter="sis.tza.verdict > 0",
        ),
        "cycle": Rule(
            *(_LIMITS, _ERROR, "Master control word later than Tmas"),
            "Tmas is exceeded; a note: perhaps.",
            _DO["tmas_exceeded"],
            filter="sis.tmas.verdict > 0",
        ),
        "unexpected": Rule(
            *(_LIMITS, _WARNING, "Broadcast answered"),
            "Somebody answered what was sent to a group or to all.",
            "Look which station answers what is for all.",
            filter="sis.reaction.unexpected",
            join_s=_ALWAYS,
        ),
        "early": Rule(
            *(_LIMITS, _WARNING, "Sent again too early"),
            "A master sent a command again before TrS was over.",
            "Set the waiting time of this master longer than TrS.",
            filter="sis.twm.early",
            join_s=600,
        ),
        "damaged": Rule(
            *(_LIMITS, _NOTE, "Damaged telegram"),
            "A wrong checksum, or no whole telegram. To look at: 5 in a burst, or 20 and 0.1 % of all. Error: 1 %.",
            _LINE,
            filter=_FILTERS["damaged"],
        ),
        "line_error": Rule(
            *(_LIMITS, _NOTE, "Line error"),
            "A parity or framing error, or a break. Severities as of damaged.",
            _LINE,
            filter=_FILTERS["line_error"],
        ),
        "lost": Rule(
            *(_LIMITS, _NOTE, "Characters lost"),
            "The tap has lost characters. Severities as of damaged.",
            _DO["lost"],
            filter=_FILTERS["lost"],
            join_s=60,
        ),
        "repeated": Rule(
            *(_LIMITS, _NOTE, "Sent again"),
            "A command without a reaction was sent again. Severities as of damaged.",
            _DO["unanswered"],
            filter=f"{_UNANSWERED} || {_FILTERS['repeated']}",
        ),
        "unanswered": Rule(
            *(_LIMITS, _NOTE, "Command without a reaction"),
            "A station left fewer commands than a silence has. Severities as of damaged.",
            _DO["unanswered"],
            filter=_UNANSWERED,
        ),
        "clock": Rule(
            *(_LIMITS, _WARNING, "Clock"),
            "Time stamps do not fit the measured intervals. A note: the tap has noticed it.",
            "Compare the clock of the tap with another.",
            join_s=0,
        ),
        "against": Rule(
            *(_LIMITS, _NOTE, "Telegram against the rules"),
            "The dissector marks the telegram with a warning that no other kind has.",
            "Compare the telegram with its layout.",
            join_s=_ALWAYS,
            is_kept=False,
        ),
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
    learning_masters_s: float = 120.0  # and in the first time; a panel starts later than a control
    vanished_s: float = 60.0  # a usual master that asks nothing for longer, while others do
    vanished_times: float = 5.0  # as long as its longest pause
    damage_burst: int = 5  # damaged telegrams or line errors in a row of them: to be looked at
    damage_part: float = 0.001  # of all telegrams: to be looked at, from damage_least on
    damage_bad: float = 0.01  # of all telegrams: an error
    damage_least: int = 20
    again: int = 3  # second answers: surely two stations
    slower_s: float = 0.005  # by which a station answers later at the end than at the beginning
    slower_part: float = 0.5  # of its usual reaction time
    rare_writes: int = 2  # a parameter that is written more often is usually written
    level_noise: float = 8.0  # a value farther from its level, in multiples of the usual scatter, is outside
    level_values: int = 3  # outside, in a row: a new level
    level_least: float = 0.05  # as a part of the usual level: smaller steps do not matter
    level_edge_s: float = 60.0  # a step was seen if its value was read so shortly before or after it
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
