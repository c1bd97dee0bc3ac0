# SPDX-License-Identifier: GPL-2.0-or-later
"""A drive on the virtual bus: command telegram in, reaction telegram out (IF02 chapters 2.3, 3, 6 and 8).

It knows no time: when a reaction is sent is the business of `playing`.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from typing import Protocol

from sistap.bus.parameters import (
    PARAMETER_MODE_ONLY,
    READ_ONLY,
    AccessError,
    Element,
    Format,
    Length,
    Parameter,
    attribute,
    ident,
    number,
    text,
)
from sistap.rates import rate_of
from sistap.telegram import BROADCAST, LEVEL_BROADCAST, STATIC_LENGTH, build, checksum_good, parse

OPERATING_MODE = 4  # the phase

OK = 0x00
EXECUTION_ERROR = 0x01
INVALID_SERVICE = 0xF0
SUBADDRESSES = 0xF9
DATA_MISSING = 0xFA
INVALID_SUBSERVICE = 0xFB

IDENT_NUMBER_NOT_AVAILABLE = 0x1001
BAUD_RATE_NOT_SUPPORTED = 0x00  # the low byte of 0x0700 and 0x0800

# Bytes of the useful data header that a reaction repeats: address and subservice, or control byte and device.
_REPEATED = {0x00: 2, 0x03: 2, 0x10: 2, 0x1F: 2}


class Station(Protocol):
    """Whatever hears commands."""

    address: int

    def react(self, command: bytes) -> bytes | None:
        """Give the reaction to a command telegram; None if there is none, e.g. because it is for somebody else."""


class Drive:
    """A drive in operating mode."""

    def __init__(
        self, address: int, type_key: str, firmware: str, parameters: Iterable[Parameter], seed: int = 0
    ) -> None:
        """Switch it on; `seed` decides how its feedback values scatter."""
        self.address = address
        self.phase = OPERATING_MODE
        self.parameters = {ident(parameter.ident): parameter for parameter in parameters}
        self._identification = {1: b"01V01", 2: firmware.encode(), 3: type_key.encode(), 4: bytes([0x0F])}
        self._random = random.Random(f"{seed} drive {address}")
        self._kept: tuple[bytes, bytes] | None = None  # static header with number, and the reaction to it
        self._services = {
            0x00: self._identify,
            0x03: self._initialize,
            0x10: self._read_parameter,
            0x12: self._read_phase,
            0x1F: self._write_parameter,
        }

    def react(self, command: bytes) -> bytes | None:
        """Give the reaction, with the addresses of the command; None to what is damaged, to others or to all."""
        if len(command) < STATIC_LENGTH or command[2] != command[3] or not checksum_good(command):
            return None
        header = parse(command)
        if header.reaction or header.receiver not in (self.address, LEVEL_BROADCAST, BROADCAST):
            return None
        kept = command[:STATIC_LENGTH] + bytes([header.number or 0])
        if header.number and self._kept and self._kept[0] == kept:
            return self._kept[1]
        body = self._refuse(SUBADDRESSES, header.service, header.body)
        if not header.subaddresses:
            body = self._execute(header.service, header.body)
        reaction = build(
            header.service,
            header.sender,
            header.receiver,
            body,
            reaction=True,
            subaddresses=header.subaddresses,
            number=header.number,
        )
        if header.number is not None:
            self._kept = (kept, reaction) if header.number else None
        return reaction if header.receiver == self.address else None

    def _execute(self, service: int, body: bytes) -> bytes:
        if service not in self._services:
            return self._refuse(INVALID_SERVICE, service, body)
        if len(body) < _REPEATED.get(service, 0):
            return self._refuse(DATA_MISSING, service, body)
        return self._services[service](body)

    def _refuse(self, status: int, service: int, body: bytes) -> bytes:
        """Make the body for a telegram error: status and useful data header, no useful data (chapter 2.3)."""
        return bytes([status]) + body[: _REPEATED.get(service, 0)]

    def _identify(self, body: bytes) -> bytes:
        data = self._identification.get(body[1])
        if data is None:
            return self._refuse(INVALID_SUBSERVICE, 0x00, body)
        return bytes([OK]) + body[:2] + data

    def _initialize(self, body: bytes) -> bytes:
        subservice, data = body[1], body[2:]
        lengths = {0x01: 2, 0x02: 2, 0x03: 2, 0x07: 1, 0x08: 3, 0xFF: 0}
        if subservice not in lengths:
            return self._refuse(INVALID_SUBSERVICE, 0x03, body)
        if len(data) < lengths[subservice]:
            return self._refuse(DATA_MISSING, 0x03, body)
        if subservice in (0x07, 0x08) and rate_of(data[-1]) is None:
            return bytes([EXECUTION_ERROR]) + body[:2] + bytes([BAUD_RATE_NOT_SUPPORTED])
        return bytes([OK]) + body[:2]

    def _read_parameter(self, body: bytes) -> bytes:
        try:
            data = self._parameter(body).read(Element(body[0] >> 3 & 7))
        except AccessError as error:
            return bytes([EXECUTION_ERROR]) + body[:2] + error.code.to_bytes(2, "little")
        return bytes([OK]) + body[:2] + data

    def _write_parameter(self, body: bytes) -> bytes:
        try:
            parameter = self._parameter(body)
            data = parameter.write(Element(body[0] >> 3 & 7), body[5:], self.phase)
        except AccessError as error:
            return bytes([EXECUTION_ERROR]) + body[:2] + error.code.to_bytes(2, "little")
        if parameter.ident == "S-0-0036":
            self._move(int.from_bytes(parameter.data, "little", signed=True))
        return bytes([OK]) + body[:2] + data

    def _read_phase(self, body: bytes) -> bytes:
        return bytes([OK, self.phase])

    def _parameter(self, body: bytes) -> Parameter:
        parameter = self.parameters.get(body[2:5])
        if parameter is None:
            raise AccessError(IDENT_NUMBER_NOT_AVAILABLE)
        return parameter

    def _move(self, velocity: int) -> None:
        """Follow a command velocity (0.0001 rpm) as a motor does: nearly."""
        feedback, position = self.parameters.get(ident("S-0-0040")), self.parameters.get(ident("S-0-0051"))
        if feedback:
            feedback.data = number(velocity + self._random.randint(-15_000, 15_000))
        if position:
            moved = int.from_bytes(position.data, "little", signed=True) + velocity // 40
            position.data = number(moved % 3_600_000)  # one turn in 0.0001 degrees


def drive_parameters() -> list[Parameter]:
    """Make the parameters of a small velocity drive."""
    velocity = attribute(Length.FOUR_BYTES, Format.SIGNED, 4)
    feedback = attribute(Length.FOUR_BYTES, Format.SIGNED, 4, READ_ONLY)
    limits = (number(-30_000_000), number(30_000_000))
    return [
        Parameter("S-0-0036", "Velocity command value", velocity, number(0), "rpm", *limits),
        Parameter("S-0-0040", "Velocity feedback value", feedback, number(0), "rpm"),
        Parameter(
            "S-0-0044",
            "Velocity data scaling type",
            attribute(Length.TWO_BYTES, Format.BINARY, 0, PARAMETER_MODE_ONLY),
            b"\x02\x00",  # rotational, in rpm
        ),
        Parameter("S-0-0051", "Position feedback value 1", feedback, number(0), "Deg"),
        Parameter(
            "S-0-0095",
            "Diagnostic message",
            attribute(Length.LIST_OF_BYTES, Format.TEXT, 0, READ_ONLY),
            text("A101 Drive in velocity mode"),
        ),
        Parameter(
            "S-0-0099",
            "C500 Reset class 1 diagnostics",
            attribute(Length.TWO_BYTES, Format.BINARY, command=True),
            b"\x00\x00",
        ),
    ]
