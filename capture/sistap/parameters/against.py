# SPDX-License-Identifier: GPL-2.0-or-later
"""What differs from a backup: the last value of each parameter in a capture, beside the saved one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from sistap.accesses.access import Access, Parameter
from sistap.accesses.listing import MOST, Place
from sistap.parameters.backup import Drive, Saved
from sistap.parameters.reading import Found
from sistap.parameters.values import decoded, same, without_lengths
from sistap.sis.telegram import shown


class _Last(NamedTuple):
    """The last access that had all data, and the last write before it."""

    place: Place
    access: Access
    written: Found | None


def lines(saved: Sequence[tuple[str, Drive]], accesses: Iterable[Found]) -> Iterator[str]:
    """Yield a line for each parameter that differs; the drives have their stations, "" is every station."""
    backups = {station: {one.ident: one for one in drive.parameters} for station, drive in saved}
    compared = differing = 0
    for parameter, last in sorted(_last(accesses).items()):
        backup = backups.get(parameter.station, backups.get("", {})).get(parameter.ident)
        data = bytes.fromhex(last.access.data or "")
        if backup is None or backup.data is None or backup.attribute.is_read_only:
            continue
        compared += 1
        now = without_lengths(backup.attribute, data)
        if not same(backup.attribute, now, backup.data):
            differing += 1
            yield _line(parameter, last, backup, now)
    yield f"{differing} of {compared} parameters differ from the backup"


def _last(accesses: Iterable[Found]) -> dict[Parameter, _Last]:
    """Return the last value of each parameter, in bounded memory."""
    found: dict[Parameter, _Last] = {}
    for one in accesses:
        place, access = one
        before = found.get(access.parameter)
        if access.data is None or access.error or (before is None and len(found) == MOST):
            continue
        found[access.parameter] = _Last(place, access, one if access.is_write else before and before.written)
    return found


def _line(parameter: Parameter, last: _Last, backup: Saved, data: bytes) -> str:
    unit = f" {shown(backup.unit)}" if backup.unit and backup.attribute.has_unit else ""
    now = decoded(backup.attribute, data)
    then = decoded(backup.attribute, backup.data or b"")
    value = last.access.value if now is None else f"{shown(now)}{unit}"
    words = [f"{parameter.station} device {parameter.device}", f"{parameter.ident} ({shown(backup.name)})"]
    words.append(f"{shown(then or '')}{unit} -> {value}")
    if last.written:
        words.append(f"written by {last.written.access.by} in packet {last.written.place.packet}")
    else:
        words.append(f"read in packet {last.place.packet}")
    return "  ".join(words)
