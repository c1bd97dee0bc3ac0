# SPDX-License-Identifier: GPL-2.0-or-later
"""What telegrams say: a reaction does not repeat the parameter that its command named, so one remembers the other.

The bytes of a value are a number or a text only by the attribute of the parameter: once it was read on the bus.
Wireshark's dissector knows more, such as lists of services, and data in several telegrams.
"""

from __future__ import annotations

from typing import NamedTuple

from sistap.dissected.telegrams.attribute import Attribute
from sistap.dissected.telegrams.values import Value, value
from sistap.tap.records.before import bus_of, heard
from sistap.tap.records.record import Record as BareRecord
from sistap.tap.records.record import Type
from sistap.tap.sis.names import S_NAMES
from sistap.tap.sis.telegram import Header, general, has_control, is_whole, parse, service_name, shown, status
from sistap.tap.sis.told import ATTRIBUTE, NAME, UNIT, Place, Told, text

# Fig. 8-1, as in Wireshark; there, a value is "Operating data".
_ELEMENTS = ("channel not active", "ident number", "name", "attribute", "unit", "minimum", "maximum", "value")
_WHOLE_VALUE = 0x3C  # the control byte of a value that is not in pieces
_WHOLE = (0x10, 0x1F)  # services that read and write a parameter; the others a segment of a list
_WRITES = (0x1E, 0x1F)
_STANDARD = {f"S-0-{number:04}": name for number, name in S_NAMES.items()}


class Telegram(NamedTuple):
    """A SIS telegram with right lengths and checksum. Texts that are not known are empty, other things None."""

    sender: int  # the station that sends it; in the header of a reaction it is the receiver
    receiver: int
    is_reaction: bool
    service: int  # code, such as 0x1F
    status: int | None  # first byte of a reaction: 0 is good; None: a command, or a service without it
    station: str  # that a command is for, or a reaction is from: "3", behind routers "3/2/8"
    device: int | None  # its device, in services of parameters
    parameter: str  # "S-0-0040"; of a reaction only if its command was heard
    element: str  # of the parameter: value, name, unit, attribute, minimum, maximum, ident number, channel not active
    name: str  # of the parameter, as the bus told it, or as the standard says
    unit: str  # of the value, as the bus told it: "rpm"
    value: Value | None  # of the parameter; None: the bus has not told its attribute, it has several parts, or an error
    data: bytes  # what follows status, control byte and ident: the value as it came, low byte first, or an error code
    command: Telegram | None  # that a reaction answers

    @property
    def service_name(self) -> str:
        """Return the name of the service: "Write parameter"."""
        return service_name(self.service)

    @property
    def is_write(self) -> bool:
        """Tell whether it writes a parameter, or answers such a command."""
        return general(self.service) in _WRITES

    def __str__(self) -> str:
        kind = "Reaction" if self.is_reaction else "Command"
        words = [f"{self.sender} -> {self.receiver}  {kind}  {self.service_name}", self.parameter]
        words += [f"({self.name})"] if self.name else []
        words += [self.element] if self.element not in ("", "value") else []
        words += [f"status 0x{self.status:02x}"] if self.status else []
        if self.value is not None:
            words.append(f"= {shown(str(self.value))} {self.unit}".rstrip())
        elif self.data:
            words.append(f"= {self.data.hex(' ')}" if self.parameter else self.data.hex(" "))
        return " ".join(filter(None, words))


class Record(BareRecord):
    """A record of the tap, and its telegram."""

    telegram: Telegram | None = None  # None: an event, other characters, a damaged telegram, or not SIS


class Interpreter:
    """Knows what was said on the buses of a capture. Give it all records, in their order."""

    def __init__(self) -> None:
        self._buses: dict[int, Told] = {}

    def take(self, taken: BareRecord) -> Record:
        """Return a record with its telegram."""
        bus = bus_of(taken.line)
        told = self._buses.get(bus) or self._buses.setdefault(bus, Told())
        record, said = Record._make(taken), heard(taken)
        is_whole_telegram = is_whole(said.telegram)
        if said.is_disturbed or (said.telegram and not is_whole_telegram):
            told.disturb()
        if is_whole_telegram:
            answered = told.take(said.telegram, said.end_ns, is_before=said.is_before)
            if taken.type != Type.BEFORE:
                record.telegram = _telegram(told, said.telegram, answered)
        return record


def _telegram(told: Told, telegram: bytes, answered: bytes) -> Telegram:
    """Return what a telegram says; `answered` is its command, if it is a reaction to a known one."""
    header = parse(telegram)
    command = _telegram(told, answered, b"") if answered else None
    is_swapped = command is not None and command.sender != header.sender  # a few devices do that
    place = _place(parse(answered) if answered else header) if answered or not header.reaction else None
    code, control, device, data = _divided(header)
    known = told.known(place) if place else {}
    is_value = place and control == _WHOLE_VALUE and not code and general(header.service) in _WHOLE
    parameter = place.parameter if place else ""
    return Telegram(
        sender=header.sender if is_swapped else header.talker,
        receiver=header.receiver if is_swapped else header.listener,
        is_reaction=header.reaction,
        service=header.service,
        status=code,
        station=command.station if command else "/".join(map(str, (header.receiver, *header.subaddresses))),
        device=device,
        parameter=parameter,
        element="" if control is None else _ELEMENTS[control >> 3 & 7],
        name=text(known.get(NAME, b"")) or _STANDARD.get(parameter, ""),
        unit=text(known.get(UNIT, b"")),
        value=_value(known.get(ATTRIBUTE), data) if is_value else None,
        data=data,
        command=command,
    )


def _place(command: Header) -> Place | None:
    """Return the parameter that a command names."""
    body = command.body
    if not has_control(command.service) or len(body) < 5:
        return None
    place = Place(bytes((command.receiver, *command.subaddresses)), body[1], body[2:5])
    return place if place.is_defined else None


def _divided(header: Header) -> tuple[int | None, int | None, int | None, bytes]:
    """Return status, control byte and device, as far as there are such, and the data after them and the ident."""
    code, body = status(header), header.body
    if code is not None:
        body = body[1:]
    if not has_control(header.service) or len(body) < 2:
        return code, None, None, body
    return code, body[0], body[1], body[2:] if header.reaction else body[5:]


def _value(attribute: bytes | None, data: bytes) -> Value | None:
    return value(Attribute(int.from_bytes(attribute, "little")), data) if attribute and data else None
