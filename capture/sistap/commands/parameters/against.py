# SPDX-License-Identifier: GPL-2.0-or-later
"""What differs from a backup: the last value of each parameter in a capture, beside the saved one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from sistap.commands.parameters.backup import Drive, Saved
from sistap.commands.parameters.reading import FoundAccess
from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.accesses.listing import MOST, AccessPlace
from sistap.dissected.telegrams.values import Unreadable, decoded, encoded, same, without_lengths
from sistap.tap.sis.telegram import shown
from sistap.tap.terminal.exits import Refusal


class _Last(NamedTuple):
    """The last access that had all data, and the last write before it."""

    place: AccessPlace
    access: Access
    written: FoundAccess | None


def lines(saved: Sequence[tuple[str, Drive]], accesses: Iterable[FoundAccess]) -> Iterator[str]:
    """Yield a line for each parameter that differs; the drives have their stations, "" is every station.

    Raise Refusal if nothing was compared: that is not the same as no difference.
    """
    backups = {station: {one.ident: one for one in drive.parameters} for station, drive in saved}
    found = _last(accesses)
    compared: list[str] = []  # the station of each parameter
    differing = 0
    for parameter, last in sorted(found.items()):
        backup = backups.get(parameter.station, backups.get("", {})).get(parameter.ident)
        if backup is None or backup.data is None or backup.attribute.is_read_only:
            continue
        compared.append(parameter.station)
        now, shown_now = _now(backup, last.access)
        if now is None or not same(backup.attribute, now, backup.data):
            differing += 1
            yield _line(parameter, last, backup, shown_now or last.access.value)
    if not compared:
        raise Refusal(_why_nothing(backups, found))
    yield f"{differing} of {len(compared)} parameters of {_stations(compared)} differ from the backup"


def _stations(stations: Iterable[str]) -> str:
    """Return them in words."""
    several = sorted(set(stations), key=lambda station: (len(station), station))
    return f"station{'' if len(several) == 1 else 's'} {', '.join(several)}"


def _why_nothing(backups: Mapping[str, object], found: Iterable[Parameter]) -> str:
    nothing = "nothing was compared: "
    stations = {parameter.station for parameter in found}
    if not stations:
        return f"{nothing}the capture has no value of a parameter"
    if "" in backups or stations & backups.keys():
        return f"{nothing}the capture has no value of a parameter that the backup has and a master can write"
    has = f"the capture has values of {_stations(stations)}"
    return f"{nothing}the backup is of {_stations(backups)}, and {has}: choose with --station"


def _now(backup: Saved, access: Access) -> tuple[bytes | None, str]:
    """Return the value on the bus: its bytes (None: it is no value of its attribute), and as a backup writes it.

    The text is empty if the bytes do not fit the attribute.
    """
    attribute = backup.attribute
    if access.data is not None:
        data = without_lengths(attribute, bytes.fromhex(access.data))
        return data, _as_saved(backup, data)
    text = access.text or ""
    try:
        texts = [text] if attribute.is_text or not attribute.is_list else text.split(", ")
        elements = [encoded(attribute, one) for one in texts]
    except Unreadable:
        return None, shown(text)
    whole = b"".join(one for one in elements if one is not None)
    return (whole, _as_saved(backup, whole)) if None not in elements else (None, shown(text))


def _as_saved(backup: Saved, data: bytes) -> str:
    """Return bytes as a backup writes them, with the unit; empty if they do not fit the attribute."""
    text = decoded(backup.attribute, data)
    unit = f" {backup.unit}" if backup.unit and backup.attribute.has_unit else ""
    return shown(f"{text}{unit}") if text else ""


def _last(accesses: Iterable[FoundAccess]) -> dict[Parameter, _Last]:
    """Return the last value of each parameter, in bounded memory."""
    found: dict[Parameter, _Last] = {}
    for one in accesses:
        place, access = one
        before = found.get(access.parameter)
        if access.whole is None or access.error or (before is None and len(found) == MOST):
            continue
        found[access.parameter] = _Last(place, access, one if access.is_write else before and before.written)
    return found


def _line(parameter: Parameter, last: _Last, backup: Saved, now: str) -> str:
    words = [f"{parameter.station} device {parameter.device}", f"{parameter.ident} ({shown(backup.name)})"]
    words.append(f"{_as_saved(backup, backup.data or b'')} -> {now}")
    if last.written:
        words.append(f"written by {last.written.access.by} in packet {last.written.place.packet}")
    else:
        words.append(f"read in packet {last.place.packet}")
    return "  ".join(words)
