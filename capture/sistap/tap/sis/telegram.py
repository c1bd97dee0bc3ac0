# SPDX-License-Identifier: GPL-2.0-or-later
"""The SIS telegram (IF02 chapter 2.2, fig. 2-9): recognise it, parse it, build it; its services, and text of drives.

Wireshark decodes telegrams for users. This is only what cutting, counting and playing needs.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from sistap.tap.sis.codes import LIKE, RANGES, SERVICES, WITH_CONTROL, WITH_STATUS, Item


def service_name(service: int) -> str:
    """Return the name of a service, or its range with its number."""
    name = SERVICES.get(service)
    if name is None:
        kind = next(text for first, last, text in RANGES if first <= service <= last)
        name = f"{kind} 0x{service:02x}"
    return name


def general(service: int) -> int:
    """Return the general service that a service of a product group is like, or the service itself (chapter 8)."""
    return LIKE.get(service, service)


def has_status(service: int) -> bool:
    """Tell whether a reaction begins with a status byte (chapter 2.1)."""
    return service in WITH_STATUS


def has_control(service: int) -> bool:
    """Tell whether the useful data begin with a parameter control byte and a device address (fig. 8-1)."""
    return general(service) in WITH_CONTROL


def least(items: Iterable[Item]) -> int:
    """Return the bytes that a layout has at least."""
    return sum(item.size for item in items if not item.may_be_missing)


START = 0x02
STATIC_LENGTH = 8  # the header without subaddresses and telegram number
MAX_LENGTH = STATIC_LENGTH + 255

BROADCAST = 255  # the receiver address of all stations, in both editions
FIRST_GROUP = 200  # this receiver address and those above are of several stations: nobody answers (chapter 2.2)
LEVEL_BROADCAST = 254  # all on this line; in ECODRIVE03 a group

CONTROL_SUBADDRESSES = 0x07
CONTROL_NUMBER = 0x08
CONTROL_REACTION = 0x10
CONTROL_SYSTEM = 0xE0  # warnings and errors of the sender; in ECODRIVE03 the status of a reaction


class Header(NamedTuple):
    """A telegram's header; `body` is everything after it."""

    control: int
    service: int
    sender: int
    receiver: int
    subaddresses: bytes
    number: int | None
    body: bytes

    @property
    def reaction(self) -> bool:
        """Tell whether this is a reaction telegram."""
        return bool(self.control & CONTROL_REACTION)

    @property
    def talker(self) -> int:
        """Return the real sender: a reaction keeps the command's addresses (fig. 2-12 and 2-13)."""
        return self.receiver if self.reaction else self.sender

    @property
    def listener(self) -> int:
        """Return the real receiver."""
        return self.sender if self.reaction else self.receiver


def status(header: Header) -> int | None:
    """Return the status byte of a reaction, or None: product groups need not send one (chapter 2.1)."""
    return header.body[0] if header.reaction and header.body and has_status(header.service) else None


def checksum_good(telegram: bytes) -> bool:
    """Tell whether all bytes add up to 0 modulo 256."""
    return sum(telegram) & 0xFF == 0


def is_whole(telegram: bytes) -> bool:
    """Tell whether these bytes are one telegram, with equal and right lengths and a good checksum."""
    return (
        len(telegram) >= STATIC_LENGTH
        and telegram[0] == START
        and telegram[2] == telegram[3] == len(telegram) - STATIC_LENGTH
        and checksum_good(telegram)
    )


def parse(telegram: bytes) -> Header:
    """Parse a complete telegram; short ones have empty subaddresses, number and body, never an error.

    `telegram` has at least STATIC_LENGTH bytes.
    """
    control, service, sender, receiver = telegram[4:8]
    body_at = STATIC_LENGTH + (control & CONTROL_SUBADDRESSES)
    subaddresses = telegram[STATIC_LENGTH:body_at]
    number = None
    if control & CONTROL_NUMBER:
        number = telegram[body_at] if body_at < len(telegram) else None
        body_at += 1
    return Header(control, service, sender, receiver, subaddresses, number, telegram[body_at:])


def build(  # noqa: PLR0913 - the fields of the header
    service: int,
    sender: int,
    receiver: int,
    body: bytes = b"",
    *,
    reaction: bool = False,
    system: int = 0,
    subaddresses: bytes = b"",
    number: int | None = None,
) -> bytes:
    """Return a complete telegram with right lengths and checksum. ValueError if the body is too long.

    `system` are the bits of CONTROL_SYSTEM.
    """
    control = len(subaddresses) | (CONTROL_REACTION if reaction else 0) | system
    variable = subaddresses
    if number is not None:
        control |= CONTROL_NUMBER
        variable += bytes([number])
    variable += body
    if len(subaddresses) > CONTROL_SUBADDRESSES or len(variable) > 0xFF:
        raise ValueError(f"{len(subaddresses)} subaddresses and {len(body)} body bytes do not fit into one telegram")
    rest = bytes([len(variable), len(variable), control, service, sender, receiver]) + variable
    return bytes([START, -(START + sum(rest)) & 0xFF]) + rest


_SHOWN = str.maketrans(
    {code: chr(0x2400 + code) for code in range(0x20)}
    | {0x7F: "\u2421"}
    | {code: f"<{code:02x}>" for code in (*range(0x80, 0xA0), 0xAD)}
)


def shown(text: str) -> str:
    """Return Latin-1 text as the plugin shows it (plugin/parameters/text.c), with pictures of control characters."""
    return text.translate(_SHOWN)
