# SPDX-License-Identifier: GPL-2.0-or-later
"""A station: command telegram in, reaction telegram out. A router is one with others behind it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

from sisbus.service import Request, Service, ServiceFailed, ServiceRefused, Status
from sisbus.stations.initialization import Initialization
from sisbus.stations.terminal import Terminal
from sistap.tap.sis.telegram import (
    BROADCAST,
    CONTROL_SYSTEM,
    LEVEL_BROADCAST,
    START,
    STATIC_LENGTH,
    Header,
    build,
    checksum_good,
    parse,
)

# -- The differences between the documents that describe SIS ---------------------------------------------------------

_SYSTEM_ERROR = 0x80  # bit 7 of the telegram control

# ECODRIVE03: bits 7, 6, 5 of the telegram control of a reaction, by the error code in it.
_STATE_ERROR = 0b110
_STATES = {0x8001: 0b001, 0x800C: 0b010}


def _diagnosis(body: bytes, error: bool) -> int:
    """Return the system diagnosis of the station (IF02)."""
    return _SYSTEM_ERROR if error else 0


def _state(body: bytes, error: bool) -> int:
    """Return what became of the request (ECODRIVE03)."""
    if body[0] == Status.OK:
        return 0
    return _STATES.get(int.from_bytes(body[-2:], "little"), _STATE_ERROR) << 5


class Edition(NamedTuple):
    """A document that a station follows."""

    longest: int  # bytes of data in the reaction to a read parameter
    point_to_point: int | None  # the receiver address that every station answers
    groups: range  # receiver addresses of groups
    lists: bool  # whether there is service 0x04
    no_shutdown: Mapping[int, int]  # error byte of shutdown and reboot for each phase
    control: Callable[[bytes, bool], int]  # bits 5 to 7 of the telegram control, by body and error of the station
    channel_status: int = Status.CHANNEL_ERROR  # the status before a code of the channel to a parameter
    crc32: bool = False  # returned by 0x97 of service 0x02
    length_words: bool = False  # the list offset of 0x11 and 0x1E counts from the two lengths before the elements


EDITIONS = {
    "IF02": Edition(236, 128, range(200, 254), True, {3: 0x03, 4: 0x04}, _diagnosis),
    "IndraDrive": Edition(
        245,
        128,
        range(200, 254),
        True,
        {3: 0x10, 4: 0x10},
        _diagnosis,
        channel_status=Status.EXECUTION_ERROR,
        crc32=True,
        length_words=True,
    ),
    "ECODRIVE03": Edition(236, None, range(128, 255), False, {3: 0x03, 4: 0x04}, _state),
}


# -- A slave: which telegrams it accepts, and how it answers them (IF02 chapter 2) -----------------------------------


class Station:
    """A slave, with its services, the stations behind it, and the reaction that is kept for a repeated command.

    Its time is the bus's, in ns since the bus was started, and never goes back.
    """

    def __init__(  # noqa: PLR0913 - the parts of a station
        self,
        address: int,
        edition: Edition,
        services: Mapping[int, Service],
        initialization: Initialization,
        *,
        groups: Iterable[int] = (),
        refuse: Mapping[int, int] | None = None,
        available: Callable[[int], bool] = lambda service: True,
        error: Callable[[], bool] = lambda: False,
        terminal: Terminal | None = None,
        behind: Sequence[Station] = (),
    ) -> None:
        """Take the parts of the station.

        It obeys commands for its `groups`. `refuse` maps services to the status of their refusal. `available` tells
        whether a service is available now, `error` whether the system diagnosis has an error. The stations `behind` it
        are on a level of their own.
        """
        self.address = address
        self.initialization = initialization
        self.terminal = terminal
        self._edition = edition
        self._services = services
        self._all = {*groups, LEVEL_BROADCAST, BROADCAST}
        self._refuse = refuse or {}
        self._available = available
        self._error = error
        self._behind = behind
        self._kept: tuple[bytes, bytes] | None = None  # static header with number, and the reaction to it

    def react(self, command: bytes, now_ns: int) -> bytes | None:
        """Return the reaction to a command whose last character has arrived: its own, or one from behind it.

        None if there is none, such as for commands to others or to all.
        """
        header = parse(command) if self._behind and damage(command) is None else None
        if header and not header.reaction:
            if header.receiver == BROADCAST:
                self._pass_on(header, BROADCAST, header.subaddresses, now_ns)  # global: for all levels
            elif header.subaddresses and self._is_meant(header.receiver):
                return self._routed(header, now_ns)
        return self._own(command, now_ns)

    def _own(self, command: bytes, now_ns: int) -> bytes | None:
        """Return its own reaction, with the addresses of the command.

        A damaged command is answered only at a point-to-point connection: on a bus its receiver is unknown.
        """
        if len(command) < STATIC_LENGTH:
            return None
        header = parse(command)
        alone = header.receiver == self._edition.point_to_point
        status = damage(command)
        if status is not None:
            return self._reaction(header, bytes([status])) if alone else None
        if not self._is_meant(header.receiver) and header.receiver not in self._all:
            return None
        if header.reaction:
            return self._reaction(header, bytes([Status.INVALID_TELEGRAM])) if alone else None
        reaction = self._once(header, command[:STATIC_LENGTH], now_ns)
        return None if header.receiver in self._all else reaction

    def _is_meant(self, receiver: int) -> bool:
        """Tell whether a receiver address means this station alone."""
        return receiver in (self.address, self._edition.point_to_point)

    def execute(self, request: Request) -> bytes:
        """Execute a service; return the body of the reaction, status first."""
        service = self._services.get(request.service)
        repeated = request.body[: service.repeated] if service else b""
        try:
            return bytes([Status.OK]) + self._checked(service, request).execute(request)
        except ServiceRefused as refused:
            return bytes([refused.status]) + repeated
        except ServiceFailed as failed:
            return bytes([failed.status]) + (repeated if failed.header is None else failed.header) + failed.code

    def _checked(self, service: Service | None, request: Request) -> Service:
        if request.service in self._refuse:
            raise ServiceRefused(self._refuse[request.service])
        if service is None or not self._available(request.service):
            raise ServiceRefused(Status.INVALID_SERVICE)
        if len(request.body) < service.least:
            raise ServiceRefused(Status.DATA_MISSING)
        return service

    def _once(self, header: Header, static_header: bytes, now_ns: int) -> bytes:
        """Execute a command, unless its number shows a repetition: then send the same reaction again."""
        kept = static_header + bytes([header.number or 0])
        if self._kept and self._kept[0] == kept:
            return self._kept[1]
        if header.subaddresses:
            service = self._services.get(header.service)
            body = bytes([Status.SUBADDRESSES]) + header.body[: service.repeated if service else 0]
        else:
            body = self.execute(Request(header.service, header.sender, header.body, now_ns))
        reaction = self._reaction(header, body)
        if header.number is not None:
            self._kept = (kept, reaction) if header.number else None
        return reaction

    def _reaction(self, header: Header, body: bytes, system: int | None = None) -> bytes:
        return build(
            header.service,
            header.sender,
            header.receiver,
            body,
            reaction=True,
            system=self._edition.control(body, self._error()) if system is None else system,
            subaddresses=header.subaddresses,
            number=header.number,
        )

    # -- Routing (chapter 2.2) ------------------------------------------------------------------------------------

    def _routed(self, header: Header, now_ns: int) -> bytes | None:
        answer = self._pass_on(header, header.subaddresses[0], header.subaddresses[1:], now_ns)
        if answer is None:
            return None
        below = parse(answer)
        return self._reaction(header, below.body, below.control & CONTROL_SYSTEM)

    def _pass_on(self, header: Header, receiver: int, subaddresses: bytes, now_ns: int) -> bytes | None:
        """Let all stations of the level below hear the command; return the reaction of its receiver."""
        passed_on = build(
            header.service, self.address, receiver, header.body, subaddresses=subaddresses, number=header.number
        )
        reactions = [station.react(passed_on, now_ns) for station in self._behind]
        return next((reaction for reaction in reactions if reaction), None)


def damage(command: bytes) -> int | None:
    """Return the status for a damaged telegram; None if it is whole."""
    if len(command) < STATIC_LENGTH or command[0] != START:
        return Status.INVALID_TELEGRAM
    if command[2] != command[3] or len(command) != STATIC_LENGTH + command[3]:
        return Status.WRONG_LENGTH
    return None if checksum_good(command) else Status.WRONG_CHECKSUM
