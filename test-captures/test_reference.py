# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares random telegrams in the plugin and in a decoder made from the documents alone (`reference.py`)."""

from __future__ import annotations

import html
import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, TypedDict

import pytest

import reference
import tables
from reference import BITS, Field, command_layout, decode, reaction_layout
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files.pcapng import (
    LINKTYPE_WIRESHARK_UPPER_PDU,
    Interface,
    enhanced_packet,
    interface_description,
    section_header,
    upper_pdu,
)
from sistap.tap.sis.telegram import build

PREFIX = len(upper_pdu("sis", b""))
MS = 10**6  # ns

# Services with a known body are more frequent; so is the element of parameters.
KNOWN = [*reference.COMMANDS, 0x01, *reference.SAME] * 4 + [0x00, 0x02, 0x03, 0x04, 0x10, 0x1F] * 8
STATUSES = [0] * 20 + [1, 1, 1, 2, 2, 3, 0xEF, 0xF0, 0xF1, 0xF4, 0xF8, 0xFA, 0xFF]
CONTROLS = [0x3C] * 6 + [element << 3 | 4 for element in (*range(8), 1, 2, 3, 3, 4)] + [0x38, 0x38, 0x10]

# Fields whose place and value are compared, and those with a known value only.
NAMES = {
    *"start checksum length length_repeat control service sender receiver subaddress number status device".split(),
    *"subservice error raw data text version firmware type_key init.baud_mask canceled_service flash.address".split(),
    *"flash.length flash.target flash.device_type flash.crc32 init.time init.test_time element_length".split(),
    *"parameter_control parameter parameter.type list_offset list_length data_status phase attribute".split(),
    *"element.name element.unit list.actual list.maximum talker listener checksum.status".split(),
    *(name for bits in BITS.values() for name in bits),
    *("parameter.product_specific", "parameter.set", "parameter.number"),
}
DETAILS = {name for name in NAMES if name.startswith(("attribute", "element.", "list.", "parameter.product"))}
DERIVED = {"value"}  # from bytes that another field has to show


class Exchange(NamedTuple):
    """A telegram, and the command that it answers."""

    telegram: bytes
    command: bytes | None


class Options(TypedDict):
    """The properties of a telegram besides service, stations and body."""

    subaddresses: bytes
    number: int | None
    system: int


def _item(rng: random.Random, name: str, width: str) -> bytes:
    """Make what an item of a layout may have."""
    size = rng.choice((0, 1, 2, 2, 4, 4, 4, 8, rng.randrange(40))) if width == "*" else int(width or 1)
    if name == "parameter_control":
        return bytes([rng.choice(CONTROLS) if rng.random() < 0.95 else rng.randrange(256)])
    if name == "parameter":
        kind = rng.choice((0, 0, 0, 0, 1, 2, 2, rng.randrange(256)))
        return bytes([kind, rng.randrange(256), rng.randrange(256 if kind == 0 or rng.random() < 0.1 else 128)])
    if name in reference.TEXTS or (name == "element_data" and rng.random() < 0.5):
        text = bytes(rng.choices(b" ABCDEFxyz0123456789-,.+/&<\0\xb5", k=size))
        if name == "element_data" and rng.random() < 0.3:
            return size.to_bytes(2, "little") + rng.randbytes(1) + b"\1" + text
        return text
    return rng.randbytes(size)


def _fill(rng: random.Random, layout: str, head: bytes) -> bytes:
    """Make a body by a layout, of which the head is already there."""
    body = b""
    for item in layout.split():
        name, _, width = item.rstrip("?").partition(":")
        if item.endswith("?") and rng.random() < 0.4:
            break
        if name == "list":
            continue
        body += head[len(body) : len(body) + 1] if len(body) < len(head) else _item(rng, name, width)
    return body


def _command(rng: random.Random, service: int, depth: int = 0) -> bytes:
    """Make the body of a command as it should be."""
    if service == 0x04 and depth == 0:
        inner = rng.choices(KNOWN, k=rng.randrange(6))
        return b"".join(_element(number, _command(rng, number, 1)) for number in inner)
    if service == 0x01:
        return rng.randbytes(rng.choice((0, 1, 2, 2)))
    body = _fill(rng, command_layout(service, head := _head(rng, service)), head)
    if reference.SAME.get(service, service) == 0x1E and rng.random() < 0.8:  # as long as it says; 0x8E counts words
        length = len(body[9:]) // (2 if service == 0x8E else 1)
        body = body[:7] + length.to_bytes(2, "little") + body[9:]
    return body


def _element(service: int, body: bytes) -> bytes:
    return bytes([len(body) + 1, service]) + body


def _head(rng: random.Random, service: int) -> bytes:
    """Make the first bytes of a command, which say what follows."""
    kind = reference.SAME.get(service, service)
    if kind in reference.SUBSERVICES:
        known = rng.choice((*reference.SUBSERVICES[kind],)) if rng.random() < 0.9 else rng.randrange(256)
        return bytes([rng.randrange(256), known])
    return b""


def _reaction(rng: random.Random, service: int, asked: bytes, depth: int = 0) -> bytes:
    """Make the body of a reaction as it should be."""
    status = rng.choice(STATUSES)
    if service == 0x04 and depth == 0:
        inner = [(number, _reaction(rng, number, body, 1)) for number, body in reference.elements(asked)]
        return bytes([rng.choice((0, 1))]) + b"".join(_element(*element) for element in inner)
    head = bytes([status])
    kind = reference.SAME.get(service, service)
    if kind in reference.HEADS:
        control = asked[:1] if rng.random() < 0.9 else bytes([asked[0] & ~4]) if asked else b""
        head += control + asked[1:2]
    return _fill(rng, reaction_layout(service, head, asked), head)


def _odd(rng: random.Random, body: bytes) -> bytes:
    """Make a body wrong, now and then."""
    kind = rng.random()
    if kind < 0.12:
        return body[: rng.randrange(len(body) + 1)]
    if kind < 0.22:
        return body + rng.randbytes(rng.randrange(1, 6))
    return rng.randbytes(rng.randrange(20)) if kind < 0.26 else body


def _damaged(rng: random.Random, telegram: bytes) -> bytes:
    """Make a telegram that no station may understand."""
    at = rng.choice((0, 1, 2, 3, -1))
    changed = bytearray(telegram)
    changed[at] ^= rng.randrange(1, 256)
    cut = telegram[: rng.randrange(8, len(telegram) + 1)]
    return rng.choice((bytes(changed), cut, telegram + rng.choice((b"\0\x10", b"\xff"))))  # no start of another one


def _short_header(rng: random.Random, service: int, sender: int, receiver: int) -> bytes:
    """Make a telegram whose lengths have no room for the subaddresses of its control."""
    count, number = rng.randrange(1, 8), rng.choice((0, 8))
    left = rng.randbytes(rng.randrange(count))
    rest = bytes([len(left), len(left), count | number, service, sender, receiver]) + left
    return bytes([2, -(2 + sum(rest)) & 0xFF]) + rest


def _exchange(rng: random.Random, index: int, system: int) -> Iterator[Exchange]:
    """Make a command and usually its reaction; every index has its own two stations, so that exchanges do not mix."""
    sender, receiver = divmod(index * 7919 % 14400, 120)
    service = rng.choice(KNOWN) if rng.random() < 0.85 else rng.randrange(256)
    if rng.random() < 0.06:
        sender = rng.choice((127, 128, 255))
    if alone := rng.random() < 0.06:
        receiver = rng.choice((127, 128, 129, 199, 200, 253, 254, 255))
    options: Options = {
        "subaddresses": rng.randbytes(rng.choice((0, 0, 0, 0, 1, 2, 7))),
        "number": rng.choice((None, None, rng.randrange(256))),
        "system": rng.choice((0, 0, system)),
    }
    if (kind := rng.random()) < 0.02:
        yield Exchange(_short_header(rng, service, sender, receiver), None)
        return
    asked = _odd(rng, _command(rng, service))
    command = build(service, sender, receiver, asked, **options)
    if kind < 0.06:
        yield Exchange(_damaged(rng, command), None)
        return
    if kind < 0.12:  # a reaction of stations that nobody asks
        sender, receiver = rng.randrange(120, 127), receiver if alone else rng.randrange(120, 127)
        body = _odd(rng, _reaction(rng, service, asked))
        yield Exchange(build(service, sender, receiver, body, reaction=True, **options), None)
        return
    yield Exchange(command, None)
    if not alone and rng.random() < 0.9:
        body = _odd(rng, _reaction(rng, service, asked))
        yield Exchange(build(service, sender, receiver, body, reaction=True, **options), command)


def exchanges(seed: str, count: int) -> list[Exchange]:
    """Make that many telegrams."""
    rng = random.Random(seed)
    made: list[Exchange] = []
    for index in range(count):
        made += _exchange(rng, index, rng.choice((0x20, 0x40, 0x80, 0xE0)))
        if len(made) >= count:
            break
    return made[:count]


_FIELD = re.compile(
    r'<field name="sis\.([^"]+)"[^>]*? size="(\d+)" pos="(\d+)"(?: show="([^"]*)")?(?: value="([^"]*)")?'
)
_WORDS = {"True": "1", "False": "0"}  # of Wireshark 4.2 and later


def _value(name: str, show: str, value: str) -> int | str:
    """Return a field's value as the reference has it."""
    if name in ("raw", "data", "text"):
        return value
    if name in reference.TEXTS:  # tshark escapes what cannot be printed
        text = bytes.fromhex(value).decode("latin-1")
        return html.unescape(show) if re.fullmatch(r"[ -~]*", text) else text
    if name in reference.TIMES:
        return round(float(show) * 1000)
    return show if name == "parameter" else int(_WORDS.get(show, show), 0)


def packets(pdml: str) -> Iterator[list[tuple[str, int, int, str, str]]]:
    """Yield what tshark shows of each packet: names, places and sizes in the telegram, values."""
    for packet in pdml.split("</packet>")[:-1]:
        found = _FIELD.findall(packet)
        yield [(name, int(at) - PREFIX, int(size), show, value) for name, size, at, show, value in found]


def differences(exchange: Exchange, shown: list[tuple[str, int, int, str, str]], ecodrive03: bool) -> list[str]:
    """Return where the plugin and the reference disagree on a telegram."""
    said = decode(*exchange, ecodrive03=ecodrive03)
    left = {
        Field(name, at if size else None, size, _value(name, show, value))
        for name, at, size, show, value in shown
        if name in NAMES
        and not said.open.intersection(range(at, at + size))
        and not (name in DETAILS and said.details_open.intersection(range(at, at + size)))
    }
    wanted = {*said.fields}
    if said.parameter_open:
        left, wanted = ({known for known in fields if known[:2] != ("parameter", None)} for fields in (left, wanted))
    derived = {known.name for known in wanted if known.at is None} | {"parameter"}
    left -= {known for known in left if known.at is None and known.name not in derived}
    wrong = [f"missing {known}" for known in wanted - left]
    wrong += [f"unexpected {known}" for known in left - wanted]
    there = {name for name, *_ in shown}
    wrong += [f"note {name}: {not is_so}" for name, is_so in said.notes.items() if is_so not in (None, name in there)]
    covered = {at + offset for name, at, size, *_ in shown if name not in DERIVED for offset in range(size)}
    bare = {*range(len(exchange.telegram))} - covered
    return sorted(wrong) + ([f"not shown at all: {sorted(bare)}"] if bare else [])


def _compare(seed: int, count: int, edition: str, tshark: Tshark, tmp_path: Path) -> None:
    made = exchanges(f"{seed} {edition}", count)
    path = tmp_path / "random.pcapng"
    with path.open("wb") as file:
        file.write(section_header("", "") + interface_description(Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "")))
        for number, exchange in enumerate(made):
            file.write(enhanced_packet(0, number * MS, upper_pdu("sis", exchange.telegram)))
    pdml = tshark.output("-r", str(path), "-o", f"sis.edition:{edition}", "-T", "pdml", "-J", "sis")
    wrong = []
    for number, (exchange, shown) in enumerate(zip(made, packets(pdml), strict=True), 1):
        if found := differences(exchange, shown, edition == "ECODRIVE03"):
            asked = f"\n  command {exchange.command.hex(' ')}" if exchange.command else ""
            wrong.append(f"{number}: {exchange.telegram.hex(' ')}{asked}\n  " + "\n  ".join(found))
    assert not wrong, f"{len(wrong)} telegrams\n" + "\n".join(wrong[:50])


@pytest.mark.parametrize("edition", ["IF02", "ECODRIVE03"])
def test_random_telegrams(edition: str, tshark: Tshark, tmp_path: Path) -> None:
    _compare(1, 250, edition, tshark, tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("edition", ["IF02", "ECODRIVE03"])
@pytest.mark.parametrize("seed", range(2, 6))
def test_many_random_telegrams(seed: int, edition: str, tshark: Tshark, tmp_path: Path) -> None:
    _compare(seed, 2500, edition, tshark, tmp_path)


class Step(NamedTuple):
    """A service in a command, and its good reaction."""

    service: int
    asked: bytes
    answered: bytes


@dataclass
class Long:
    """Long data of a device, read or written in pieces."""

    service: int
    listed: bool
    parameter: bytes
    pieces: list[bytes]

    def step(self, device: int) -> Step:
        """Carry the next piece (chapters 8.2 and 8.7)."""
        data = self.pieces.pop(0)
        control = 0x38 if self.pieces else 0x3C
        if self.service == 0x1F:
            return Step(0x1F, bytes([control, device]) + self.parameter + data, bytes([0, control, device]))
        return Step(0x10, bytes([0x3C, device]) + self.parameter, bytes([0, control, device]) + data)


Under = dict[tuple[int, int, int], Long]  # by master, station and device


def _long(rng: random.Random, listed: bool) -> Long:
    pieces = [rng.randbytes(rng.randrange(1, 5)) for _ in range(rng.randrange(1, 5))]
    return Long(rng.choice((0x10, 0x1F)), listed, bytes([0, rng.choice((30, 31)), 0]), pieces)


def _cancel(rng: random.Random, under: Under, master: int, station: int) -> Step:
    """Cancel all, or a service of a device; whatever is under way there begins anew."""
    device, service = rng.randrange(1, 4), rng.choice((0x10, 0x1F))
    what = rng.choice((b"", bytes([device, service])))
    for key, data in list(under.items()):
        is_meant = not what or (key[2], data.service) == (device, service)
        if is_meant and key[0] == master and (station >= 254 or key[1] == station):
            del under[key]
    return Step(0x01, what, b"\0" + what[:1])


def _steps(rng: random.Random, under: Under, master: int, station: int, listed: bool) -> list[Step]:
    """Go on with some devices, or begin there; in a list, the first element may cancel.

    What is written after that may begin anew or not: only the reaction tells whether the cancel was executed.
    """
    steps = [_cancel(rng, under, master, station)] if rng.random() < 0.15 else []
    is_cancelled = bool(steps)
    for device in rng.sample((1, 2, 3), rng.randrange(1, 4) if listed else not is_cancelled):
        data = under.setdefault((master, station, device), _long(rng, listed))
        if data.listed == listed and not (is_cancelled and data.service == 0x1F):
            steps.append(data.step(device))
        if not data.pieces:
            del under[master, station, device]
    return steps


def transfers(seed: str, count: int) -> Iterator[bytes]:
    """Make a conversation of two masters and two stations in which all is as it should be."""
    rng = random.Random(seed)
    under: Under = {}
    for _ in range(count):
        master, station, listed = rng.choice((16, 17)), rng.choice((3, 4)), rng.random() < 0.6
        if rng.random() < 0.05:
            station = rng.choice((254, 255))
            steps = [_cancel(rng, under, master, station)]
        else:
            steps = _steps(rng, under, master, station, listed)
        if not steps:
            continue
        service = 0x04 if listed else steps[0].service
        asked = b"".join(_element(step.service, step.asked) for step in steps) if listed else steps[0].asked
        yield build(service, master, station, asked)
        if station < 254:
            answered = b"".join(_element(step.service, step.answered) for step in steps)
            body = b"\0" + answered if listed else steps[0].answered
            yield build(service, master, station, body, reaction=True)


def _check_transfers(seed: int, count: int, tshark: Tshark, tmp_path: Path) -> None:
    made = list(transfers(f"{seed}", count))
    path = tmp_path / "transfers.pcapng"
    with path.open("wb") as file:
        file.write(section_header("", "") + interface_description(Interface(LINKTYPE_WIRESHARK_UPPER_PDU, "")))
        for number, telegram in enumerate(made):
            file.write(enhanced_packet(0, number * MS, upper_pdu("sis", telegram)))
    said = reference.Transfers()
    expected = [[whole.hex() for whole in said.take(telegram)] for telegram in made]
    assert sum(map(len, expected)) > count // 10
    for passes in ((), ("-2",)):
        frames = tables.shown(tshark, path, "data sequence.length", *passes)
        for number, wholes in enumerate(expected, 1):
            lengths = frames[number].get("sequence.length", "")
            assert lengths == ",".join(str(len(whole) // 2) for whole in wholes), f"frame {number} {passes}"
            assert {*wholes} <= {*frames[number].get("data", "").split(",")}, f"frame {number} {passes}"


def test_random_transfers(tshark: Tshark, tmp_path: Path) -> None:
    """Pieces in telegrams and in lists, and cancels: which data are whole."""
    _check_transfers(1, 400, tshark, tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(2, 6))
def test_many_random_transfers(seed: int, tshark: Tshark, tmp_path: Path) -> None:
    _check_transfers(seed, 4000, tshark, tmp_path)
