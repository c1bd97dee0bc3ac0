# SPDX-License-Identifier: GPL-2.0-or-later
"""Services 0x10, 0x11, 0x1E and 0x1F and their likes of the product groups: parameters (IF02 chapter 8)."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from sistap.bus.devices.device import Device
from sistap.bus.devices.gates import Gate
from sistap.bus.devices.parameters import LAST, TOO_LONG, WRONG_ACCESS, AccessError, Element
from sistap.bus.devices.transfers import HEADER, Transfer
from sistap.bus.service import Request, Service, ServiceFailed, ServiceRefused, Status

_SEGMENT = 4  # bytes of list offset and length
_LONGEST = 0xFFFF + 4  # bytes that the lengths of a list can say
_WORDS = 2


class Parameters:
    """The parameters of the devices that a station gives access to."""

    def __init__(self, devices: Mapping[int, tuple[Device, Gate]], longest: int) -> None:
        """Take the devices by their addresses; `longest` is how many bytes of data a reaction can have."""
        self._devices = devices
        self._longest = longest

    def services(self, group: int, segments_in_words: bool = False) -> dict[int, Service]:
        """Return the services of a group, 0x10, 0x80 or 0x90; offset and length of 0x81 and 0x8E count words."""
        unit = _WORDS if segments_in_words else 1
        return {
            group | 0x0: _translated(HEADER, self._read),
            group | 0x1: _translated(HEADER + _SEGMENT, lambda request: self._read_segment(request, unit)),
            group | 0xE: _translated(HEADER + _SEGMENT, lambda request: self._write_segment(request, unit)),
            group | 0xF: _translated(HEADER, self._write),
        }

    def cancel(self, device: int | None, service: int | None) -> None:
        """End transfers: of all devices or of one, of all services or of one. Raises ServiceRefused for no device."""
        if device is not None:
            self._device(device)[0].channel.cancel(service)
            return
        for each, _ in self._devices.values():
            each.channel.cancel(service)

    def _read(self, request: Request) -> bytes:
        device, element, transfer = self._enter(request)
        data = transfer.data if transfer else device.read(request.body[2:HEADER], element, request.now_ns)
        piece, rest = data[: self._longest], data[self._longest :]
        if rest:
            device.channel.transfer = transfer or Transfer.begun(request, rest)
            device.channel.transfer.data = rest
        else:
            device.channel.transfer = None
        control = request.body[0] & ~LAST if rest else request.body[0] | LAST
        return bytes([control, request.body[1]]) + piece

    def _write(self, request: Request) -> bytes:
        device, element, transfer = self._enter(request)
        data = (transfer.data if transfer else b"") + request.body[HEADER:]
        if request.body[0] & LAST:
            device.channel.transfer = None
            return request.body[:2] + device.write(request.body[2:HEADER], element, data, request.now_ns)
        device.find(request.body[2:HEADER]).check_writable(element, device.phases.at(request.now_ns))
        if len(data) > _LONGEST:
            device.channel.transfer = None
            raise AccessError.of(element, TOO_LONG)
        device.channel.transfer = transfer or Transfer.begun(request, data)
        device.channel.transfer.data = data
        return request.body[:2]

    def _read_segment(self, request: Request, unit: int) -> bytes:
        device, element, _ = self._enter(request)
        offset, length = _segment(request.body, unit)
        parameter = device.find(request.body[2:HEADER])
        if element != Element.DATA:
            raise AccessError.of(element, WRONG_ACCESS)
        device.refresh(request.now_ns)
        return request.body[:2] + parameter.read_segment(offset, min(length, self._longest))

    def _write_segment(self, request: Request, unit: int) -> bytes:
        device, element, _ = self._enter(request)
        offset, _ = _segment(request.body, unit)
        number, data = request.body[2:HEADER], request.body[HEADER + _SEGMENT :]
        if element != Element.DATA:
            return request.body[:2] + device.write(number, element, data, request.now_ns)
        device.find(number).write_segment(offset, data, device.phases.at(request.now_ns))
        return request.body[:2]

    def _enter(self, request: Request) -> tuple[Device, Element, Transfer | None]:
        device, gate = self._device(request.body[1])
        gate(request)
        return device, Element(request.body[0] >> 3 & 7), device.channel.enter(request)

    def _device(self, address: int) -> tuple[Device, Gate]:
        if address not in self._devices:
            raise ServiceRefused(Status.INVALID_ADDRESS)
        return self._devices[address]


def _translated(least: int, execute: Callable[[Request], bytes]) -> Service:
    """Make a service of which an AccessError is an execution error."""

    def translating(request: Request) -> bytes:
        try:
            return execute(request)
        except AccessError as error:
            raise ServiceFailed(error.code.to_bytes(2, "little")) from None

    return Service(2, least, translating)


def _segment(body: bytes, unit: int) -> tuple[int, int]:
    """Return offset and length in bytes."""
    offset, length = body[HEADER : HEADER + 2], body[HEADER + 2 : HEADER + _SEGMENT]
    return unit * int.from_bytes(offset, "little"), unit * int.from_bytes(length, "little")
