# SPDX-License-Identifier: GPL-2.0-or-later
"""All values as a wide table in CSV: a line for each time, a column for each parameter, for curves in a spreadsheet."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator

from sistap.commands.parameters.reading import FoundAccess
from sistap.commands.parameters.writing import csv_line, time_text
from sistap.dissected.accesses.access import Access, Parameter


class _Values:
    """The values of all parameters, about 40 bytes each. The first line of the table names all columns."""

    def __init__(self) -> None:
        self.latest: dict[Parameter, Access] = {}  # in the order of the columns
        self._numbers: dict[Parameter, int] = {}
        self._times_s, self._columns = array("d"), array("I")
        self._values: list[float | str] = []

    def add(self, found: FoundAccess) -> None:
        """Take an accepted access."""
        access = found.access
        value = access.plain
        if value is None:
            return
        self.latest[access.parameter] = access
        self._columns.append(self._numbers.setdefault(access.parameter, len(self._numbers)))
        self._times_s.append(found.place.epoch_s)
        self._values.append(value)

    def lines(self) -> Iterator[str]:
        """Yield a line for each packet with values; cells of other parameters are empty."""
        row: list[float | str] = []
        before_s = -1.0
        for time_s, column, value in zip(self._times_s, self._columns, self._values, strict=True):
            if not row or time_s != before_s or row[column] != "":
                if row:
                    yield csv_line((time_text(before_s), *row))
                row, before_s = [""] * len(self.latest), time_s
            row[column] = value
        if row:
            yield csv_line((time_text(before_s), *row))


def lines(accesses: Iterable[FoundAccess]) -> Iterator[str]:
    """Yield the lines of CSV. There are none if no value was read or written."""
    values = _Values()
    for found in accesses:
        values.add(found)
    if values.latest:
        has_ports = len({parameter.port for parameter in values.latest}) > 1
        yield csv_line(("time", *(_head(access, has_port=has_ports) for access in values.latest.values())))
    yield from values.lines()


def _head(access: Access, *, has_port: bool) -> str:
    """Return the name of a column."""
    port, station, device, ident = access.parameter
    unit = f"({access.unit})" if access.unit else ""
    return " ".join(filter(None, (port if has_port else "", f"{station} device {device}", ident, access.name, unit)))
