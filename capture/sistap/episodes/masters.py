# SPDX-License-Identifier: GPL-2.0-or-later
"""Who asks on the bus, and what they write."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator

from sistap.accesses.access import Access, Parameter
from sistap.accesses.listing import MOST, Present, order
from sistap.episodes.episode import ARROW, Hit
from sistap.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.packets.dissection import Packet


def station_of(parameter: Parameter) -> int:
    """Return the station that the master addresses; others may be behind it: `3/2/8`."""
    return int(parameter.station.partition("/")[0])


class Masters:
    """The masters of a port."""

    def __init__(self, thresholds: Thresholds = THRESHOLDS, before: Masters | None = None) -> None:
        """Begin with those that asked in a good capture, or with none."""
        self._usual: set[int] = set(before.asked) if before else set()
        self._learning = 0 if self._usual else thresholds.learning_commands
        self.asked: set[int] = set()

    def is_new(self, master: int | None) -> bool:
        """Tell whether it asked neither at the beginning nor in the good capture. Who asks in ASCII is not known."""
        return master is not None and master not in self._usual

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return commands of a new master."""
        hits: list[Hit] = []
        for telegram in packet.telegrams:
            if not telegram.good or telegram.is_reaction or telegram.talker is None:
                continue
            self.asked.add(telegram.talker)
            if self._learning:
                self._learning -= 1
                self._usual.add(telegram.talker)
            elif self.is_new(telegram.talker) and telegram.listener not in self._usual:  # to a master: a token
                place = packet.number, packet.epoch_s, packet.ended_s, telegram.listener
                detail, topic = f"asked by new master {telegram.talker}", str(telegram.talker)
                hits.append(Hit("master", *place, detail=detail, port=packet.interface, topic=topic))
        return hits


class Writes:
    """What is written by somebody new, or is usually not written."""

    def __init__(self, masters: Masters, thresholds: Thresholds = THRESHOLDS, before: Writes | None = None) -> None:
        """Begin with nothing written; what was written in a good capture is usually written."""
        self._thresholds = thresholds
        self._masters = masters
        self._usual: set[Parameter] = before.written if before else set()
        self._known = before.values() if before else {}
        self.written: set[Parameter] = set()  # without the port: tomorrow the tap may be at another one
        self._present: dict[Parameter, Present] = {}
        self._told: dict[str, Present] = {}  # by the topic of its hits
        self._rare: defaultdict[Parameter, list[Hit]] = defaultdict(list)  # the first writes of usual masters
        self.first: list[Hit] = []  # those in the last packet that changed what was never written

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return writes of new masters."""
        hits: list[Hit] = []
        if self.first:
            self.first = []
        for access in packet.accesses:
            if access.error:
                continue
            present = self._of(access.parameter)
            before = present.value if present else None
            is_change = present is not None and present.follow(access)
            if not access.is_write:
                continue
            parameter = access.parameter._replace(port="")
            is_first = parameter not in self.written and len(self.written) < MOST
            if is_first:
                self.written.add(parameter)
            was = before or self._known.get(parameter) if is_change else access.value
            hit = self._hit(packet, access, was)
            is_new = self._masters.is_new(access.master)
            if is_first and is_change and not is_new:
                self.first.append(hit)
            if is_new:
                hits.append(hit)
            elif (
                parameter not in self._usual
                and len(self._rare) < MOST
                and len(self._rare[access.parameter]) <= self._thresholds.rare_writes
            ):
                self._rare[access.parameter].append(hit if is_change else hit._replace(kind=""))
        return hits

    def _of(self, parameter: Parameter) -> Present | None:
        present = self._present.get(parameter)
        if present is None and len(self._present) < MOST:
            present = self._present[parameter] = Present(parameter)
        return present

    def values(self) -> dict[Parameter, str | None]:
        """Return the values known at the end, without ports."""
        ordered = sorted(self._present.values(), key=lambda present: order(present.parameter))
        return self._known | {present.parameter._replace(port=""): present.value for present in ordered}

    def outcome(self, hit: Hit) -> str:
        """Say what the parameter of a write has at the end; nothing if nobody knows."""
        written = hit.detail.rpartition(" by ")[0].rpartition(ARROW)[2]
        present = self._told.get(hit.topic)
        if present is None or present.value is None:
            return ""
        return "still set at the end" if present.value == written else f"at the end {present.value}"

    def _hit(self, packet: Packet, access: Access, before: str | None) -> Hit:
        was = f"{before}{ARROW}" if before is not None else ""
        who = "new " if self._masters.is_new(access.master) else ""
        topic = f"{access.parameter} {access.master}"
        present = self._of(access.parameter)
        if present:
            self._told[topic] = present
        return Hit(
            "write",
            packet.number,
            packet.epoch_s,
            packet.ended_s,
            station_of(access.parameter),
            access.parameter.ident,
            f"{was}{access.value or 'another value'} by {who}{'' if access.master is None else 'master '}{access.by}",
            access.number,
            port=packet.interface,
            topic=topic,
        )

    def finish(self) -> Iterator[Hit]:
        """Yield changes by usual masters of what is rarely written."""
        for hits in self._rare.values():
            if len(hits) <= self._thresholds.rare_writes:
                yield from (hit._replace(severity=Severity.NOTE) for hit in hits if hit.kind)
