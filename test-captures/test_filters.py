# SPDX-License-Identifier: GPL-2.0-or-later
"""Display filters that users will type, and their matches."""

from __future__ import annotations

import subprocess
from collections import defaultdict
from pathlib import Path

import pytest
from sharkd import Sharkd

from make import scenarios
from merging import Group, groups
from sistap.dissected.captures.portions import Portion
from sistap.dissected.packets.dissection import Dissection
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.sis.faults import FAULTS

HERE = Path(__file__).parent


# The frame numbers are counted in the text beside the capture.
@pytest.mark.parametrize(
    ("capture", "display_filter", "frames"),
    [
        ("specification", "sis.talker == 3 && sis.control.reaction == 1", [6, 13]),
        ("specification", "sis.station == 8", [3, 4]),
        ("specification", "sis.subaddress == 8", [1, 2, 5, 6]),
        ("specification", "sis.receiver == 255", [11]),
        ("specification", "sis.service == 0x92", [14, 15]),
        ("damaged", "sis.checksum.status == 0", [1]),
        ("damaged", 'sis.checksum.status == "Unverified"', [2, 3]),
        ("damaged", "sis.length.differ", [2]),
        ("damaged", "sis.length.short", [3, 4, 5]),
        ("damaged", "sis.length.long", [6]),
        ("damaged", "sis.start.missing", [7]),
        ("damaged", "sis.length.header", [8]),
        ("damaged", "sis.reaction.unexpected", [9, 11]),
        ("damaged", "sis.receiver.level_broadcast", [13]),
        ("damaged", "sis.sender.service_master", [14]),
        ("damaged", "sis.sender.invalid", [15]),
        ("damaged", "sis.receiver.reserved", [17, 18]),
        ("damaged", "sis.control.reserved.set", [19]),
        ("damaged", "sis.control.warning == 1", [20]),
        ("damaged", "sis.control.error == 1", [21]),
        ("damaged", "sis.number == 5", [22, 23]),
        ("damaged", "sis.service.reserved", [24]),
        ("damaged", "sis.status.telegram_error", [26]),
        ("damaged", "sis.status.execution_error", [27]),
        ("records", "sertap.error.character", [4]),
        ("records", "sertap.error.unlocated", [5]),
        ("records", "sertap.error.break", [6]),
        ("records", "sertap.error.lost", [7]),
        ("records", "sertap.same_read", [8]),
        ("records", "sertap.interval.max > 0.004", [3]),
        ("records", "sertap.interval == 0.0042", [3]),
        ("records", "sertap.interval.saturated", [25]),
        ("records", "sertap.flags == 0x40", [25]),
        ("records", "sertap.character == 0x9d", [8, 10]),
        ("records", "sertap.event == 4", [16]),
        ("records", r'sertap.text contains "ON\r\n"', [2]),
        ("records", "sertap.uncertainty > 1", []),
        ("records", "frame.packet_flags_crc_error == 1", [5]),
        ("records", "frame.packet_flags_symbol_error == 1", [4, 6]),
        ("records", "sertap.version.unknown", [17]),
        ("records", "sertap.header_length.short", [18]),
        ("records", "sertap.truncated", [19, 20, 21, 22, 28]),
        ("records", "sertap.count.wrong", [23]),
        ("tcp", "sis.service == 0x03", [1, 3, 4]),
        ("tcp", "sis.service == 0x92", [5]),
        ("tcp-resync", "sis.service == 0x92", [4]),
        ("tcp-resync", "sis.service == 0x9d", [5, 6, 7, 9]),
        ("tcp-resync", "sis.service == 3 && frame.number > 6", [7, 8]),
        ("tcp-foreign", "sis", []),
    ],
)
def test_filter(capture: str, display_filter: str, frames: list[int], sharkd: Sharkd) -> None:
    """In a list without a tree, a dissector may leave out only what is not needed."""
    assert sharkd.frames(HERE / f"{capture}.pcapng", display_filter) == frames


OPTIONS = {
    "ecodrive03": ["-o", "sis.edition:ECODRIVE03"],
    "user0": ["-o", r'uat:user_dlts:"User 0 (DLT=147)","sis","0","","0",""'],
    "rtac": ["-d", "rtacser.data,sis"],
}


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("capture", "display_filter", "frames"),
    [
        ("ecodrive03", "sis.control.status.error", [9]),
        ("ecodrive03", "sis.reaction.unexpected", [3]),
        ("ecodrive03", "sis.sender.service_master || sis.receiver.reserved", []),
        (
            "ecodrive03",
            "sis.control.status > 0 && sis.control.reaction == 1",
            [6, 7, 8, 9, 10],
        ),
        ("user0", "sis", [1, 2]),
        ("rtac", "sis.control.reaction == 1", [2]),
    ],
)
def test_filter_with_options(capture: str, display_filter: str, frames: list[int], tshark: Tshark) -> None:
    found = tshark.output("-r", str(HERE / f"{capture}.pcapng"), *OPTIONS[capture], "-Y", display_filter)
    assert [int(line.split()[0]) for line in found.splitlines()] == frames


def test_a_fault_is_one_item(tshark: Tshark, tmp_path: Path) -> None:
    """With one service in the packet. Of a status and its error code, only the code is an item."""
    capture = tmp_path / "merged.pcapng"
    PLAIN.write(capture)
    asked = ("-Y", "sis && _ws.expert && count(sis.service) <= 1", "-T", "fields", "-E", "aggregator=|")
    found = tshark.output("-r", str(capture), *asked, "-e", "frame.number", "-e", "_ws.expert.message")
    twice = []
    for number, texts in (line.split("\t") for line in found.splitlines()):
        faults = ["status" if text.startswith(("Status: ", "error 0x")) else text for text in texts.split("|")]
        if len(set(faults)) < len(faults):
            twice.append((PLAIN.whose(int(number)), texts))
    assert "error 0x" in found
    assert twice == []


def test_nothing_before_the_first_telegram_becomes_sis(tshark: Tshark) -> None:
    """In the second pass TCP knows that the stream is SIS, but bytes before it are not."""
    path = str(HERE / "tcp-resync.pcapng")
    for passes in ([], ["-2"]):
        found = tshark.output("-r", path, *passes, "-Y", "frame.number == 1 && sis")
        assert found == ""


def test_damaged_telegrams_make_no_stations(tshark: Tshark) -> None:
    """2 and 8 occur only in telegrams of damaged.txt with a wrong checksum, or as subaddresses."""
    table = tshark.output("-r", str(HERE / "damaged.pcapng"), "-q", "-z", "endpoints,sis")
    stations = {line.split()[0] for line in table.splitlines() if line[:1].isdigit()}
    assert stations == {"3", "16", "127", "128", "144", "168", "200", "254", "255"}


def test_cut_by_snaplen_the_telegram_is_still_there(tshark: Tshark, tmp_path: Path) -> None:
    """With 60 bytes of a packet, telegram 2-10 is whole, but its times are missing."""
    cut = tmp_path / "cut.pcapng"
    subprocess.run(["editcap", "-s", "60", str(HERE / "specification.pcapng"), str(cut)], check=True)
    found = tshark.output("-r", str(cut), "-Y", "sis.checksum.status == 1", "-T", "fields", "-e", "frame.number")
    assert found.split()[0] == "1"


def test_tcp_heuristic_can_be_switched_off_and_decode_as_still_works(
    tshark: Tshark,
) -> None:
    path = str(HERE / "tcp.pcapng")
    off = ("-r", path, "-o", "sis.tcp_heuristic:FALSE")
    assert "SIS" not in tshark.output(*off)
    assert len(tshark.output(*off, "-d", "tcp.port==4200,sis", "-Y", "sis").splitlines()) == 6


def test_framing_can_be_decoded_as(tshark: Tshark) -> None:
    """Nobody uses framing 42: Decode As assigns it to SIS."""
    path = str(HERE / "records.pcapng")
    decoded = tshark.output("-r", path, "-d", "sertap.framing==42,sis", "-Y", "frame.number==26")
    assert "SIS" in decoded


PLAIN, _, TCP = groups()
EACH = [pytest.param(Group(path.stem, (path,)), id=path.stem, marks=pytest.mark.thorough) for path in scenarios()]


@pytest.mark.parametrize("group", [pytest.param(PLAIN, id="plain"), pytest.param(TCP, id="tcp"), *EACH])
def test_the_report_counts_what_the_filters_beside_it_find(
    group: Group, tshark: Tshark, sharkd: Sharkd, tmp_path: Path
) -> None:
    group.write(tmp_path / "capture.pcapng")
    counted = defaultdict(list)
    with Dissection(tshark, [Portion(tmp_path / "capture.pcapng")]) as dissection:
        for packet in dissection.packets():
            for fault in packet.faults:
                counted[fault.name].append(packet.number)
    found = {fault.name: sharkd.frames(tmp_path / "capture.pcapng", fault.filter) for fault in FAULTS}
    assert {fault.name: counted[fault.name] for fault in FAULTS} == found
