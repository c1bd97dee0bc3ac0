# SPDX-License-Identifier: GPL-2.0-or-later
"""Useful data: every telegram with a line `fields` below it has exactly these fields, of those named here."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from make import Item, Scenario, scenarios
from sistap.dissected.wireshark.tshark import Tshark

# A `fields` line names all of these that the telegram has ...
FIELDS = (
    "status device subservice error raw data text version firmware type_key init.baud_mask canceled_service "
    "flash.address flash.length flash.target flash.device_type flash.crc32 init.time init.test_time element_length "
    "element parameter list_offset list_length data_status phase value element.name element.unit attribute "
    "list.actual list.maximum sequence.count"
).split()
# ... and of these expert items; with their number, where there are several.
EXPERTS = (
    "body.missing body.unexpected body.note list.recursion reaction.unasked reaction.again sequence.ended "
    "sequence.piece_missing"
).split()
# It may name these.
DETAILS = (
    "transmission parameter_control parameter.name parameter.type parameter.product_specific parameter.set "
    "parameter.number data_status.set data_status.enabled data_status.not_executed data_status.impossible "
    "data_status.invalid attribute.factor attribute.length attribute.command attribute.format attribute.decimals "
    "attribute.protected_2 attribute.protected_3 attribute.protected_4 sequence.length talker listener"
).split()

BOOLEANS = {"False": "0", "True": "1"}  # how Wireshark 4.2 and later write them

SCENARIOS = {path: Scenario(path) for path in scenarios()}


def shown(tshark: Tshark, path: Path, *passes: str) -> list[dict[str, str]]:
    """Return every packet's fields as tshark prints them; for an expert item how often it is there."""
    names = FIELDS + EXPERTS + DETAILS
    options = [option for name in names for option in ("-e", f"sis.{name}")]
    command = ("-r", str(path.with_suffix(".pcapng")), *SCENARIOS[path].options, "-T", "fields", *options)
    packets = []
    for line in tshark.output(*passes, *command).splitlines():
        cells = [BOOLEANS.get(cell, cell) for cell in line.split("\t")]
        packet = {name: cell for name, cell in zip(names, cells, strict=True) if cell}
        for name in packet.keys() & set(EXPERTS):
            packet[name] = str(packet[name].count(",") + 1)
        packets.append(packet)
    return packets


def compared(packet: dict[str, str], item: Item) -> dict[str, str]:
    """Leave out the details that the item does not ask for."""
    return {name: value for name, value in packet.items() if name not in DETAILS or name in item.expected}


def expected(item: Item) -> dict[str, str]:
    """Return the item's `fields` line; an expert item is there once unless it gives a number."""
    return {name: value or "1" if name in EXPERTS else value for name, value in item.expected.items()}


@pytest.mark.parametrize("passes", [(), ("-2",)], ids=["one pass", "two passes"])
@pytest.mark.parametrize("name", ["bodies", "bodies-preferences", "documents", "outside"])
def test_fields(name: str, passes: tuple[str, ...], tshark: Tshark) -> None:
    path = Path(__file__).parent / f"{name}.txt"
    packets, items = shown(tshark, path, *passes), SCENARIOS[path].items
    assert len(packets) == len(items)
    wrong = [
        f"{number}: {item.data.hex(' ')}\n  expected {expected(item)}\n  shown    {compared(packet, item)}"
        for number, (packet, item) in enumerate(zip(packets, items, strict=True), 1)
        if compared(packet, item) != expected(item)
    ]
    assert not wrong, "\n".join(wrong)


def test_unit_of_a_list_segment(tshark: Tshark) -> None:
    """Offset and length count words in ECODRIVE's services, bytes in all others (chapter 8.1)."""
    capture = str(Path(__file__).parent / "bodies.pcapng")
    columns = ("-T", "fields", "-e", "sis.service", "-e", "_ws.col.Info")
    lines = tshark.output("-r", capture, "-Y", "sis.list_length", *columns).splitlines()
    words = {line.split("\t")[0] for line in lines if re.search(" words? at offset ", line)}
    octets = {line.split("\t")[0] for line in lines if re.search(" bytes? at offset ", line)}
    assert (words, octets) == ({"0x81", "0x8e"}, {"0x11", "0x1e", "0x91", "0x9e"})


ERASED = "(complete erase without loader and kernel)"
# What documents.txt says in its tree only, by packet.
IN_THE_TREE = {
    1: ["Telegram control: 0x00 (command, SEND)"],  # fig. 2-3; 0x1E writes, and so does 0x03
    2: ["Telegram control: 0x10 (reaction)"],
    10: ["Telegram control: 0x00 (command, FETCH)"],  # 0x10 reads, and so does 0x00
    65: ["Telegram control: 0x00 (command)\n"],  # a list may do both
    71: ["Telegram control: 0x00 (command, FETCH)"],
    73: ["Telegram control: 0x00 (command, SEND)"],
    80: ["Transmission channel busy (0x8001): repeat the command until the channel is free"],  # fig. 2-19
    82: ["Fault in the transmission channel (0x8002): repeat the command to see whether the fault lasts"],
    84: ["had priority (0x800b): repeat the command until it is executed without being cancelled"],
    86: ["still active (0x800c): repeat the command until the active request has ended"],
    88: ["(0x8001): not done within the time-out, which C-0-0124 sets; nothing was transferred"],  # fig. 8-48
    89: ["Telegram control: 0x00 (command)\n", f"Memory address: 0xffffffff {ERASED}", f"4294967295 bytes {ERASED}"],
    91: ["Memory address: 0xffffffff\n", "Length: 4096 bytes\n"],
    93: ["Telegram control: 0x00 (command, group message, no reaction)"],
    94: ["Telegram control: 0x00 (command, broadcast message, no reaction)"],
    95: ["Telegram control: 0x01 (command, broadcast message, no reaction)"],
}


def test_what_the_tree_says(tshark: Tshark) -> None:
    capture = str(Path(__file__).parent / "documents.pcapng")
    trees = re.split(r"^Frame \d+:", tshark.output("-r", capture, "-V", "-O", "sis"), flags=re.MULTILINE)
    wanted = [(number, text) for number, texts in IN_THE_TREE.items() for text in texts]
    assert [(number, text) for number, text in wanted if text not in trees[number]] == []
