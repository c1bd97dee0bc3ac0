# SPDX-License-Identifier: GPL-2.0-or-later
"""Gates: refuse a command before it reaches the parameters of a device (IF02 chapter 8.9)."""

from __future__ import annotations

from collections.abc import Callable

from sistap.bus.devices.device import Device
from sistap.bus.devices.parameters import AccessError, Element
from sistap.bus.service import ChannelError, Request, ServiceFailed

# Raises ServiceFailed or AccessError while access is not possible.
Gate = Callable[[Request], None]

_CHANNEL_NOT_OPEN = 0x0001
_CHANNEL_BUSY = 0x8001
_NOT_ALLOWED = 0x00A0
_ELEMENT_NOT_ALLOWED = 0x00B0
_FIRST_WITH_CHANNEL = 2  # the phase from which on drives have a service channel


def to_drive(device: Device) -> Gate:
    """Guard a drive that is a station itself: its service channel is busy while its phase is switched."""

    def gate(request: Request) -> None:
        if device.phases.busy(request.now_ns):
            raise AccessError(_CHANNEL_BUSY)

    return gate


def to_control(*, refuses_elements: bool) -> Gate:
    """Guard a control. SYNAX refuses writes to elements other than data and ident number itself."""

    def gate(request: Request) -> None:
        writes, element = request.service & 0x0F >= 0xE, request.body[0] >> 3 & 7
        if refuses_elements and writes and element not in (Element.DATA, Element.IDENT_NUMBER):
            raise AccessError(_ELEMENT_NOT_ALLOWED)

    return gate


def through_control(device: Device, off: bool, *, initialization_mode: bool) -> Gate:
    """Guard a drive behind a control.

    It may be switched off. While phases are switched the way to it is busy. Before phase 2 there is none: SYNAX calls
    that the initialization mode and does not allow the request.
    """

    def gate(request: Request) -> None:
        if request.body[2] != 0:
            return  # parameters of the axis are in the control
        if off:
            raise ServiceFailed.in_channel(ChannelError.FAULT)
        if device.phases.switching(request.now_ns):
            raise ServiceFailed.in_channel(ChannelError.BUSY)
        if device.phases.at(request.now_ns) < _FIRST_WITH_CHANNEL:
            raise AccessError(_NOT_ALLOWED if initialization_mode else _CHANNEL_NOT_OPEN)

    return gate
