# SPDX-License-Identifier: GPL-2.0-or-later
"""A device whose parameters a station makes accessible: a control itself, or a drive (fig. 8-2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from sisbus.devices.parameters import LAST, NOT_AVAILABLE, OUTSIDE_MODULO, AccessError, Element, Parameter, ident
from sisbus.devices.phases import Phases
from sisbus.service import ChannelError, Request, ServiceFailed, ServiceRefused, Status

HEADER = 5  # control byte, device, parameter
SEGMENT = 4  # bytes of list offset and length, after the header of a service for parts of lists
_READ_SEGMENT = 0x1  # low half of the service
_OCCUPIED = 0x800C  # as a code of a parameter (IndraDrive)

# No document defines when an abandoned transfer ends. A master that was switched off must not block the channel for
# good.
ABANDONED_NS = 10_000_000_000


@dataclass
class Transfer:
    """A transfer under way. Its next command has the same service, sender and header, except control bit 2."""

    service: int
    sender: int
    header: bytes
    data: bytes  # still to be read, or written so far
    last_ns: int = 0  # time of its last piece
    cancelled: bool = False  # by something more important than its master

    @classmethod
    def begun(cls, request: Request, data: bytes) -> Transfer:
        """Return the transfer that a command begins."""
        return cls(request.service, request.sender, _header(request), data, request.now_ns)


class Channel:
    """The channel to a device's parameters."""

    def __init__(self) -> None:
        self.transfer: Transfer | None = None

    def enter(self, request: Request) -> Transfer | None:
        """Admit a command; return the transfer that it continues, None if none is under way.

        If only one of service, sender and header differs, the command is a wrong continuation. If more differ, it is a
        different access and must wait. Raises ServiceRefused, ServiceFailed or AccessError; the transfer continues.
        """
        transfer = self.transfer
        if transfer is None or request.now_ns - transfer.last_ns > ABANDONED_NS:
            self.transfer = None
            return None
        same_header = transfer.header == _header(request)
        other = (transfer.service != request.service) + (transfer.sender != request.sender) + (not same_header)
        if other == 1:
            raise ServiceRefused(Status.INVALID_SEQUENCE)
        if other:
            if transfer.header[1:HEADER] == request.body[1:HEADER]:
                raise AccessError(_OCCUPIED)
            raise ServiceFailed.in_channel(ChannelError.STILL_ACTIVE)
        if transfer.cancelled:
            self.transfer = None
            raise ServiceFailed.in_channel(ChannelError.CANCELLED)
        transfer.last_ns = request.now_ns
        return transfer

    def cancel(self, service: int | None = None) -> None:
        """End what a master cancels: any transfer, or only that of a service."""
        if self.transfer and service in (None, self.transfer.service):
            self.transfer = None

    def interrupt(self) -> None:
        """End the transfer in favour of something else; its master learns of it when it continues."""
        if self.transfer:
            self.transfer.cancelled = True


def _header(request: Request) -> bytes:
    """Return the part of the useful data header that all telegrams of a transfer share."""
    size = HEADER + SEGMENT if request.service & 0x0F == _READ_SEGMENT else HEADER
    return bytes([request.body[0] & ~LAST]) + request.body[1:size]


# -- The device ------------------------------------------------------------------------------------------------------


# Raises ServiceFailed or AccessError while access is not possible.
Gate = Callable[[Request], None]


class Device:
    """Parameters, the channel to them with a gate before it, and their phase."""

    def __init__(self, parameters: Iterable[Parameter], modulo: dict[str, str] | None = None) -> None:
        """Switch it on in no phase; its owner sets one through `phases`.

        `modulo` maps a parameter to the one whose value is its upper limit.
        """
        self.parameters = {ident(parameter.ident): parameter for parameter in parameters}
        self.channel = Channel()
        self.phases: Phases
        self.gate: Gate = lambda request: None
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
            raise AccessError.of(Element.IDENT_NUMBER, NOT_AVAILABLE)
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
        if limit is None or limit is parameter or len(data) != parameter.attribute.size:
            return
        if not 0 <= parameter.value(data) <= limit.value(limit.data):
            raise AccessError.of(Element.DATA, OUTSIDE_MODULO)
