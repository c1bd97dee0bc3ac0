# SPDX-License-Identifier: GPL-2.0-or-later
"""All values as MF4, the file of measurements by ASAM: a channel for each parameter of each station."""

from __future__ import annotations

import io
from array import array
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from typing import Any, BinaryIO

from sistap.commands.parameters.reading import Found
from sistap.commands.parameters.wide import column
from sistap.dissected.accesses.access import Access, Parameter
from sistap.tap.common.packages import needed
from sistap.tap.terminal.console import visible

_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class _Channel:
    """The values of a parameter that are numbers, or those that are texts."""

    def __init__(self) -> None:
        self.latest: Access  # it has the name and the unit
        self.times_s = array("d")
        self.values: list[float | str] = []


class Measurement:
    """The values of all parameters, on their way into a file."""

    def __init__(self) -> None:
        """Begin with none. NotInstalled without the library asammdf."""
        self._asammdf = needed("asammdf")
        self._channels: dict[tuple[Parameter, type], _Channel] = {}

    @property
    def empty(self) -> bool:
        """Tell whether there is no value."""
        return not self._channels

    def add(self, accesses: Iterable[Found]) -> None:
        """Take all accepted accesses."""
        for place, access in accesses:
            value = access.plain
            if value is not None:
                channel = self._channels.setdefault((access.parameter, type(value)), _Channel())
                channel.latest = access
                channel.times_s.append(place.epoch_s)
                channel.values.append(value)

    def write(self, file: BinaryIO) -> None:
        """Write the file. Its time begins with the first value, in UTC."""
        start_s = min((time_s for channel in self._channels.values() for time_s in channel.times_s), default=0.0)
        has_port = len({parameter.port for parameter, _ in self._channels}) > 1
        with self._asammdf.MDF(version="4.10") as mdf:
            mdf.header.start_time = _EPOCH + timedelta(seconds=start_s)
            for channel in self._channels.values():  # a group each: they have times of their own
                mdf.append(self._signal(channel, start_s, has_port=has_port))
            whole = io.BytesIO()  # asammdf wants a file with a name, or one in memory
            mdf.save(whole)
        file.write(whole.getbuffer())

    def _signal(self, channel: _Channel, start_s: float, *, has_port: bool) -> Any:
        # The clock of a capture may have been set back: a channel has its values in the order of their times.
        times_s, values = zip(*sorted(zip(channel.times_s, channel.values, strict=True), key=_time), strict=True)
        return self._asammdf.Signal(
            values,
            [time_s - start_s for time_s in times_s],
            name=visible(column(channel.latest, has_port=has_port)),
            unit=visible(channel.latest.unit),
            encoding="utf-8",
        )


def _time(value: tuple[float, float | str]) -> float:
    return value[0]
