#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes inputs of the fuzzer from captures, and captures from inputs.

python3 corpus.py seeds FOLDER                 one input for each 100 packets of test-captures/
python3 corpus.py capture FILE INPUT...        all inputs as one pcapng, a section each
"""

from __future__ import annotations

import argparse
import struct
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent.parent / "capture"))

from sistap.dissected.captures import reading  # noqa: E402
from sistap.tap.files import pcapng  # noqa: E402
from sistap.tap.records import record  # noqa: E402

# As sequence.h has them.
BY_NAME = ("sertap", "sis", "3964r", "rk512i", "arcnet7f", "synaxpk", "synaxpcp", "synaxpd")
USER0, RTAC, TCP = 8, 9, 10
QUIRK_CUT, QUIRK_SECONDS, QUIRK_SECTION = 0x01, 0x02, 0x10
HEAD = struct.Struct("<IIB")
PACKET = struct.Struct("<BBBqI")

LINK_IP4, LINK_ETHERNET = 228, 1
END_OF_BLOCK = b"\x10\x03"  # of 3964R: DLE ETX, and a check
PER_SEED = 100
START_NS = 1_700_000_000_000_000_000
LAST_NS = 2**63 - 1  # of a file that sistap reads


class Packet(NamedTuple):
    """A packet of an input."""

    road: int
    interface: int
    quirks: int
    step: int
    data: bytes


class Sequence(NamedTuple):
    """An input; two bits of `preferences` choose the value of each."""

    preferences: int
    changed: int
    way: int
    packets: list[Packet]


def pack(sequence: Sequence) -> bytes:
    """Make the bytes that the fuzzer reads."""
    made = HEAD.pack(*sequence[:3])
    for packet in sequence.packets:
        made += PACKET.pack(*packet[:4], len(packet.data)) + packet.data
    return made


def unpack(data: bytes) -> Sequence:
    """Read an input, as far as it is whole."""
    if len(data) < HEAD.size:
        return Sequence(0, 0, 0, [])
    packets = []
    place = HEAD.size
    while place + PACKET.size <= len(data):
        road, interface, quirks, step, length = PACKET.unpack_from(data, place)
        place += PACKET.size
        if place + length > len(data):
            break
        packets.append(Packet(road % (TCP + 1), interface, quirks, step, data[place : place + length]))
        place += length
    preferences, changed, way = HEAD.unpack_from(data)
    return Sequence(preferences, changed, way, packets)


def _named(data: bytes) -> tuple[int, bytes] | None:
    """Return transport and payload of a packet of link type 252 whose single tag is the name."""
    tag, length = struct.unpack_from(">HH", data)
    name = data[4 : 4 + length].rstrip(b"\0").decode()
    return (BY_NAME.index(name), data[8 + length :]) if tag == 12 and name in BY_NAME else None  # noqa: PLR2004


def _transported(data: bytes) -> tuple[int, bytes] | None:
    """Return transport and payload of an IPv4 packet."""
    head = (data[0] & 15) * 4
    whole = struct.unpack_from(">H", data, 2)[0]
    match data[9]:
        case 6:
            return TCP, data[head + (data[head + 12] >> 4) * 4 : whole]
        case 17:
            return BY_NAME.index("synaxpd"), data[head + 8 : whole]
    return None


def road(packet: reading.RawPacket) -> tuple[int, bytes] | None:
    """Return the transport of a packet of a capture, and its payload; None without one."""
    match packet.link_type:
        case pcapng.LINKTYPE_WIRESHARK_UPPER_PDU:
            return _named(packet.data)
        case pcapng.LINKTYPE_USER0:
            return USER0, packet.data
        case pcapng.LINKTYPE_RTAC_SERIAL:
            return RTAC, packet.data
        case link_type if link_type == LINK_IP4:
            return _transported(packet.data)
    return None


def of_capture(path: Path) -> Iterator[Packet]:
    """Yield the packets of a capture that have a transport."""
    last: int | None = None
    for packet in reading.packets(path):
        found = road(packet)
        if found is None or packet.time_ns is None:
            continue
        step = 0 if last is None else packet.time_ns - last
        last = packet.time_ns
        yield Packet(found[0], 0, 0, max(-(2**63), min(step, 2**63 - 1)), found[1])


def bare(packet: Packet) -> Packet:
    """Return the characters of a record of the tap by the transport that is in it, without times and flags."""
    try:
        found = record.unpack(packet.data, 0) if packet.road == BY_NAME.index("sertap") else None
    except (ValueError, IndexError, struct.error):
        found = None
    if found is None or found.type == record.Type.EVENT:
        return packet
    name = "3964r" if found.framing == record.Framing.PROCEDURE_3964R else "sis"
    data = found.data
    if name == "3964r" and data[-3:-1] == END_OF_BLOCK and len(data) % 2:  # half of them without 3964R
        name, data = "rk512i", data[:-3]
    return packet._replace(road=BY_NAME.index(name), data=data)


def cut(packets: Iterable[Packet]) -> list[Packet]:
    """Let the capture have only a part of each third packet."""
    return [one._replace(quirks=QUIRK_CUT * (place % 3 == 2)) for place, one in enumerate(packets)]  # noqa: PLR2004


def seeds(folder: Path) -> int:
    """Write the inputs of the captures, with default preferences and with all others; return how many.

    Each comes once more without the tap, and with packets that are cut: roads that no capture has.
    """
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for path in sorted(HERE.parent.rglob("*.pcapng")):
        packets = list(of_capture(path))
        for first in range(0, len(packets), PER_SEED):
            way = (0, 3, 4, 9)[count % 4]
            changed = 0 if count % 3 else 0x01555555  # the second value of each preference
            chosen = packets[first : first + PER_SEED]
            for ending, made in (("", chosen), ("-bare", cut(map(bare, chosen)))):
                (folder / f"{path.stem}-{first}{ending}").write_bytes(pack(Sequence(0, changed, way, made)))
            count += 1
    return 2 * count


def _framed(packet: Packet, sent: list[int]) -> tuple[int, bytes]:
    """Return link type and bytes of a packet; `sent` counts the bytes of TCP's four directions."""
    match packet.road:
        case road if road < len(BY_NAME):
            return pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, pcapng.upper_pdu(BY_NAME[road], packet.data)
        case road if road == USER0:
            return pcapng.LINKTYPE_USER0, packet.data
        case road if road == RTAC:
            return pcapng.LINKTYPE_RTAC_SERIAL, packet.data
    answer, server = packet.interface & 1, 4200 + (packet.interface >> 1 & 1)
    ports = (server, 50000) if answer else (50000, server)
    data = packet.data[:60000]
    number = sent[packet.interface & 3]
    sent[packet.interface & 3] = (number + len(data)) % 2**32
    addresses = struct.pack(">II", 0x0A000001 + answer, 0x0A000002 - answer)
    ip = struct.pack(">BBHIBBH", 0x45, 0, 40 + len(data), 0, 64, 6, 0) + addresses
    return LINK_IP4, ip + struct.pack(">HHIIHHI", *ports, number, 0, 0x5018, 0xFFFF, 0) + data


def _time(now: int, packet: Packet) -> int:
    """Return the time of a packet, limited to what a file can hold."""
    return (now + (0 if packet.quirks & QUIRK_SECONDS else packet.step)) % LAST_NS


def section(sequence: Sequence) -> bytes:
    """Make a section of a pcapng, with an interface for each link type and number."""
    interfaces: list[tuple[int, int]] = []
    blocks = [pcapng.section_header("corpus.py", "")]
    sent, now = [1000, 2000, 3000, 4000], START_NS
    for packet in sequence.packets:
        link_type, data = _framed(packet, sent)
        if (link_type, packet.interface & 3) not in interfaces:
            interfaces.append((link_type, packet.interface & 3))
            blocks.append(pcapng.interface_description(pcapng.Interface(link_type, str(packet.interface & 3))))
        now = _time(now, packet)
        blocks.append(pcapng.enhanced_packet(interfaces.index((link_type, packet.interface & 3)), now, data))
    return b"".join(blocks)


def capture(inputs: Iterable[Path]) -> bytes:
    """Make one capture of many inputs; the packets of each come in the same order, with the same pauses."""
    return b"".join(section(unpack(path.read_bytes())) for path in inputs)


def main() -> int:
    """Run the command of the first argument."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    makes_seeds = commands.add_parser("seeds", help="make inputs from the captures of test-captures/")
    makes_seeds.add_argument("folder", type=Path, help="where they go")
    makes_capture = commands.add_parser("capture", help="make a capture from inputs, to look at in Wireshark")
    makes_capture.add_argument("file", type=Path, help="a pcapng")
    makes_capture.add_argument("inputs", type=Path, nargs="+", help="of the corpus, or what a fault left")
    arguments = parser.parse_args()
    if arguments.command == "seeds":
        print(f"{seeds(arguments.folder)} seeds")
    else:
        arguments.file.write_bytes(capture(arguments.inputs))
    return 0


if __name__ == "__main__":
    sys.exit(main())
