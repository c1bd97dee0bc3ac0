# SPDX-License-Identifier: GPL-2.0-or-later
"""Service 0x03: the times and the rate of a station's line, set and accepted (IF02 chapter 6)."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

from sisbus.service import Request, Service, ServiceFailed, ServiceRefused, Status, Subservice
from sistap.tap.sis import initialization
from sistap.tap.sis.initialization import Setting
from sistap.tap.sis.rates import RATES, rate_of


def settings(body: bytes) -> list[Setting]:
    """Split a body into subservices.

    Raise ServiceRefused if no layout consumes all bytes, with the status of the layout that went further. Refuse also
    if both do and differ: then the meaning is ambiguous.
    """
    if (found := initialization.settings(body)) is not None:
        return found
    furthest = max(initialization.layouts(body), key=lambda layout: layout.end)
    raise ServiceRefused(furthest.misfit or Status.INVALID_TELEGRAM)


_MS = 1_000_000
_LONGEST_TEST_MS = 0x7FFF  # a timer of 16 bits that counts half milliseconds

# Error bytes of 0x07 and 0x08 (chapter 6.3).
_NOT_SUPPORTED = b"\x00"
_TEST_TOO_LONG = b"\x01"


class Timing(NamedTuple):
    """The settings of a station's line. The times are in ms; None: never set, and there are no defaults."""

    baud: int = RATES[0]
    trs: int | None = None  # slave reaction time
    tza: int | None = None  # character interval
    tmas: int | None = None  # cycle of the master control word


class _Test(NamedTuple):
    baud: int
    begin_ns: int
    end_ns: int

    def holds(self, now_ns: int) -> bool:
        """Tell whether a test holds: not at its very beginning, because the reaction still comes at the former rate."""
        return self.begin_ns < now_ns < self.end_ns


class Initialization:
    """The settings that a station was told for its line."""

    def __init__(self, rates: Collection[int] = RATES) -> None:
        """Switch it on; `rates` are those that it accepts."""
        self._rates = rates
        self.power_on()
        self._subservices: dict[int, Subservice] = {
            0x01: lambda data, now_ns: self._set("trs", data),
            0x02: lambda data, now_ns: self._set("tza", data),
            0x03: lambda data, now_ns: self._set("tmas", data),
            0x07: self._set_rate,
            0x08: self._test_rate,
            0xFF: self._accept,
        }
        self.service = Service(2, 2, self._execute)

    def power_on(self, baud: int = RATES[0]) -> None:
        """Forget all settings; `baud` is the rate after power-on (9600 unless the station keeps another)."""
        self.accepted = Timing(baud)
        self._told: dict[str, int] = {}
        self._test: _Test | None = None

    def timing(self, now_ns: int) -> Timing:
        """Return the present settings, with the rate of a test while it lasts."""
        if self._test and self._test.holds(now_ns):
            return self.accepted._replace(baud=self._test.baud)
        return self.accepted

    def test_ends_ns(self, now_ns: int) -> int | None:
        """Return when the running test of a rate ends; None without one."""
        return self._test.end_ns if self._test and now_ns < self._test.end_ns else None

    def _execute(self, request: Request) -> bytes:
        """Execute all subservices of a telegram up to one that fails; the reaction names that one.

        No document has the reaction to several of them. It is the command without the data, as for a single one.
        """
        said = settings(request.body)
        for setting in said:
            try:
                self._subservices[setting.subservice](setting.data, request.now_ns)
            except ServiceFailed as failed:
                header = request.body[:1] + bytes([setting.subservice])
                raise ServiceFailed(failed.code, failed.status, header) from None
        return b"".join(setting.header for setting in said)

    def _set(self, name: str, data: bytes) -> bytes:
        self._told[name] = int.from_bytes(data[:2], "little")
        return b""

    def _set_rate(self, data: bytes, now_ns: int) -> bytes:
        self._told["baud"] = self._rate(data[0])
        return b""

    def _test_rate(self, data: bytes, now_ns: int) -> bytes:
        duration_ms, baud = int.from_bytes(data[:2], "little"), self._rate(data[2])
        if duration_ms > _LONGEST_TEST_MS:
            raise ServiceFailed(_TEST_TOO_LONG)
        self._test = _Test(baud, now_ns, now_ns + duration_ms * _MS)
        return b""

    def _accept(self, data: bytes, now_ns: int) -> bytes:
        self.accepted = self.accepted._replace(**self._told)
        self._told = {}
        self._test = None
        return b""

    def _rate(self, mask: int) -> int:
        baud = rate_of(mask)
        if baud is None or baud not in self._rates:
            raise ServiceFailed(_NOT_SUPPORTED)
        return baud
