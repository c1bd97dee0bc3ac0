# SPDX-License-Identifier: GPL-2.0-or-later
"""Services 0x10, 0x11, 0x1E and 0x1F and their equivalents of the product groups: parameters (IF02 chapter 8)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from sisbus.devices.device import HEADER, SEGMENT, Device, Transfer
from sisbus.devices.parameters import (
    LAST,
    TOO_LONG,
    WRONG_ACCESS,
    AccessError,
    Element,
    Parameter,
)
from sisbus.service import Request, Service, ServiceFailed, ServiceRefused, Status
from sisbus.stations.station import Edition
from sistap.dissected.telegrams.attribute import LENGTH_WORDS

_LONGEST = 0xFFFF + 4  # bytes that the lengths of a list can describe


class Segments(NamedTuple):
    """How a group of services addresses parts of lists."""

    unit: int = 1  # bytes in one unit of offset and length
    in_pieces: bool = False  # a part that exceeds one telegram is read in sequential telegrams
    length_words: bool = False  # the offset counts from the two lengths before the elements

    def of(self, body: bytes) -> tuple[int, int]:
        """Return offset and length of a command, in bytes."""
        offset, length = body[HEADER : HEADER + 2], body[HEADER + 2 : HEADER + SEGMENT]
        return self.unit * int.from_bytes(offset, "little"), self.unit * int.from_bytes(length, "little")

    def read(self, parameter: Parameter, offset: int, length: int) -> bytes:
        """Return a part, as far as it goes. May raise AccessError."""
        if self.length_words and offset == 0:
            parameter.check_list()
            return parameter.data[:length]
        return parameter.read_segment(self._from_elements(offset), length)

    def write(self, parameter: Parameter, offset: int, data: bytes, phase: int) -> None:
        """Write a part; the two lengths are written alone, and change that of the list. May raise AccessError."""
        if self.length_words and offset == 0:
            parameter.resize(data, phase)
        else:
            parameter.write_segment(self._from_elements(offset), data, phase)

    def _from_elements(self, offset: int) -> int:
        return offset - LENGTH_WORDS if self.length_words else offset


# For drives, 0x81 and 0x8E: words; repeating the same command continues reading (IndraDrive and ECODRIVE Cs).
OF_DRIVES = Segments(unit=2, in_pieces=True)


class Parameters:
    """The parameters of all devices of a station."""

    def __init__(self, devices: Mapping[int, Device], edition: Edition) -> None:
        self._devices = devices
        self._longest = edition.longest
        self._channel_status = edition.channel_status

    def services(self, group: int, parts: Segments) -> dict[int, Service]:
        """Return the services of a group, 0x10, 0x80 or 0x90."""
        return {
            group | 0x0: self._translated(HEADER, self._read),
            group | 0x1: self._translated(HEADER + SEGMENT, lambda request: self._read_segment(request, parts)),
            group | 0xE: self._translated(HEADER + SEGMENT, lambda request: self._write_segment(request, parts)),
            group | 0xF: self._translated(HEADER, self._write),
        }

    def cancel(self, device: int | None, service: int | None) -> None:
        """End transfers: of all devices or of one, of all services or of one. Raise ServiceRefused if there is no
        such device.
        """
        if device is not None:
            self._device(device).channel.cancel(service)
            return
        for each in self._devices.values():
            each.channel.cancel(service)

    def _read(self, request: Request) -> bytes:
        device, element, transfer = self._enter(request)
        data = transfer.data if transfer else device.read(request.body[2:HEADER], element, request.now_ns)
        return self._piece(request, device, transfer, data)

    def _piece(self, request: Request, device: Device, transfer: Transfer | None, data: bytes) -> bytes:
        """Answer with what fits into one telegram; the same command then fetches the rest."""
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

    def _read_segment(self, request: Request, parts: Segments) -> bytes:
        device, element, transfer = self._enter(request)
        offset, length = parts.of(request.body)
        parameter = device.find(request.body[2:HEADER])
        if element != Element.DATA:
            raise AccessError.of(element, WRONG_ACCESS)
        device.refresh(request.now_ns)
        if parts.in_pieces:
            data = transfer.data if transfer else parts.read(parameter, offset, length)
            return self._piece(request, device, transfer, data)
        return request.body[:2] + parts.read(parameter, offset, min(length, self._longest))

    def _write_segment(self, request: Request, parts: Segments) -> bytes:
        device, element, _ = self._enter(request)
        offset, _ = parts.of(request.body)
        number, data = request.body[2:HEADER], request.body[HEADER + SEGMENT :]
        if element != Element.DATA:
            return request.body[:2] + device.write(number, element, data, request.now_ns)
        parts.write(device.find(number), offset, data, device.phases.at(request.now_ns))
        return request.body[:2]

    def _enter(self, request: Request) -> tuple[Device, Element, Transfer | None]:
        device = self._device(request.body[1])
        device.gate(request)
        return device, Element(request.body[0] >> 3 & 7), device.channel.enter(request)

    def _device(self, address: int) -> Device:
        if address not in self._devices:
            raise ServiceRefused(Status.INVALID_ADDRESS)
        return self._devices[address]

    def _translated(self, least: int, execute: Callable[[Request], bytes]) -> Service:
        """Return a service that turns an AccessError into an execution error; the edition defines that of the
        channel.
        """

        def translating(request: Request) -> bytes:
            try:
                return execute(request)
            except AccessError as error:
                raise ServiceFailed(error.code.to_bytes(2, "little")) from None
            except ServiceFailed as failed:
                raise ServiceFailed(failed.code, self._channel_status) from None

        return Service(2, least, translating)
