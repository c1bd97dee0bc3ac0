# SPDX-License-Identifier: GPL-2.0-or-later
"""A device whose parameters a station makes accessible: a control itself, or a drive (fig. 8-2)."""

from __future__ import annotations

from collections.abc import Iterable

from sistap.bus.devices.parameters import AccessError, Element, Parameter, ident
from sistap.bus.devices.phases import Phases
from sistap.bus.devices.transfers import Channel

_IDENT_NUMBER_NOT_AVAILABLE = 0x1001
_OUTSIDE_MODULO = 0x700C


class Device:
    """Parameters, the channel to them, and their phase."""

    def __init__(self, parameters: Iterable[Parameter], modulo: dict[str, str] | None = None) -> None:
        """Switch it on in no phase; its owner sets one through `phases`.

        `modulo` maps a parameter to the one whose value is its upper limit.
        """
        self.parameters = {ident(parameter.ident): parameter for parameter in parameters}
        self.channel = Channel()
        self.phases: Phases
        self._modulo = modulo or {}

    def join(self, phases: Phases) -> None:
        """Follow these phases; a switch interrupts what is under way on the channel."""
        self.phases = phases
        phases.on_switch.append(self.channel.interrupt)

    def named(self, name: str) -> Parameter | None:
        """Return a parameter by its name; None if the device has none."""
        return self.parameters.get(ident(name))

    def find(self, number: bytes) -> Parameter:
        """Return a parameter by its type and number. May raise AccessError."""
        parameter = self.parameters.get(number)
        if parameter is None:
            raise AccessError(_IDENT_NUMBER_NOT_AVAILABLE)
        return parameter

    def read(self, number: bytes, element: Element, now_ns: int) -> bytes:
        """Return an element of a parameter. May raise AccessError."""
        self.refresh(now_ns)
        return self.find(number).read(element)

    def write(self, number: bytes, element: Element, data: bytes, now_ns: int) -> bytes:
        """Write an element; return the data status if it is the ident number. May raise AccessError."""
        self.refresh(now_ns)
        parameter = self.find(number)
        if element == Element.DATA:
            self._check_modulo(parameter, data)
        status = parameter.write(element, data, self.phases.at(now_ns), now_ns)
        if element == Element.DATA:
            self.written(parameter, now_ns)
        return status

    def refresh(self, now_ns: int) -> None:
        """Update what changes by itself, before an access."""

    def written(self, parameter: Parameter, now_ns: int) -> None:
        """React to new operating data."""

    def restart(self) -> None:
        """Return to the state after switching off and on."""
        self.channel.cancel()

    def _check_modulo(self, parameter: Parameter, data: bytes) -> None:
        """Check that a position of a modulo axis is from zero to the modulo value (fig. 8-48)."""
        limit = self.named(self._modulo.get(parameter.ident, parameter.ident))
        if limit is None or limit is parameter or len(data) != parameter.element_size:
            return
        if not 0 <= parameter.value(data) <= limit.value(limit.data):
            raise AccessError(_OUTSIDE_MODULO)
