# SPDX-License-Identifier: GPL-2.0-or-later
"""A second decoder of SIS telegrams, written from the documents alone, to check the plugin against.

It knows nothing of the plugin but the names of its fields. Chapters and figures are those of the SIS definition (IF02);
`ECODRIVE03` is the older header, `MPH02` the manual of IndraDrive, `IEC 61491` the standard of SERCOS. What the
documents leave open is open here, too: such bytes must be shown, in any way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

# A layout is a row of items: a name, its size unless it is 1 (`*`: the rest), `?` if it may be missing. `~` are bytes
# that the documents leave open, for example because something is missing; `~?` may be empty. Bytes after the last item
# are too many.

_HEAD = "parameter_control device"
_PARAMETER = f"{_HEAD} parameter:3"
_SEGMENT = f"{_PARAMETER} list_offset:2 list_length:2"
_ADDRESSED = "device subservice"

# The body of a command: chapters 3.1, 5.1, 6.1, 7.1 and 8.2 to 8.7.
COMMANDS = {
    0x00: _ADDRESSED,
    0x02: _ADDRESSED,
    0x03: _ADDRESSED,
    0x04: "list:*",
    0x10: _PARAMETER,
    0x11: _SEGMENT,
    0x12: "",
    0x1D: "phase",
    0x1E: f"{_SEGMENT} element_data:*",
    0x1F: f"{_PARAMETER} element_data:*",
}
# A reaction between its status and its useful data: the same chapters.
HEADS = {**dict.fromkeys((0x00, 0x02, 0x03), _ADDRESSED), **dict.fromkeys((0x10, 0x11, 0x1E, 0x1F), _HEAD)}
# A good reaction after that.
GOOD = {0x10: "element_data:*", 0x11: "element_data:*", 0x12: "phase", 0x1D: "phase?"}
# What follows a subservice in a command and in a good reaction: chapters 3.1, 5.1, 6.1; MPH02 for the CRC32.
SUBSERVICES = {
    0x00: {0x01: ("", "version:5"), 0x02: ("", "firmware:*"), 0x03: ("", "type_key:*"), 0x04: ("", "init.baud_mask")},
    0x02: {
        0x90: ("flash.target flash.address:4", ""),
        0x91: ("flash.address:4", ""),
        0x92: ("flash.address:4 flash.length", "data:*"),
        0x93: ("", "flash.address:4"),
        0x94: ("flash.address:4 flash.length:4", ""),
        0x96: ("flash.address:4 flash.device_type data:*", ""),
        0x97: ("flash.address:4 flash.length:4", "flash.crc32:4?"),
        0x9F: ("", ""),
    },
    0x03: {
        **dict.fromkeys((0x01, 0x02, 0x03), ("init.time:2", "")),
        0x07: ("init.baud_mask", ""),
        0x08: ("init.test_time:2 init.baud_mask", ""),
        0xFF: ("", ""),
    },
}
# The product groups ECODRIVE and SYNAX have services with the bodies of those of SERCOS (chapter 8.1).
_PRODUCT_SERVICES = {0x80: (0x0, 0x1, 0xE, 0xF), 0x90: (0x0, 0x1, 0x2, 0xD, 0xE, 0xF)}
SAME = {group + low: 0x10 + low for group, services in _PRODUCT_SERVICES.items() for low in services}

IDENT, NAME, ATTRIBUTE, UNIT, MINIMUM, MAXIMUM, VALUE = range(1, 8)  # elements, fig. 8-1

# Fields inside of others: name and mask. Fig. 2-9, 8-1, 8-44; IEC 61491 for the attribute.
BITS = {
    "control": {"control.subaddresses": 0x07, "control.number": 0x08, "control.reaction": 0x10},
    "parameter_control": {"parameter_control.reserved": 0xC3, "transmission": 0x04, "element": 0x38},
    "data_status": {"data_status.set": 0x1, "data_status.enabled": 0x2, "data_status.not_executed": 0x4}
    | {"data_status.impossible": 0x8, "data_status.invalid": 0x100},
    "attribute": {"attribute.factor": 0xFFFF, "attribute.length": 7 << 16, "attribute.command": 1 << 19}
    | {"attribute.format": 7 << 20, "attribute.decimals": 15 << 24, "attribute.protected_2": 1 << 28}
    | {"attribute.protected_3": 1 << 29, "attribute.protected_4": 1 << 30},
    "control, IF02": {"control.reserved": 0x20, "control.warning": 0x40, "control.error": 0x80},
    "control, ECODRIVE03 command": {"control.reserved_bits": 0xE0},
    "control, ECODRIVE03 reaction": {"control.status": 0xE0},
}
TEXTS = {"version", "firmware", "type_key", "element.name", "element.unit"}
TIMES = {"init.time", "init.test_time"}
_STATUS_NOTES = ("status.execution_error", "status.telegram_error")


class Field(NamedTuple):
    """A field of the plugin, without its `sis.`; `at` is None for what does not stand in the telegram itself."""

    name: str
    at: int | None
    size: int
    value: int | str  # of bytes their hex digits, of times ms


@dataclass
class Decoded:
    """The contents of a telegram."""

    fields: list[Field] = field(default_factory=list)
    open: set[int] = field(default_factory=set)  # bytes that may be shown in any way
    details_open: set[int] = field(default_factory=set)  # data that may be shown in parts, too
    parameter_open: bool = False  # whether a reaction may name a parameter, or not
    notes: dict[str, bool | None] = field(default_factory=dict)  # expert items: there, not there, or None: either

    def note(self, name: str, said: bool | None) -> None:
        """Note something, or its absence. A note on a part of the telegram applies to the whole telegram."""
        before = self.notes.get(name, False)
        self.notes[name] = True if said or before else None if said is None else before


@dataclass
class Body:
    """The body of a service in a telegram; fields are taken from the front."""

    telegram: bytes
    at: int
    end: int
    service: int
    asked: bytes | None  # body of the command, where this is a reaction to one that is known
    reaction: bool
    decoded: Decoded
    status_open: bool = True  # whether there may be a status in what is left

    @property
    def left(self) -> bytes:
        """Return the bytes that are left."""
        return self.telegram[self.at : self.end]

    @property
    def kind(self) -> int:
        """Return the service of SERCOS that has this body, or the service itself."""
        return SAME.get(self.service, self.service)

    def add(self, name: str, size: int = 1, value: int | str | None = None) -> None:
        """Take a field with its subfields. Numbers are little endian (chapter 2.1)."""
        data = self.left[:size]
        if value is None and name in TEXTS:
            value = data.decode("latin-1")
        elif value is None:
            value = data.hex() if name in ("raw", "data") else int.from_bytes(data, "little")
        self.decoded.fields.append(Field(name, self.at, size, value))
        if isinstance(value, int):
            self.add_bits(BITS.get(name, {}), value, self.at, size)
        self.at += size

    def add_bits(self, bits: dict[str, int], number: int, at: int, size: int) -> None:
        """Add the fields inside of a number."""
        self.decoded.fields += [Field(name, at, size, (number & mask) // (mask & -mask)) for name, mask in bits.items()]

    def leave(self) -> None:
        """Leave the rest open."""
        self.decoded.open |= {*range(self.at, self.end)}
        self.decoded.note("body.missing", None)
        if self.left:
            self.decoded.note("body.unexpected", None)
        if self.reaction and self.status_open:
            for name in _STATUS_NOTES:
                self.decoded.note(name, None)
        self.at = self.end

    def note_length(self, size: int) -> None:
        """Note whether a written segment has the announced length (chapter 8.6); the consequences are open."""
        last = self.decoded.fields[-1]
        words = 2 if self.service == 0x8E else 1
        if last.name == "list_length" and isinstance(last.value, int) and last.value * words != size:
            self.decoded.note("body.missing", None)
            self.decoded.note("body.unexpected", None)

    def show_rest(self, unexpected: bool | None) -> None:
        """Take the rest as undecoded bytes."""
        if self.left:
            self.decoded.note("body.unexpected", unexpected)
            self.add("raw", len(self.left))

    def take(self, layout: str) -> None:
        """Take the items of a layout; an item with too few bytes is not decoded, nor are bytes after the last item."""
        for item in layout.split():
            name, _, width = item.rstrip("?").partition(":")
            size = len(self.left) if width == "*" else int(width or 1)
            if name == "~":
                if self.left or not item.endswith("?"):
                    self.leave()
            elif name == "raw":
                self.show_rest(None)
            elif size == 0:  # what is read has data (chapter 8.2), if this answers a command that is known
                is_read = self.reaction and self.kind == 0x10 and self.asked and not self.decoded.parameter_open
                self.decoded.note("body.missing", True if is_read else None)
            elif len(self.left) < size:
                self.decoded.note("body.missing", None if item.endswith("?") else True)
                self.show_rest(None)
                return
            elif name in _SPECIAL:
                _SPECIAL[name](self, size)
            else:
                self.add(name, size)
        self.show_rest(unexpected=True)


def parameter_text(ident: bytes) -> str | None:
    """Return how a parameter is written (fig. 8-3), None where its bits are not defined."""
    kind, word = ident[0], int.from_bytes(ident[1:], "little")
    if kind > 2 or (kind and word >> 15):
        return None
    return f"{'AC'[kind - 1] if kind else 'SP'[word >> 15]}-{word >> 12 & 7}-{word & 0xFFF:04}"


def _take_parameter(body: Body, size: int) -> None:
    """Take a parameter (fig. 8-3)."""
    ident, at = body.left[:size], body.at
    text = parameter_text(ident)
    if text is None:
        body.decoded.open |= {*range(at, at + size)}
        body.at += size
        return
    body.add("parameter", size, text)
    body.decoded.fields.append(Field("parameter.type", at, 1, ident[0]))
    if ident[0] == 0:  # only parameters of drives are S or P
        body.add_bits({"parameter.product_specific": 0x8000}, ident[2] << 8, at + 1, 2)
    body.add_bits({"parameter.set": 0x7000, "parameter.number": 0x0FFF}, int.from_bytes(ident[1:], "little"), at + 1, 2)


def _take_element(body: Body, size: int) -> None:
    """Take data of an element: names and units are lists of characters, the attribute has bits (IEC 61491).

    Whether data in pieces, in segments or to be written count as a value is open.
    """
    *_, control = (known.value for known in body.decoded.fields if known.name == "parameter_control")
    assert isinstance(control, int)
    start, element, read = body.at, control >> 3 & 7, body.reaction and body.kind == 0x10 and control & 4
    body.note_length(size)
    body.add("data", size)
    if read and element == ATTRIBUTE and size == 4:
        body.at = start
        body.add("attribute", size)
    elif read and element in (NAME, UNIT):
        body.at = start
        actual, maximum = (int.from_bytes(body.left[at : at + 2], "little") for at in (0, 2))
        if size >= 4 and actual + 4 == size and actual <= maximum:
            body.add("list.actual", 2)
            body.add("list.maximum", 2)
        if body.left:
            body.add("element.name" if element == NAME else "element.unit", len(body.left))
    else:
        body.decoded.details_open |= {*range(start, body.end)}


def _take_error(body: Body, size: int) -> None:
    """Take an error code; where one byte is sent, the subservice before it is the upper one (chapters 5.1 and 6.1)."""
    upper = body.telegram[body.at - 1] if size == 1 else 0
    body.add("error", size, upper << 8 | int.from_bytes(body.left[:size], "little"))


def _take_status(body: Body, size: int) -> None:
    """Take a status (fig. 2-18)."""
    status = body.left[0]
    body.add("status", size)
    body.status_open = False
    for name, said in zip(_STATUS_NOTES, (0 < status < 0xF0, status >= 0xF0), strict=True):
        body.decoded.note(name, said)


def elements(body: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield service and body of each element of a list, up to one that is not whole (chapter 7.1)."""
    while body and 0 < body[0] < len(body):
        yield body[1], body[2 : body[0] + 1]
        body = body[body[0] + 1 :]


def _take_list(body: Body, size: int) -> None:
    """Take a list of services; the reaction has the elements of the command in their order (chapter 7.1)."""
    asked = list(elements(body.asked or b""))
    notes = body.decoded.notes
    overall = notes.pop(_STATUS_NOTES[0], False)
    for number, (service, inner) in enumerate(elements(body.left[:size])):
        body.add("element_length")
        body.add("service")
        known = asked[number][1] if number < len(asked) and asked[number][0] == service else None
        part = Body(body.telegram, body.at, body.at + len(inner), service, known, body.reaction, body.decoded)
        if service == 0x04:  # not in its own list
            body.decoded.note("list.recursion", True)
            part.leave()
        else:
            _take_service(part)
        body.at = part.end
    said = {notes.get(name, False) for name in _STATUS_NOTES}
    if True not in said:  # otherwise an element says what went wrong, and is the only item
        body.decoded.note(_STATUS_NOTES[0], None if overall and None in said else overall)
    if body.left:
        body.status_open = body.decoded.parameter_open = True
        body.leave()


_SPECIAL = {
    "parameter": _take_parameter,
    "element_data": _take_element,
    "error": _take_error,
    "status": _take_status,
    "list": _take_list,
}


def _subservice(service: int, body: bytes, at: int) -> tuple[str, str]:
    """Return what follows a subservice; of 0x03 several may come in one telegram (chapter 6.1)."""
    command, reaction = SUBSERVICES[service].get(body[at] if at < len(body) else -1, ("~", "~"))
    if service == 0x02 and body[1:] == b"\x94" + b"\xff" * 8:
        command = "~"  # all but loader and kernel, so this is no address (chapter 5.1)
    if service == 0x00 and (len(body) > 43 or (reaction == "version:5" and len(body) not in (3, 8))):
        reaction = "~"  # not the number of characters that a text has (chapter 3.1)
    return (f"{command} ~?", f"{reaction} ~?") if service == 0x03 else (command, reaction)


def command_layout(service: int, body: bytes) -> str:
    """Return the layout of a command's body, of which only the first bytes matter."""
    if service == 0x01:  # both may be missing, so that one alone may be either (chapter 4.1)
        return ("", "~")[len(body)] if len(body) < 2 else "device canceled_service"
    kind = SAME.get(service, service)
    if kind in SUBSERVICES:
        return f"{COMMANDS[kind]} {_subservice(kind, body, 1)[0]}"
    # The body of a product group may be ASCII (chapter 2.1).
    return COMMANDS.get(kind, "~" if 0x80 <= service <= 0xEF else "raw:*")


def is_text(body: bytes) -> bool:
    """Tell whether this may be an ASCII record, as product groups have them (chapter 2.1)."""
    return all(0x20 <= byte < 0x7F or byte in b"\t\n\f\r" for byte in body)


def reaction_layout(service: int, body: bytes, asked: bytes | None) -> str:
    """Return the layout of a reaction's body to a command with the body `asked` (chapter 2.3)."""
    kind = SAME.get(service, service)
    if 0x20 <= service <= 0x7F or service >= 0xF0:
        return "raw:*"
    if service >= 0xA0 or (kind >= 0x80 and is_text(body)):
        return "~"
    if body and kind not in COMMANDS and kind != 0x01:
        return "status ~" if kind >= 0x80 or 0 < body[0] < 0xF0 else "status raw:*"
    status = body[0] if body else 0
    if kind == 0x04 and status < 0xF0:
        is_list = status < 2 or (status == 2 and len(body) > 3)  # not the code of the channel (fig. 2-19)
        return "status list:*" if is_list else "status ~"
    head = HEADS.get(kind, "")
    if kind == 0x01:  # the device stands here if it stood in the command (chapter 4.1)
        if asked is None or len(asked) == 1:
            return "status ~"
        head = "device" if asked else ""
    return f"status {_failed(kind, status, head, body) if status else _good(kind, head, body)}"


def _good(kind: int, head: str, body: bytes) -> str:
    """Return the layout of a good reaction behind its status."""
    if kind in (0x1E, 0x1F) and len(body) > 1 and body[1] >> 3 & 7 == IDENT:  # of a data status: chapters 8.6 and 8.7
        return f"{head} data_status:2?"
    return f"{head} {_subservice(kind, body, 2)[1] if kind in SUBSERVICES else GOOD.get(kind, '')}"


def _failed(kind: int, status: int, head: str, body: bytes) -> str:
    """Return the layout of a reaction behind a status that is an error (fig. 2-18)."""
    if status >= 0xF0:
        return " ".join(f"{item}?" for item in head.split())  # no useful data
    if kind in (0x12, 0x1D):  # chapters 8.4 and 8.5 have 2
        return {1: "raw:*", 2: "phase error:2"}.get(status, "~")
    several = kind == 0x03 and len(body) > 4  # subservices
    if status == 1 and kind in SUBSERVICES and kind != 0x00 and not several:
        return f"{head} error"
    known = kind != 0x01 and (status == 2 or (status == 1 and kind >= 0x10))
    return f"{head} error:2" if known else f"{head} ~"


def _add_parameter(body: Body, asked: bytes) -> None:
    """Add the parameter of a reaction, which only its command names; both have one device and element (chapter 8.1)."""
    text = parameter_text(asked[2:5]) if len(asked) >= 5 else None
    if text and len(body.left) >= 3 and body.left[1] | 4 == asked[0] | 4 and body.left[2] == asked[1]:
        body.decoded.fields.append(Field("parameter", None, 0, text))
    else:
        body.decoded.parameter_open = True


def _take_service(body: Body) -> None:
    """Take the body of a service."""
    for name in ("body.missing", "body.unexpected"):
        body.decoded.note(name, False)
    if not body.reaction:
        return body.take(command_layout(body.service, body.left))
    if body.asked is not None and HEADS.get(body.kind) == _HEAD:
        _add_parameter(body, body.asked)
    return body.take(reaction_layout(body.service, body.left, body.asked))


def _is_reserved(service: int, ecodrive03: bool) -> bool | None:
    """Tell whether a service is reserved (chapter 2.2); of ECODRIVE03 it is open below the product groups."""
    if ecodrive03 and 0x04 <= service <= 0x1F:
        return None
    return (0x13 <= service <= 0x7F and service not in COMMANDS) or service >= (0xE0 if ecodrive03 else 0xF0)


def _note_addresses(decoded: Decoded, sender: int, addresses: bytes, reaction: bool, ecodrive03: bool) -> None:
    """Note what is wrong with addresses; `addresses` are the receiver and the subaddresses (fig. 2-9; ECODRIVE03)."""
    decoded.note("sender.invalid", sender > 127)
    decoded.note("sender.service_master", sender == 127 and not ecodrive03)
    decoded.note("reaction.unexpected", reaction and addresses[-1] >= (128 if ecodrive03 else 200))
    decoded.note("receiver.level_broadcast", 254 in addresses[:-1] and not ecodrive03)
    reserved = [not ecodrive03 and (address == 127 or 129 <= address <= 199) for address in addresses]
    decoded.note("receiver.reserved", reserved[0] or (None if any(reserved) else False))


def _take_header(telegram: bytes, ecodrive03: bool) -> Body:
    """Take the header (chapter 2.2); the body is what the lengths leave for it."""
    decoded = Decoded()
    end = min(len(telegram), 8 + telegram[3])
    header = Body(telegram, 0, end, telegram[5], None, bool(telegram[4] & 0x10), decoded)
    for name in ("start", "checksum", "length", "length_repeat", "control", "service", "sender", "receiver"):
        header.add(name)
    edition = "IF02" if not ecodrive03 else "ECODRIVE03 reaction" if header.reaction else "ECODRIVE03 command"
    header.add_bits(BITS[f"control, {edition}"], telegram[4], 4, 1)
    count, numbered = telegram[4] & 7, telegram[4] >> 3 & 1
    decoded.note("length.header", telegram[3] < count + numbered if telegram[2] == telegram[3] else None)
    if len(header.left) < count + numbered:
        header.leave()
        return header
    for name in ["subaddress"] * count + ["number"] * numbered:
        header.add(name)
    stations = telegram[7:5:-1] if header.reaction else telegram[6:8]  # a reaction keeps the addresses (fig. 2-12)
    decoded.fields += [Field("talker", None, 0, stations[0]), Field("listener", None, 0, stations[1])]
    _note_addresses(decoded, telegram[6], telegram[7 : 8 + count], header.reaction, ecodrive03)
    return header


def body_of(telegram: bytes) -> bytes:
    """Return the service body of a whole telegram."""
    return _take_header(telegram, False).left


def decode(telegram: bytes, command: bytes | None = None, *, ecodrive03: bool = False) -> Decoded:
    """Return what a telegram of at least 8 bytes says; `command` is the telegram that it answers, if that is known."""
    body = _take_header(telegram, ecodrive03)
    decoded = body.decoded
    good = sum(telegram) & 0xFF == 0
    same = telegram[2] == telegram[3]
    whole = telegram[0] == 0x02 and same and len(telegram) == 8 + telegram[3]
    decoded.note("start.missing", telegram[0] != 0x02)
    decoded.note("length.differ", not same)
    if same:
        decoded.note("length.short", len(telegram) < 8 + telegram[3])
        decoded.note("length.long", len(telegram) > 8 + telegram[3])
    if whole:
        decoded.fields.append(Field("checksum.status", None, 0, int(good)))
        decoded.note("checksum.bad", not good)
    service = telegram[5]
    decoded.note("service.reserved", _is_reserved(service, ecodrive03))
    if not (whole and good):
        body.end = len(telegram)
        body.leave()
    elif ecodrive03 and service in (0x04, *range(0xE0, 0xF0)):  # not in this edition
        decoded.parameter_open = True
        body.leave()
    elif telegram[3] >= (telegram[4] & 7) + (telegram[4] >> 3 & 1):
        body.asked = body_of(command) if command else None
        _take_service(body)
    return decoded


def _parts(telegram: bytes) -> list[tuple[int, bytes]]:
    """Return the services of a telegram with their bodies: its own, or those of the elements of its list."""
    body = body_of(telegram)
    if telegram[5] != 0x04:
        return [(telegram[5], body)]
    return list(elements(body[1:] if telegram[4] & 0x10 else body))


class Transfers:
    """Long data in pieces (chapters 2.4, 8.2 and 8.7), from good telegrams in their order, of stations without routers.

    The useful data header, the sender and the service stay the same from piece to piece (0xF8 in fig. 2-18), so whether
    the pieces stand in lists does, too.
    """

    def __init__(self) -> None:
        """Begin with nothing under way."""
        self._asked: dict[bytes, list[tuple[int, bytes]]] = {}  # the last command between two stations
        # By stations, the services of telegram and data, and the header of the data.
        self._begun: dict[tuple[bytes, int, int, bytes], bytes] = {}

    def take(self, telegram: bytes) -> list[bytes]:
        """Return the data of which this telegram has the last of several pieces."""
        stations, parts = telegram[6:8], _parts(telegram)
        if not telegram[4] & 0x10:
            self._asked[stations] = parts
            if stations[1] >= 254:
                self._cancel(parts, lambda known: known[:1] == stations[:1])  # nobody answers (fig. 2-3)
            return self._join(telegram, [(service, body[:5], body[5:]) for service, body in parts if service == 0x1F])
        answered = list(zip(self._asked[stations], parts, strict=True))
        good = [asked for asked, (_, body) in answered if body[0] == 0]
        self._cancel(good, lambda known: known == stations)
        read = [(asked, body) for asked, (service, body) in answered if service == 0x10 and body[0] == 0]
        return self._join(telegram, [(0x10, body[1:2] + asked[1:5], body[3:]) for (_, asked), body in read])

    def _join(self, telegram: bytes, pieces: list[tuple[int, bytes, bytes]]) -> list[bytes]:
        """Take pieces: service, useful data header of the command, data."""
        wholes = []
        for service, header, data in pieces:
            last = header[0] & 4  # fig. 8-1
            key = telegram[6:8], telegram[5], service, bytes([header[0] & ~4]) + header[1:]
            if last and key in self._begun:
                wholes.append(self._begun.pop(key) + data)
            elif not last:
                self._begun[key] = self._begun.get(key, b"") + data
        return wholes

    def _cancel(self, parts: list[tuple[int, bytes]], reaches: Callable[[bytes], bool]) -> None:
        """End what is cancelled (chapter 4): all, or a service of a device."""
        for service, body in parts:
            if service == 0x01:
                over = [key for key in self._begun if reaches(key[0]) and body in (b"", bytes([key[3][1], key[2]]))]
                for key in over:
                    del self._begun[key]
