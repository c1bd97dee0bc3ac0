# SPDX-License-Identifier: GPL-2.0-or-later
"""The interface of a service of a station: command body in, reaction body out (IF02 chapter 2.3)."""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping
from typing import NamedTuple

from sistap.tap.sis.codes import LAYOUTS, WITHOUT_SUBSERVICES, Layout
from sistap.tap.sis.telegram import least


class Status(enum.IntEnum):
    """The status bytes that stations send by themselves (fig. 2-18; from 0xF9 on: IndraDrive)."""

    OK = 0x00
    EXECUTION_ERROR = 0x01
    CHANNEL_ERROR = 0x02
    PHASE_ERROR = 0x02  # the same byte in the reactions of the phase services
    INVALID_SERVICE = 0xF0
    INVALID_TELEGRAM = 0xF1
    WRONG_LENGTH = 0xF2
    WRONG_CHECKSUM = 0xF4
    INVALID_SEQUENCE = 0xF8
    SUBADDRESSES = 0xF9
    DATA_MISSING = 0xFA
    INVALID_SUBSERVICE = 0xFB
    INVALID_ADDRESS = 0xFC


class ChannelError(enum.IntEnum):
    """The code after status 2 (fig. 2-19)."""

    BUSY = 0x8001
    FAULT = 0x8002
    CANCELLED = 0x800B
    STILL_ACTIVE = 0x800C


class ServiceRefused(Exception):
    """Nothing was executed: the reaction has the status and the useful data header, but no useful data."""

    def __init__(self, status: int) -> None:
        super().__init__(f"status 0x{status:02X}")
        self.status = status


class ServiceFailed(Exception):
    """The execution failed: the reaction has an error code instead of useful data."""

    def __init__(self, code: bytes, status: int = Status.EXECUTION_ERROR, header: bytes | None = None) -> None:
        """`code` follows the useful data header, which is that of the command, or `header`."""
        super().__init__(f"status 0x{status:02X}, {code.hex()}")
        self.code = code
        self.status = status
        self.header = header

    @classmethod
    def in_channel(cls, error: ChannelError) -> ServiceFailed:
        """Return the failure of the internal transmission channel."""
        return cls(error.to_bytes(2, "little"), Status.CHANNEL_ERROR)


class Request(NamedTuple):
    """A command for a service; `body` is what follows header, subaddresses and telegram number."""

    service: int
    sender: int
    body: bytes
    now_ns: int


class Service(NamedTuple):
    """A service and how it is executed.

    `execute` returns the reaction's body after the status; it may raise ServiceRefused and ServiceFailed.
    """

    repeated: int  # bytes of the useful data header that a reaction repeats
    least: int  # smallest body of a command, in bytes
    execute: Callable[[Request], bytes]


# Of 0x00, 0x02 or 0x03: takes the data of a subservice and the time, and returns the reaction's data.
Subservice = Callable[[bytes, int], bytes]


def by_subservice(service: int, subservices: Mapping[int, Subservice]) -> Service:
    """Return a service whose body is an address, a subservice and its data; any address is repeated.

    Fig. 6-14 and 7-1 address neither the station nor a device in it, and get a good answer.
    """

    def execute(request: Request) -> bytes:
        header, data = request.body[:2], request.body[2:]
        subservice = subservices.get(header[1])
        if subservice is None:
            raise ServiceRefused(Status.INVALID_SUBSERVICE)
        if len(data) < least(LAYOUTS[service][header[1]].command):
            raise ServiceRefused(Status.DATA_MISSING)
        return header + subservice(data, request.now_ns)

    return Service(2, 2, execute)


def by_layout(service: int) -> Service:
    """Return a service that does nothing and succeeds: the values in its reaction are 0."""
    layouts = LAYOUTS[service]
    if service in WITHOUT_SUBSERVICES:
        layout = layouts[0]
        return Service(0, least(layout.command), lambda request: bytes(least(layout.reaction)))
    return by_subservice(service, {subservice: _zeros(layout) for subservice, layout in layouts.items()})


def _zeros(layout: Layout) -> Subservice:
    return lambda data, now_ns: bytes(least(layout.reaction))
