# SPDX-License-Identifier: GPL-2.0-or-later
"""Bad input is reported as bad, and never handled by Wireshark's own exceptions."""

from __future__ import annotations

import json
import random
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree

import pytest

import bad_input
import reference
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.sis import telegram

# Smallest and largest length of the useful data, from chapters 3 to 8 of the SIS definition.
Limits = tuple[int, int]
OPEN = 255


def limits(layout: str, head: int) -> Limits:
    """Return the limits of a layout of the reference behind a head."""
    words = [word.partition(":")[2] or "1" for word in layout.split()]
    least = head + sum(1 if size == "*" else int(size) for size in words if not size.endswith("?"))
    return least, OPEN if "*" in words else head + sum(int(size.rstrip("?")) for size in words)


UNKNOWN = (2, OPEN), (3, OPEN)  # of a command and of a reaction
COMMAND_HEAD, REACTION_HEAD = 2, 3  # device address and subservice; in a reaction after the status
SUBSERVICES = {
    (service, subservice): (limits(command, COMMAND_HEAD), limits(reaction, REACTION_HEAD))
    for service, layouts in reference.SUBSERVICES.items()
    for subservice, (command, reaction) in layouts.items()
}

SERCOS = {0x10, 0x11, 0x12, 0x1D, 0x1E, 0x1F}
WITH_STATUS = {*range(0x20), *range(0x80, 0xA0)}
HEADERS = dict.fromkeys((0x00, 0x02, 0x03, 0x10, 0x11, 0x1E, 0x1F), 3)  # of reactions; of the others the status
ERRORS = {0x02: (4, 4), 0x03: (4, 4)} | dict.fromkeys((0x10, 0x11, 0x1E, 0x1F), (5, 5))  # after status 1


def general(service: int) -> int:
    """Return the general service that a service of a product group is like."""
    return reference.SAME.get(service, service)


def is_ident(control: bytes) -> bool:
    """Tell whether the parameter control, if present, means the ident number."""
    return bool(control) and control[0] >> 3 & 7 == 1


def segment_limits(service: int, body: bytes) -> Limits:
    """Offset and length, then as many data as that says, in words for ECODRIVE."""
    least = 9 if is_ident(body) else 10
    if len(body) < 10:
        return least, OPEN
    announced = int.from_bytes(body[7:9], "little") * (2 if service == 0x8E else 1)
    return 9 + announced, 9 + announced


def command_limits(service: int, body: bytes) -> Limits:  # noqa: PLR0911 - a table
    subservice = body[1] if len(body) > 1 else -1
    match general(service):
        case 0x00:
            return 2, 2
        case 0x01:
            return 0, 2
        case 0x02 | 0x03:
            return SUBSERVICES.get((service, subservice), UNKNOWN)[0]
        case 0x10:
            return 5, 5
        case 0x11:
            return 9, 9
        case 0x12:
            return 0, 0
        case 0x1D:
            return 1, 1
        case 0x1E:
            return segment_limits(service, body)
        case 0x1F:
            return 5 if is_ident(body) else 6, OPEN
    return 0, OPEN


def good_reaction_limits(service: int, body: bytes) -> Limits:  # noqa: PLR0911 - a table
    subservice = body[2] if len(body) > 2 else -1
    match general(service):
        case 0x00 | 0x02:
            return SUBSERVICES.get((service, subservice), UNKNOWN)[1]
        case 0x01 | 0x1D:
            return 1, 2
        case 0x03:
            return 3, 3
        case 0x10 | 0x11:
            return 3, OPEN
        case 0x12:
            return 2, 2
        case 0x1E | 0x1F:
            return (5, 5) if is_ident(body[1:]) else (3, 3)
    return 1, OPEN


def reaction_limits(service: int, body: bytes) -> Limits:  # noqa: PLR0911 - a table
    if service not in WITH_STATUS:
        return 0, OPEN
    if not body:
        return 1, OPEN
    status, like = body[0], general(service)
    header = HEADERS.get(like, 1)
    if status == 0:
        return good_reaction_limits(service, body)
    if status == 2 and like in (0x12, 0x1D):
        return 4, 4
    if status == 2 and like != 0x01:  # whose reaction may have a device address or not
        return header + 2, header + 2
    if status == 1:
        return ERRORS.get(like, (header, OPEN))
    if status >= 0xF0 and like != 0x01:
        return 1 if len(body) == 1 else header, header  # no useful data
    return header, OPEN


def has_elements(service: int, reaction: bool, body: bytes) -> bool:
    """Tell whether this is a list. Chapter 7 has the status 0 and 1; with 2, a code has no more than two bytes."""
    if service != 0x04 or not reaction:
        return service == 0x04
    return body[:1] <= b"\x01" or (body[:1] == b"\x02" and len(body) > 3)


def is_short(service: int, reaction: bool, body: bytes) -> bool:
    """Tell whether something is missing; for service 0x04, also in its elements."""
    if not has_elements(service, reaction, body):
        limits = reaction_limits if reaction else command_limits
        return len(body) < limits(service, body)[0]
    if reaction and not body:
        return True
    rest = body[1:] if reaction else body
    while rest:
        element, length, rest = rest[1 : 1 + rest[0]], rest[0], rest[1 + rest[0] :]
        if len(element) < length:
            return True
        if element and element[0] != 0x04 and is_short(element[0], reaction, element[1:]):
            return True
    return False


def is_further(rest: bytes, reaction: bool, before: bytes) -> bool:
    """Tell whether these bytes are further subservices of 0x03, each with the bytes `before` it."""
    while rest:
        subservice = int.from_bytes(rest[len(before) : len(before) + 1])
        _, size = SUBSERVICES.get((0x03, subservice), UNKNOWN)[0]
        if len(rest) == len(before) or not rest.startswith(before) or size == OPEN:
            return False
        size = len(before) + (1 if reaction else size - 1)  # without the address that the first one has
        if len(rest) < size:
            return False
        rest = rest[size:]
    return True


def has_further(reaction: bool, body: bytes) -> bool:
    """Tell whether several subservices of 0x03 consume the body in exactly one of the two layouts."""
    head, limits = (1, reaction_limits) if reaction else (0, command_limits)
    rest, device = body[limits(0x03, body)[0] :], body[head : head + 1]
    return is_further(rest, reaction, b"") != is_further(rest, reaction, device)


def is_long(service: int, reaction: bool, body: bytes) -> bool:
    """Tell whether the service has fewer bytes; bytes after the last element of a list are an element."""
    limits = reaction_limits if reaction else command_limits
    if service == 0x03 and has_further(reaction, body):
        return False
    return not has_elements(service, reaction, body) and len(body) > limits(service, body)[1]


EXPERTS = (
    "body.missing body.unexpected body.note length.differ length.short length.header checksum.bad reaction.unasked "
    "reaction.again"
).split()
EMERGENCIES = ("Malformed Packet", "Dissector bug", "Exception", "Reassembly error", "Unreassembled")


MISFITS = {name for name in EXPERTS if name.startswith(("body.m", "body.u", "length", "checksum"))}


def dissect(tshark: Tshark, folder: Path, packets: Iterable[bad_input.Packet | bytes]) -> list[set[str]]:
    """Return tshark's statements on every packet, by name; both passes must agree, and no exception may occur."""
    capture = folder / "bad.pcapng"
    bad_input.write(capture, packets)
    first, second = (said(tshark, capture, *passes) for passes in ((), ("-2",)))
    assert first == second
    return first


def said(tshark: Tshark, capture: Path, *passes: str) -> list[set[str]]:
    """Run tshark over a capture, with all fields in their trees."""
    names = ["_ws.short", *(f"sis.{name}" for name in EXPERTS)]
    fields = [option for name in ("_ws.expert.message", *names) for option in ("-e", name)]
    output = tshark.output(*passes, "-r", str(capture), "-V", "-T", "fields", *fields)
    packets = []
    for line in output.split("\n")[:-1]:
        messages, *cells = line.split("\t")
        assert not any(word in messages for word in EMERGENCIES), messages
        packets.append({name.partition(".")[2] for name, cell in zip(names, cells, strict=True) if cell})
    return packets


def judgement(data: bytes, experts: set[str]) -> str | None:
    """Return the faults in the statements on a telegram that may have too little or too much useful data."""
    header = telegram.parse(data)
    telegram_is = [judge(header.service, header.reaction, header.body) for judge in (is_short, is_long)]
    has_note = bool({"body.unexpected", "body.note"} & experts)
    if ("body.missing" in experts) == telegram_is[0] and (has_note or not telegram_is[1]):
        return None
    return f"{data.hex(' ')}: short, long: {telegram_is}, said: {sorted(experts)}"


@pytest.mark.parametrize(
    "reaction", [False, pytest.param(True, marks=pytest.mark.thorough)], ids=["commands", "reactions"]
)
def test_useful_data(reaction: bool, tshark: Tshark, tmp_path: Path) -> None:
    """Commands and reactions separately, so that none belongs to another."""
    telegrams = list(bad_input.with_all_bodies(reaction))
    packets = dissect(tshark, tmp_path, telegrams)
    wrong = [judgement(*each) for each in zip(telegrams, packets, strict=True)]
    assert not [words for words in wrong if words]
    assert all(("reaction.unasked" in experts) == reaction for experts in packets)


def test_header_longer_than_the_telegram(tshark: Tshark, tmp_path: Path) -> None:
    whole = [
        data for reaction in (False, True) for data in bad_input.of_every_service(reaction, b"", bytes(range(1, 8)))
    ]
    cut = [bad_input.with_other_length(data, length) for data in whole for length in (0, 6)]
    assert all("length.header" in experts for experts in dissect(tshark, tmp_path, cut))


def test_cut_by_the_capture(tshark: Tshark, tmp_path: Path) -> None:
    """Bytes that the capture has cut are not missing in the telegram; Wireshark itself reports that the packet was
    limited.
    """
    telegrams = bad_input.examples()
    whole = dict(zip(telegrams, dissect(tshark, tmp_path, telegrams), strict=True))
    cut = [(telegram, packet) for telegram in telegrams for packet in bad_input.snapped(telegram)]
    packets = dissect(tshark, tmp_path, [packet for _, packet in cut])
    wrong = [
        f"{packet.data.hex(' ')} of {packet.original}: {sorted(experts)}"
        for (telegram, packet), experts in zip(cut, packets, strict=True)
        if "short" not in experts or experts & MISFITS - whole[telegram]
    ]
    assert not wrong


def test_lengths_that_differ(tshark: Tshark, tmp_path: Path) -> None:
    bad = [data for example in bad_input.examples() for data in bad_input.with_other_repetition(example)]
    assert all("length.differ" in experts for experts in dissect(tshark, tmp_path, bad))


# Lists of service 0x04 with an element longer than the available bytes.
CUT_LISTS = ["FF", "FF 00", "02 10", "03 00 10 01 FF 10 3C", "FF FF", "04 00 10 01", "03 00 10 01 01"]


def test_list_of_services_that_claims_more(tshark: Tshark, tmp_path: Path) -> None:
    bodies = [bytes.fromhex(text) for text in CUT_LISTS]
    bad = [telegram.build(0x04, 16, 3, body) for body in bodies]
    bad += [telegram.build(0x04, 16, 3, b"\x00" + body, reaction=True) for body in bodies]
    assert all("body.missing" in experts for experts in dissect(tshark, tmp_path, bad))


# Control, device, P-0-0072, offset 2, then length and data; the length counts bytes, in ECODRIVE's 0x8E words.
SEGMENT = "3C 01 00 48 80 02 00"
WRONG_LENGTHS = [(0x1E, "04 00 A0 86"), (0x1E, "02 00 A0 86 01 00"), (0x8E, "02 00 A0 86"), (0x8E, "01 00 A0 86 01 00")]
RIGHT_LENGTHS = [(0x1E, "02 00 A0 86"), (0x9E, "04 00 A0 86 01 00"), (0x8E, "01 00 A0 86"), (0x8E, "02 00 A0 86 01 00")]


def test_list_segment_that_claims_more_or_less(tshark: Tshark, tmp_path: Path) -> None:
    wrong, right = (
        [telegram.build(service, 16, 3, bytes.fromhex(SEGMENT + rest)) for service, rest in rows]
        for rows in (WRONG_LENGTHS, RIGHT_LENGTHS)
    )
    found = dissect(tshark, tmp_path, [*wrong, *right])
    assert all(experts & MISFITS for experts in found[: len(wrong)])
    assert found[len(wrong) :] == [set()] * len(right)


def test_sercos_list_that_claims_more(tshark: Tshark, tmp_path: Path) -> None:
    """Its two lengths count as lengths only if they fit; otherwise everything is data, without a fault."""
    claims = [(0xFFFF, 0xFFFF), (5, 4), (3, 4), (4, 3), (4, 0)]  # of 4 bytes
    names = [actual.to_bytes(2, "little") + maximum.to_bytes(2, "little") + b"Name" for actual, maximum in claims]
    names += [b"\x04\x00\x04\x00Nam", b"\x04\x00\x04", b"\x00"]
    packets, expected = [], []
    for control in (0x14, 0x24, 0x3C):  # name, unit, operating data
        for name in names:
            packets.append(telegram.build(0x10, 16, 3, bytes([control, 1, 0, 44, 0])))
            packets.append(telegram.build(0x10, 16, 3, bytes([0, control, 1]) + name, reaction=True))
            expected += ["\t", f"{name.hex()}\t"]
    assert dissect(tshark, tmp_path, packets) == [set()] * len(packets)
    columns = ("-T", "fields", "-e", "sis.data", "-e", "sis.list.actual")
    assert tshark.output("-r", str(tmp_path / "bad.pcapng"), *columns).split("\n")[:-1] == expected


def test_command_answered_twice(tshark: Tshark, tmp_path: Path) -> None:
    command = telegram.build(0x12, 16, 3)
    reaction = telegram.build(0x12, 16, 3, b"\x00\x02", reaction=True)
    packets = [command, reaction, reaction, reaction, command, reaction]
    again = {"reaction.again"}
    assert dissect(tshark, tmp_path, packets) == [set(), set(), again, again, set(), set()]


def test_json(tshark: Tshark, tmp_path: Path) -> None:
    """Every field has a value that JSON can hold."""
    bad = [data for example in bad_input.examples() for data in bad_input.shortened(example)]
    capture = tmp_path / "bad.pcapng"
    bad_input.write(capture, bad)
    packets = json.loads(tshark.output("-r", str(capture), "-T", "json", "--no-duplicate-keys"))
    assert len(packets) == len(bad)
    assert all("sis" in packet["_source"]["layers"] for packet in packets)


def covered(packet: ElementTree.Element) -> tuple[int, set[int]]:
    """Return where the telegram begins, and the bytes that its fields cover."""
    (protocol,) = (part for part in packet if part.get("name") == "sis")
    fields = [part for part in protocol.iter("field") if part.get("name", "").startswith("sis.")]
    spans = [(int(part.get("pos", 0)), int(part.get("size", 0))) for part in fields]
    return int(protocol.get("pos", 0)), {byte for first, size in spans for byte in range(first, first + size)}


def test_no_byte_vanishes(tshark: Tshark, tmp_path: Path) -> None:
    """For every service and any body, all bytes belong to a field, possibly sis.raw."""
    chance = random.Random(5)
    telegrams = [
        telegram.build(service, 16, 3, chance.randbytes(chance.randrange(40)), reaction=reaction)
        for service in range(256)
        for reaction in (False, True)
        for _ in range(2)
    ]
    bad_input.write(tmp_path / "any.pcapng", telegrams)
    packets = ElementTree.fromstring(tshark.output("-r", str(tmp_path / "any.pcapng"), "-T", "pdml"))
    for data, packet in zip(telegrams, packets, strict=True):
        first, fields = covered(packet)
        assert fields >= set(range(first, first + len(data))), data.hex(" ")
