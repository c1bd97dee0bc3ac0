# SPDX-License-Identifier: GPL-2.0-or-later
"""What drives say of themselves: faults, warnings, whether their position is referenced."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from sistap.dissected.accesses.access import Access
from sistap.dissected.episodes.episode import Hit
from sistap.dissected.episodes.masters import drive_of, station_of
from sistap.dissected.episodes.readings import ValueReading, class_of, code_of
from sistap.dissected.episodes.standard import FORMS
from sistap.dissected.packets.dissection import Packet

STILL = "still so when last read"
_KINDS = {"F": "fault", "E": "warning"}
_SHUT_DOWN = 0x2000  # bit 13 of the drive status: by an error of class 1
_REFERENCED = 0x0001


@dataclass
class _Drive:
    """What a drive has told last, by source."""

    told: dict[str, Hit] = field(default_factory=dict)  # what lasts
    was: dict[str, str] = field(default_factory=dict)  # what it said before, by source
    was_referenced: bool = False


class Diagnoses:
    """Those of a bus."""

    def __init__(self) -> None:
        """Begin with none."""
        self._drives: dict[tuple[str, int], _Drive] = {}
        self._begun: list[Hit] = []

    def add(self, packet: Packet, access: Access, said: ValueReading) -> Iterable[Hit]:
        """Take a reading of one of LOOKED_AT; return what ends with it."""
        ident = access.parameter.ident
        drive = self._drives.setdefault(drive_of(access.parameter), _Drive())
        kind, what = LOOKED_AT[ident](drive, ident, said)
        other = drive.told.get(_SAME.get(ident, ""))
        if other and code_of(ident, said.text) not in ("", other.topic):
            return [drive.told.pop(_SAME[ident]), *self.add(packet, access, said)]
        told = drive.told.pop(ident, None)
        lasting = told and told._replace(to_s=packet.epoch_s)
        if lasting and (lasting.kind, lasting.topic) == (kind, what):
            drive.told[ident] = lasting
            return ()
        if kind:
            before = drive.was.get(ident, "")
            detail = f"{what} ({ident}, before {before})" if before else f"{what} ({ident})"
            place = packet.number, packet.epoch_s, packet.epoch_s, station_of(access.parameter)
            drive.told[ident] = Hit(kind, *place, "", detail, port=packet.interface, topic=what)
            self._begun.append(drive.told[ident])
        drive.was[ident] = code_of(ident, said.text)
        return [lasting] if lasting else []

    def begun(self) -> Iterable[Hit]:
        """Return what has begun since it was asked last."""
        begun, self._begun = self._begun, []
        return begun

    def finish(self) -> Iterator[Hit]:
        """Yield what lasts to the end."""
        for drive in self._drives.values():
            for hit in drive.told.values():
                yield hit._replace(outcome=STILL)


_SAME = {"S-0-0390": "S-0-0095", "S-0-0095": "S-0-0390"}  # one diagnosis: what was read last is true
_Said = tuple[str, str]  # kind or "", and what


def _diagnosis(drive: _Drive, ident: str, said: ValueReading) -> _Said:
    code = code_of(ident, said.text)
    kind = _KINDS.get(class_of(code), "")
    return (kind, code) if kind else ("", "")


def _error_bits(drive: _Drive, ident: str, said: ValueReading) -> _Said:
    return ("fault", f"class 1 diagnostic {said.text}") if said.bits else ("", "")


def _warning_bits(drive: _Drive, ident: str, said: ValueReading) -> _Said:
    return ("warning", f"class 2 diagnostic {said.text}") if said.bits else ("", "")


def _status(drive: _Drive, ident: str, said: ValueReading) -> _Said:
    return ("fault", "shut down by an error: drive status bit 13") if (said.bits or 0) & _SHUT_DOWN else ("", "")


def _referenced(drive: _Drive, ident: str, said: ValueReading) -> _Said:
    """A drive that was never referenced is not homed yet: no fault."""
    if said.bits is None:
        return "", ""
    is_referenced = bool(said.bits & _REFERENCED)
    drive.was_referenced |= is_referenced
    return (
        ("homing", "its position is no longer referenced") if drive.was_referenced and not is_referenced else ("", "")
    )


_BY_FORM: Mapping[str, Callable[[_Drive, str, ValueReading], _Said]] = {
    "diagnosis": _diagnosis,
    "diagnosis_text": _diagnosis,
    "error_bits": _error_bits,
    "warning_bits": _warning_bits,
    "status_word": _status,
    "referenced": _referenced,
}
LOOKED_AT = {ident: _BY_FORM[form] for ident, form in FORMS.items() if form in _BY_FORM}
