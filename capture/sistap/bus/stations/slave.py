# SPDX-License-Identifier: GPL-2.0-or-later
"""A station that answers for itself: which telegrams it accepts, and how it answers them (IF02 chapter 2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from sistap.bus.service import Request, Service, ServiceFailed, ServiceRefused, Status
from sistap.bus.stations.edition import Edition
from sistap.bus.stations.initialization import Initialization
from sistap.sis.telegram import BROADCAST, LEVEL_BROADCAST, START, STATIC_LENGTH, Header, build, checksum_good, parse


class Slave:
    """Address, services, and the reaction that is kept for a repeated command."""

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
    ) -> None:
        """Take the parts of the station.

        It obeys commands for its `groups`. `refuse` maps services to the status of their refusal. `available` tells
        whether a service is available now, `error` whether the system diagnosis has an error.
        """
        self.address = address
        self.initialization = initialization
        self._edition = edition
        self._services = services
        self._all = {*groups, LEVEL_BROADCAST, BROADCAST}
        self._refuse = refuse or {}
        self._available = available
        self._error = error
        self._kept: tuple[bytes, bytes] | None = None  # static header with number, and the reaction to it

    def react(self, command: bytes, now_ns: int) -> bytes | None:
        """Return the reaction, with the addresses of the command; None for commands to others or to all.

        A damaged command is answered only at a point-to-point connection: on a bus its receiver is unknown.
        """
        if len(command) < STATIC_LENGTH:
            return None
        header = parse(command)
        alone = header.receiver == self._edition.point_to_point
        status = damage(command)
        if status is not None:
            return self._reaction(header, bytes([status])) if alone else None
        if not self.is_meant(header.receiver) and header.receiver not in self._all:
            return None
        if header.reaction:
            return self._reaction(header, bytes([Status.INVALID_TELEGRAM])) if alone else None
        reaction = self._once(header, command[:STATIC_LENGTH], now_ns)
        return None if header.receiver in self._all else reaction

    def is_meant(self, receiver: int) -> bool:
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

    def _reaction(self, header: Header, body: bytes) -> bytes:
        return build(
            header.service,
            header.sender,
            header.receiver,
            body,
            reaction=True,
            system=self._edition.control(body, self._error()),
            subaddresses=header.subaddresses,
            number=header.number,
        )


def damage(command: bytes) -> int | None:
    """Return the status for a damaged telegram; None if it is whole."""
    if len(command) < STATIC_LENGTH or command[0] != START:
        return Status.INVALID_TELEGRAM
    if command[2] != command[3] or len(command) != STATIC_LENGTH + command[3]:
        return Status.WRONG_LENGTH
    return None if checksum_good(command) else Status.WRONG_CHECKSUM
