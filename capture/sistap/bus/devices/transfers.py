# SPDX-License-Identifier: GPL-2.0-or-later
"""Sequential telegrams: long data in pieces, one transfer at a time on each device (IF02 chapters 2.4, 8.2 and 8.7)."""

from __future__ import annotations

from dataclasses import dataclass

from sistap.bus.devices.parameters import LAST, AccessError
from sistap.bus.service import ChannelError, Request, ServiceFailed, ServiceRefused, Status

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
