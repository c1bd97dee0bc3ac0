# SPDX-License-Identifier: GPL-2.0-or-later
"""The worst moments of a capture: their kinds, and the worst of each kind, ranked."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from sistap.line.settings import Flag
from sistap.packets.dissection import EXCEEDED, Judged, Packet, Telegram
from sistap.records.record import Event
from sistap.wireshark.rows import FRAME, OTHER

WORST = 10  # moments in total
LOST = int(Flag.LOST_BEFORE)


@dataclass(frozen=True)
class Moment:
    """A moment of interest in a packet; times in s."""

    kind: Kind
    number: int  # of the packet
    command_in: int | None  # number of the earlier packet in which it began
    time_s: float  # of the packet, as in Wireshark's list
    start_s: float
    end_s: float
    judged: Judged | None
    uncertainty_s: float | None
    has_times: bool  # whether its characters have times
    talker: int | None = None
    listener: int | None = None
    service: int | None = None

    @property
    def filter(self) -> str:
        """Return the display filter that finds it."""
        if self.command_in is None:
            return f"frame.number == {self.number}"
        return f"frame.number in {{{self.command_in}, {self.number}}}"


@dataclass(frozen=True)
class Kind:
    """One way in which a moment can be bad."""

    name: str  # as in JSON
    short: str
    title: str
    filter: str  # finds all of them
    of_telegram: Callable[[Telegram], Judged | bool | None] | None = None
    of_packet: Callable[[Packet], bool] | None = None
    is_fault: bool = True  # False: it is only the largest normal value


def _exceeded(judged: Judged | None) -> Judged | None:
    return judged if judged and judged.verdict == EXCEEDED else None


def _not_exceeded(judged: Judged | None) -> Judged | None:
    return judged if judged and judged.verdict != EXCEEDED else None


KINDS = (
    Kind(
        "tza_exceeded",
        "TzA exceeded",
        "Interval in a telegram longer than TzA",
        "sis.tza.verdict == 1",
        lambda telegram: _exceeded(telegram.pause),
    ),
    Kind(
        "trs_exceeded",
        "TrS exceeded",
        "Reaction later than TrS",
        "sis.trs.verdict == 1",
        lambda telegram: _exceeded(telegram.reaction),
    ),
    Kind(
        "tmas_exceeded",
        "Tmas exceeded",
        "Master control word later than Tmas",
        "sis.tmas.verdict == 1",
        lambda telegram: _exceeded(telegram.cycle),
    ),
    Kind(
        "unanswered",
        "no reaction",
        "Command without a reaction",
        "sis.command.unanswered",
        lambda telegram: telegram.unanswered,
    ),
    Kind(
        "error_reaction",
        "reactions with an error",
        "Reaction with an error",
        'sis.status > 0 && sis.checksum.status == "Good"',
        lambda telegram: telegram.good and telegram.is_reaction and bool(telegram.status),
    ),
    Kind(
        "damaged",
        "damaged",
        "Damaged telegram",
        'sis && !(sis.checksum.status == "Good")',
        lambda telegram: not telegram.good,
    ),
    Kind(
        "line_error",
        "line error",
        "Error or break on the line",
        "sertap.error.character || sertap.error.break || sertap.error.unlocated",
        of_packet=lambda packet: bool(packet.errors & ~LOST),
    ),
    Kind(
        "lost",
        "lost",
        "Characters lost before the tap could read them",
        "sertap.error.lost || sertap.event == 3",
        of_packet=lambda packet: bool(packet.errors & LOST) or packet.event == Event.CHARACTERS_LOST,
    ),
    Kind(
        "longest_pause",
        "longest interval",
        "Longest interval in a telegram",
        "sertap.interval.max",
        lambda telegram: _not_exceeded(telegram.pause),
        is_fault=False,
    ),
    Kind(
        "slowest_reaction",
        "slowest reaction",
        "Slowest reaction",
        "sis.reaction_time",
        lambda telegram: _not_exceeded(telegram.reaction),
        is_fault=False,
    ),
)
_OF_PACKET = [(kind, kind.of_packet) for kind in KINDS if kind.of_packet]
_OF_TELEGRAM = [(kind, kind.of_telegram) for kind in KINDS if kind.of_telegram]
# Kinds whose time lies before their packet: they begin with the end of the command.
_FROM_COMMAND = {"trs_exceeded", "slowest_reaction"}


class Moments:
    """The worst of each kind, and how many there were."""

    def __init__(self) -> None:
        self.counts = {kind.name: 0 for kind in KINDS}
        self._worst: dict[str, list[tuple[float, int, Moment]]] = {kind.name: [] for kind in KINDS}
        self._order = itertools.count(0, -1)  # of two equal ones the first is kept

    def add(self, packet: Packet) -> Iterator[Kind]:
        """Look at a packet; return the kinds of fault in it."""
        for kind, of_packet in _OF_PACKET:
            if of_packet(packet):
                self._keep(packet, None, kind, None)
                yield kind
        telegrams = packet.telegrams
        for kind, of_telegram in _OF_TELEGRAM if telegrams else ():
            found = False
            for telegram in telegrams:
                if judged := of_telegram(telegram):
                    found = True
                    self._keep(packet, telegram, kind, judged if isinstance(judged, Judged) else None)
            if found and kind.is_fault:
                yield kind

    def _keep(self, packet: Packet, telegram: Telegram | None, kind: Kind, judged: Judged | None) -> None:
        self.counts[kind.name] += 1
        worst = self._worst[kind.name]
        rank = _rank(kind, judged)
        if len(worst) == WORST and rank <= worst[0][0]:
            return
        entry = (rank, next(self._order), _moment(packet, telegram, kind, judged))
        (heapq.heappushpop if len(worst) == WORST else heapq.heappush)(worst, entry)

    def worst(self) -> list[Moment]:
        """Return the worst ones: first the worst of each kind, then the second of each, and so on."""
        ranked = [[entry[-1] for entry in sorted(self._worst[kind.name], reverse=True)] for kind in KINDS]
        rounds = itertools.zip_longest(*ranked)
        return [moment for moments in rounds for moment in moments if moment][:WORST]


def _rank(kind: Kind, judged: Judged | None) -> float:
    """Return how bad it is within its kind: by how much it exceeds the limit, else how long it took."""
    if judged is None:
        return 0.0
    return judged.time_s / judged.limit_s if kind.is_fault and judged.limit_s else judged.time_s


def _moment(packet: Packet, telegram: Telegram | None, kind: Kind, judged: Judged | None) -> Moment:
    from_command = judged is not None and kind.name in _FROM_COMMAND
    return Moment(
        kind=kind,
        number=packet.number,
        command_in=telegram.command_in if telegram and from_command else None,
        time_s=packet.time_s,
        start_s=packet.time_s - (judged.time_s if judged and from_command else 0.0),
        end_s=packet.end_s,
        judged=judged,
        uncertainty_s=packet.uncertainty_s,
        has_times=packet.type in (FRAME, OTHER),
        talker=telegram.talker if telegram else None,
        listener=telegram.listener if telegram else None,
        service=telegram.service if telegram else None,
    )
