# SPDX-License-Identifier: GPL-2.0-or-later
"""What is written: by somebody new, by two masters against each other, or what is usually not written."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import MOST, Present, order
from sistap.dissected.episodes.episode import ARROW, Hit, numbers
from sistap.dissected.episodes.masters import Masters, station_of
from sistap.dissected.episodes.rules import THRESHOLDS, Severity, Thresholds
from sistap.dissected.episodes.standard import FORMS, LIMITS
from sistap.dissected.packets.dissection import Packet
from sistap.dissected.wireshark.rows import passes
from sistap.tap.sis.faults import WRITE

_RECIPE_S = 10.0  # writes of a recipe follow one another within this time
_RECIPE = 4  # parameters; fewer are told one by one
_CYCLIC = {"control_word", "bits"}  # of these, each value is written again and again
_RARE = {"write": Severity.NOTE}  # by a usual master
_TO_AND_FRO = 3  # changes of the author from which on two masters write against each other


@dataclass
class _Setting:
    """A parameter that was written."""

    master: int | None
    value: str
    whole: str | None
    is_read_as_written: bool = False
    turns: int = 0  # how often another master has written another value


class Writes:
    """Those of a bus."""

    def __init__(self, masters: Masters, thresholds: Thresholds = THRESHOLDS, before: Writes | None = None) -> None:
        """Begin with nothing written; what was written in a good capture is usually written."""
        self._thresholds = thresholds
        self._masters = masters
        self._usual: set[Parameter] = before.written if before else set()
        self._known = before.values() if before else {}
        self.written: set[Parameter] = set()  # without the port: tomorrow the tap may be at another one
        self._present: dict[Parameter, Present] = {}
        self._settings: dict[Parameter, _Setting] = {}
        self._told: dict[str, Present] = {}  # by the topic of its hits
        self._rare: defaultdict[Parameter, list[Hit]] = defaultdict(list)  # the first writes of usual masters
        self._begun: list[Hit] = []  # writes that changed what was never written
        self._row: list[Hit] = []  # writes of one master that follow one another
        self._recipes: deque[tuple[float, float]] = deque(maxlen=MOST)  # from when to when

    def add(self, packet: Packet) -> Iterable[Hit]:
        """Return writes that are unusual at once."""
        hits: list[Hit] = []
        for access in packet.accesses:
            if access.error:
                continue
            self._masters.count(access.master, is_write=access.is_write)
            present = self._of(access.parameter)
            before = present.value if present else None
            is_change = present is None or present.follow(access)
            if access.is_write:
                hits += self._write(packet, access, before, is_change=is_change)
            elif access.parameter in self._settings:
                hits += self._read(packet, access)
        return hits

    def unheard(self, packet: Packet) -> Iterable[Hit]:
        """Doubt what was written: nobody has listened for a while, or has heard whether a drive took another write."""
        lost = {
            (telegram.listener, telegram.columns.get("sis.parameter"))
            for telegram in packet.telegrams
            if telegram.unanswered and telegram.good and passes(WRITE.tests, telegram.columns)
        }
        idents = {ident for _, ident in lost}
        for parameter, setting in self._settings.items() if packet.is_unheard or lost else ():
            is_lost = parameter.ident in idents and (station_of(parameter), parameter.ident) in lost
            if packet.is_unheard or is_lost:
                setting.is_read_as_written = False
        return ()

    def _write(self, packet: Packet, access: Access, before: str | None, *, is_change: bool) -> Iterator[Hit]:
        parameter = access.parameter._replace(port="")
        is_first = parameter not in self.written and len(self.written) < MOST
        if is_first:
            self.written.add(parameter)
        was = before or self._known.get(parameter) if is_change else access.value
        is_new = self._masters.is_new(access.master)
        is_obeyed = FORMS.get(access.parameter.ident) in _CYCLIC
        if not is_obeyed:
            yield from self._turn(packet, access)
        if is_obeyed and not is_new:
            return
        if is_new:
            yield self._hit(packet, access, was)
            return
        yield from self._follow(packet, access)
        is_limit = access.parameter.ident in LIMITS
        if parameter in self._usual or (is_limit and not is_change) or not self._is_rare(access.parameter):
            return
        hit = self._hit(packet, access, was)._replace(kind="limit_write" if is_limit else "write")
        self._rare[access.parameter].append(hit if is_change else hit._replace(kind=""))
        if is_change and (is_first or is_limit):
            self._begun.append(hit)

    def _follow(self, packet: Packet, access: Access) -> Iterator[Hit]:
        """Follow writes in a row; yield those of a recipe, once it is over."""
        row = self._row
        if row and (packet.epoch_s - row[-1].from_s >= _RECIPE_S or row[-1].topic != access.by):
            yield from self._recipe()
        if len(self._row) < MOST:
            hit = self._place("recipe", packet, access, "")
            self._row.append(hit._replace(topic=access.by))

    def _recipe(self) -> Iterator[Hit]:
        row, self._row = self._row, []
        count = len({(hit.station, hit.parameter) for hit in row})
        if count < _RECIPE:
            return
        stations = numbers({hit.station for hit in row if hit.station is not None})
        detail = f"master {row[0].topic} wrote {count} parameters of {stations}"
        self._recipes.append((row[0].from_s, row[-1].from_s))
        yield Hit("recipe", row[0].packet, row[0].from_s, row[-1].to_s, None, "", detail, port=row[0].port)

    def _is_rare(self, parameter: Parameter) -> bool:
        is_known = parameter in self._rare or len(self._rare) < MOST
        return is_known and len(self._rare[parameter]) <= self._thresholds.rare_writes

    def _turn(self, packet: Packet, access: Access) -> Iterator[Hit]:
        """Note who wrote a parameter last. Yield a write against another master, from the third one on."""
        setting = self._settings.get(access.parameter)
        present = self._of(access.parameter)
        if present:
            self._told[str(access.parameter)] = present
        if setting is None:
            if len(self._settings) < MOST:
                self._settings[access.parameter] = _Setting(access.master, access.value, access.whole)
            return
        if access.master != setting.master and access.whole != setting.whole:
            setting.turns += 1
            other = f"master {setting.master} {setting.value}"
            if setting.turns >= _TO_AND_FRO:
                detail = f"{other}, master {access.by} {access.value}"
                yield self._place("conflict", packet, access, detail)
        setting.master, setting.value, setting.whole = access.master, access.value, access.whole
        setting.is_read_as_written = False

    def _read(self, packet: Packet, access: Access) -> Iterator[Hit]:
        """Yield a setting that is another without a write. Some drives round what is written."""
        setting = self._settings[access.parameter]
        if access.whole == setting.whole:
            setting.is_read_as_written = True
        elif setting.is_read_as_written:
            detail = f"{setting.value}{ARROW}{access.value}, nobody on this bus wrote it"
            yield self._place("other", packet, access, detail)._replace(worst=access.number)
            setting.value, setting.whole, setting.is_read_as_written = access.value, access.whole, False

    @staticmethod
    def _place(kind: str, packet: Packet, access: Access, detail: str) -> Hit:
        place = kind, packet.number, packet.epoch_s, packet.ended_s, station_of(access.parameter)
        return Hit(*place, access.parameter.ident, detail, port=packet.interface, topic=str(access.parameter))

    def _of(self, parameter: Parameter) -> Present | None:
        present = self._present.get(parameter)
        if present is None and len(self._present) < MOST:
            present = self._present[parameter] = Present(parameter)
        return present

    def values(self) -> dict[Parameter, str | None]:
        """Return the values known at the end, without ports."""
        ordered = sorted(self._present.values(), key=lambda present: order(present.parameter))
        return {present.parameter._replace(port=""): present.value for present in ordered}

    def outcome(self, hit: Hit) -> str:
        """Say what the parameter of a write has at the end; nothing if nobody knows."""
        written = hit.detail.rpartition(" by ")[0].rpartition(ARROW)[2]
        present = self._told.get(hit.topic)
        if present is None or present.value is None:
            return ""
        if hit.kind == "conflict":
            return f"at the end {present.value}"
        return "still set at the end" if present.value == written else f"at the end {present.value}"

    def _hit(self, packet: Packet, access: Access, before: str | None) -> Hit:
        was = f"{before}{ARROW}" if before is not None else ""
        who = "new " if self._masters.is_new(access.master) else ""
        present = self._of(access.parameter)
        value = f"{was}{access.value or 'another value'}"
        detail = f"{value} by {who}{'' if access.master is None else 'master '}{access.by}"
        hit = self._place("write", packet, access, detail)._replace(worst=access.number)
        topic = f"{access.parameter} {access.master}"
        if present:
            self._told[topic] = present
        return hit._replace(topic=topic)

    def begun(self) -> list[Hit]:
        """Return the writes of usual masters, since it was asked last, of what was never written."""
        begun, self._begun = self._begun, []
        return begun

    def finish(self) -> Iterator[Hit]:
        """Yield changes by usual masters of what is rarely written, but for those of a recipe."""
        yield from self._recipe()
        for hits in self._rare.values():
            if len(hits) > self._thresholds.rare_writes:
                continue
            for hit in hits:
                if hit.kind and not any(from_s <= hit.from_s <= to_s for from_s, to_s in self._recipes):
                    yield hit._replace(severity=_RARE.get(hit.kind))
