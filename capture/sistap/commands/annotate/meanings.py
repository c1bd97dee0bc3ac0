# SPDX-License-Identifier: GPL-2.0-or-later
"""What each byte of a telegram means: the fields of the dissector with their places, from tshark's PDML."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, XMLPullParser

from sistap.dissected.wireshark.tshark import Tshark

# Kinds of fields.
FRAME, CONTROL, SERVICE, ADDRESS = "frame", "control", "service", "address"
STATUS, OBJECT, DATA = "status", "object", "data"

_PROTOCOLS = ("sis", "3964r", "rk512i", "sisascii")  # protocols that give a byte a meaning, from the outside in

# Fields that are not listed are useful data.
KINDS = {
    "sis.start": FRAME,
    "sis.checksum": FRAME,
    "sis.length": FRAME,
    "sis.length_repeat": FRAME,
    "sis.control": CONTROL,
    "sis.number": CONTROL,
    "sis.sender": ADDRESS,
    "sis.receiver": ADDRESS,
    "sis.subaddress": ADDRESS,
    "sis.service": SERVICE,
    "sis.subservice": SERVICE,
    "sis.canceled_service": SERVICE,
    "sis.element_length": SERVICE,
    "sis.status": STATUS,
    "sis.error": STATUS,
    "sis.data_status": STATUS,
    "sis.device": OBJECT,
    "sis.parameter": OBJECT,
    "sis.parameter_control": OBJECT,
    "sis.parameter.type": OBJECT,
    "sis.parameter.number": OBJECT,
    "sis.list_offset": OBJECT,
    "sis.list_length": OBJECT,
    "3964r.character": FRAME,
    "3964r.end": FRAME,
    "3964r.bcc": FRAME,
    "rk512i.follow_up": CONTROL,
    "rk512i.zero": CONTROL,
    "rk512i.command": SERVICE,
    "rk512i.kind": SERVICE,
    "rk512i.error": STATUS,
    "rk512i.block": OBJECT,
    "rk512i.word": OBJECT,
    "rk512i.count": OBJECT,
    "synax.info": CONTROL,
    "synax.axis": ADDRESS,
    "sisascii.drive": ADDRESS,
    "sisascii.element": OBJECT,
}


class Meaning(NamedTuple):
    """What a byte means."""

    kind: str
    text: str


class Meanings:
    """The meanings of the bytes of each record of a capture, in their order, its event left out."""

    def __init__(self, tshark: Tshark, capture: Path) -> None:
        self._packets = _packets(tshark.lines(["-r", str(capture), "-2", "-T", "pdml", "-J", " ".join(_PROTOCOLS)]))
        next(self._packets, None)

    def get(self, data: bytes) -> list[Meaning | None]:
        """Return the meaning of each byte of the next record, None where the dissector says nothing."""
        meanings: list[Meaning | None] = [None] * len(data)
        packet = next(self._packets, None)
        for protocol in packet.iterfind("proto") if packet is not None else ():
            if protocol.get("name") in _PROTOCOLS:
                _note(protocol, data, int(protocol.get("pos", 0)), meanings)
        return meanings


def _packets(lines: Iterator[str]) -> Iterator[Element]:
    parser = XMLPullParser(("start", "end"))
    root = None
    for line in lines:
        parser.feed(line + "\n")
        for event, element in parser.read_events():
            if root is None:
                root = element
            elif event == "end" and element.tag == "packet":
                yield element
                root.clear()


def _note(
    parent: Element, data: bytes, start: int, meanings: list[Meaning | None], above: tuple[str, ...] = ()
) -> None:
    """Note the fields below one. Deeper fields are more exact, and their text includes the fields above.

    A field counts only if it holds the very bytes of the telegram. A reassembled whole has places of its own.
    """
    for field in parent.iterfind("field"):
        if field.get("unmaskedvalue") is not None:
            continue  # bits: the text of their field has them
        first, size = int(field.get("pos", 0)) - start, int(field.get("size", 0))
        text = (*above, field.get("showname") or field.get("show") or "")
        if size and first >= 0 and field.get("value") == data[first : first + size].hex():
            bits = (
                bit.get("showname") or "" for bit in field.iterfind("field[@unmaskedvalue]") if bit.get("value") != "0"
            )
            meaning = Meaning(KINDS.get(field.get("name", ""), DATA), "\n".join((*text, *bits)))
            meanings[first : first + size] = [meaning] * size
        _note(field, data, start, meanings, text if size else above)
