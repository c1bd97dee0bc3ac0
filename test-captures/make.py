#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the captures of this folder and of its course from the text files beside them, and their expected dissections.

    python3 make.py                 write every NAME.pcapng from its NAME.txt
    python3 make.py --expected      also write NAME.expected from what tshark says now: read the difference, line by
                                    line, against the specification before you keep it

What a NAME.txt may hold is said in DEVELOP.md.
"""

from __future__ import annotations

import argparse
import ast
import functools
import operator
import re
import shlex
import struct
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "capture"))

from sistap.dissected.wireshark.tshark import Tshark  # noqa: E402
from sistap.tap.files import pcapng  # noqa: E402
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings  # noqa: E402
from sistap.tap.records import record  # noqa: E402
from sistap.tap.sis import telegram  # noqa: E402

START_NS = 1_700_000_000_000_000_000
LONGEST_NS = 0xFFFFFFFF  # that a record can hold
SILENCE_NS = 25_000_000  # before the next packet, unless `silence` says otherwise
CLIENT_PORT = 50000  # of TCP and UDP

LINKTYPE_RAW_IPV4 = 228
LINKTYPE_ARCNET_BSD = 7
LINKTYPE_ARCNET_LINUX = 129
LINK_TYPES = {
    "sertap": pcapng.LINKTYPE_WIRESHARK_UPPER_PDU,
    "sis": pcapng.LINKTYPE_WIRESHARK_UPPER_PDU,
    "sisascii": pcapng.LINKTYPE_WIRESHARK_UPPER_PDU,
    "arcnet7f": pcapng.LINKTYPE_WIRESHARK_UPPER_PDU,
    "synaxpk": pcapng.LINKTYPE_WIRESHARK_UPPER_PDU,
    "arcnet": LINKTYPE_ARCNET_LINUX,
    "arcnet-bsd": LINKTYPE_ARCNET_BSD,
    "user0": pcapng.LINKTYPE_USER0,
    "rtac": pcapng.LINKTYPE_RTAC_SERIAL,
    "tcp": LINKTYPE_RAW_IPV4,
    "synaxpcp": pcapng.LINKTYPE_WIRESHARK_UPPER_PDU,
    "udp": LINKTYPE_RAW_IPV4,
}

# Objects of SYNAX200 through PCP: its services, and the sizes of those with telegrams.
SERVICES = {"read-request": 0x0081, "write-request": 0x0082, "read-answer": 0x0181, "write-answer": 0x0182}
OBJECT_SIZES = {0x5E70: 16, 0x5E71: 32, 0x5E72: 64, 0x5E73: 128}

# Texts of Wireshark that change with its version: its own layers, and a segment without a telegram.
_OF_ANY_VERSION = (
    (re.compile(r"^(Frame \d+: .*|Raw packet data)\n", re.MULTILINE), ""),
    (re.compile(r"^( *\d+ .* TCP \d+) .*$", re.MULTILINE), r"\1"),
    # If a field has many bytes, one version shows more than the other.
    (re.compile(r"^( *[^:\n]+?)(?: \[…\])?: ([0-9a-f]{72})[0-9a-f]*…?$", re.MULTILINE), r"\1: \2…"),
)


@dataclass
class Item:
    """A packet to make: the contents of a record, or a raw payload."""

    time_ns: int
    kind: record.Type = record.Type.FRAME
    data: bytes = b""
    settings: LineSettings = field(default_factory=LineSettings)
    uncertainty_ns: int = 310_000
    line: int = 0
    link: str = "sertap"
    section: int = 0
    interface: int = 0  # of the section
    clock_ns: int = 0  # so far ahead is the clock of the packets
    event: int = 0
    framing: int = 0  # of a frame: 0 SIS, 1 3964R
    flags: dict[int, int] = field(default_factory=dict)  # by number of the character, from 1
    pauses_ns: dict[int, int] = field(default_factory=dict)
    raw: bytes | None = None  # for `record` and `segment`
    expected: dict[str, str] = field(default_factory=dict)  # by field, without its "sis."; from `fields`

    def record(self, silence_ns: int | None) -> bytes:
        """Return the bytes of the record, or the raw bytes."""
        if self.raw is not None:
            return self.raw
        intervals = self._intervals(silence_ns or 0)
        flags = bytearray(len(self.data))
        for index, flag in self.flags.items():
            flags[index - 1] = flag
        if silence_ns is None:
            flags[:1] = bytes([Flag.INTERVAL_UNKNOWN]) if flags else b""
        if intervals and intervals[0] > LONGEST_NS:
            intervals[0], flags[0] = LONGEST_NS, flags[0] | Flag.INTERVAL_SATURATED
        made = record.Record(
            self.time_ns,
            self.kind,
            self.line,
            self.settings,
            self.data,
            intervals,
            bytes(flags),
            self.uncertainty_ns,
        )
        packed = made.pack()
        packed = packed[:11] + bytes([self.framing]) + packed[12:]
        return packed[:18] + struct.pack(">H", self.event) + packed[20:] if self.event else packed

    def _intervals(self, silence_ns: int) -> list[int]:
        intervals = [self.settings.character_ns] * len(self.data)
        for index, flag in self.flags.items():
            if flag & Flag.SAME_READ:
                intervals[index - 1] = 0
        for index, pause_ns in self.pauses_ns.items():
            intervals[index - 1] = pause_ns
        return [silence_ns, *intervals[1:]] if intervals else []

    @property
    def end_ns(self) -> int:
        """Return the time of its last character."""
        return self.time_ns + sum(self._intervals(0))


class Says(Protocol):
    """A tshark, of this system or of another."""

    def output(self, *arguments: str) -> str:
        """Run it, and return what it says."""


class Scenario:
    """A NAME.txt: its directives and its packets."""

    def __init__(self, path: Path) -> None:
        """Read the file. SystemExit names the line that is wrong."""
        self.path = path
        self.link = "sertap"
        self.show = "sertap,sis"
        self.options: list[str] = []
        self.items: list[Item] = []
        self._defaults: dict[str, object] = {}
        self._stations = "16>3"
        self._silence_ns = SILENCE_NS
        self._sections = [[path.stem]]  # names of the interfaces of each
        self._port = 4200
        self._sequence: dict[tuple[int, str], int] = {}
        for number, line in enumerate(path.read_text().splitlines(), 1):
            words = line.split("#")[0].rstrip() if not line.startswith(("other", "event", "text")) else line
            try:
                self._read(words)
            except (ValueError, KeyError, IndexError, SyntaxError) as error:
                sys.exit(f"{path.name}:{number}: {line.strip()}: {error!r}")

    def _read(self, line: str) -> None:
        word, _, rest = line.partition(" ")
        if not word or word.startswith("#"):
            return
        handler: Callable[[str], None] = getattr(self, f"_do_{word.removeprefix('@')}")
        handler(rest.strip())

    def _do_link(self, rest: str) -> None:
        LINK_TYPES[rest]  # KeyError: no such link
        self.link = self.link if self.items else rest
        self._defaults["link"] = rest

    def _do_show(self, rest: str) -> None:
        self.show = rest

    def _do_option(self, rest: str) -> None:
        self.options += shlex.split(rest)

    def _do_line(self, rest: str) -> None:
        baud, text = rest.split()
        self._defaults["settings"] = LineSettings.parse(int(baud), text)

    def _do_uncertainty(self, rest: str) -> None:
        self._defaults["uncertainty_ns"] = UNCERTAINTY_UNKNOWN if rest == "unknown" else round(float(rest) * 1e6)

    def _do_direction(self, rest: str) -> None:
        self._defaults["line"] = int(rest)

    def _do_section(self, _rest: str) -> None:
        self._sections.append([self.path.stem])
        self._defaults |= {"section": len(self._sections) - 1, "interface": 0}

    def _do_interface(self, rest: str) -> None:
        interfaces = self._sections[-1]
        if rest not in interfaces:
            interfaces.append(rest)
        self._defaults["interface"] = interfaces.index(rest)

    def _do_framing(self, rest: str) -> None:
        self._defaults["framing"] = int(rest)

    def _do_clock(self, rest: str) -> None:
        self._defaults["clock_ns"] = round(float(rest) * 1e6)

    def _do_silence(self, rest: str) -> None:
        self._silence_ns = round(float(rest) * 1e6)

    def _add(self, **values: object) -> None:
        start_ns = self.items[-1].end_ns + self._silence_ns if self.items else START_NS
        self.items.append(Item(start_ns, **{**self._defaults, **values}))  # type: ignore[arg-type]

    def _do_telegram(self, rest: str) -> None:
        self._add(data=bytes.fromhex(rest))

    def _do_text(self, rest: str) -> None:
        self._add(data=ast.literal_eval(rest).encode("latin-1"))

    def _do_stations(self, rest: str) -> None:
        sender, receiver = rest.split()
        self._stations = f"{sender}>{receiver}"

    def _built(self, rest: str, *, reaction: bool) -> bytes:
        return built_telegram(rest if ">" in rest.split()[0] else f"{self._stations} {rest}", reaction=reaction)

    def _do_block(self, rest: str) -> None:
        self._add(data=block_3964r(body_bytes(rest)))

    def _do_command(self, rest: str) -> None:
        self._add(data=self._built(rest, reaction=False))

    def _do_reaction(self, rest: str) -> None:
        self._add(data=self._built(rest, reaction=True))

    def _do_before(self, rest: str) -> None:
        self._read(rest)
        self.items[-1].kind = record.Type.BEFORE

    def _do_byte(self, rest: str) -> None:
        index, value = rest.split()
        data = bytearray(self.items[-1].data)
        data[int(index) - 1] = int(value, 16)
        self.items[-1].data = bytes(data)

    def _do_fields(self, rest: str) -> None:
        for word in shlex.split(rest):
            name, _, value = word.partition("=")
            self.items[-1].expected[name] = value

    def _do_other(self, rest: str) -> None:
        text = rest.partition("#")[0].strip()
        data = ast.literal_eval("b" + text) if text.startswith('"') else bytes.fromhex(text)
        self._add(kind=record.Type.OTHER, data=data)

    def _do_event(self, rest: str) -> None:
        code, text = rest.split(None, 1)
        self._add(
            kind=record.Type.EVENT,
            data=text.replace("\\n", "\n").encode(),
            event=int(code),
            uncertainty_ns=UNCERTAINTY_UNKNOWN,
        )

    def _do_record(self, rest: str) -> None:
        self._add(raw=bytes.fromhex(rest))

    def _do_flag(self, rest: str) -> None:
        index, flag = rest.split()
        self.items[-1].flags[int(index)] = int(flag, 16)

    def _do_reads(self, rest: str) -> None:
        item, first = self.items[-1], 1
        for count in map(int, rest.split()):
            item.flags |= dict.fromkeys(range(first + 1, first + count), int(Flag.SAME_READ))
            first += count
        if first != len(item.data) + 1:
            raise ValueError(f"the packet has {len(item.data)} characters")

    def _do_pause(self, rest: str) -> None:
        index, ms = rest.split()
        self.items[-1].pauses_ns[int(index)] = round(float(ms) * 1e6)

    def _do_port(self, rest: str) -> None:
        self._port = int(rest)

    def _do_segment(self, rest: str) -> None:
        direction, data = rest.split(None, 1)
        payload = body_bytes(data)
        there, back = self._sequence.get((self._port, direction), 1), "<" if direction == ">" else ">"
        acknowledged = self._sequence.get((self._port, back), 1)
        self._add(raw=tcp_segment(self._port, direction == ">", there, acknowledged, payload))
        self._sequence[(self._port, direction)] = there + len(payload)

    def _do_lost(self, rest: str) -> None:
        direction, data = rest.split(None, 1)
        self._sequence[(self._port, direction)] += len(body_bytes(data))

    def _do_datagram(self, rest: str) -> None:
        direction, _, data = rest.partition(" ")
        self._add(raw=udp_datagram(self._port, direction == ">", bytes.fromhex(data)))

    def _do_object(self, rest: str) -> None:
        index, operation, *content = rest.split(None, 2)
        self._add(data=self._message(int(index, 16), operation, "".join(content)))

    def _message(self, index: int, operation: str, content: str) -> bytes:
        """Return a message of PCP, of invoke id 0 and reference 2, with an object; a telegram is padded to its size."""
        kind, _, words = content.partition(" ")
        if kind in {"command", "reaction"}:
            held = self._built(words.strip(), reaction=kind == "reaction").ljust(OBJECT_SIZES[index], b"\0")
        else:
            held = bytes.fromhex(content)
        body = struct.pack(">HB", index, 0) if operation.endswith("request") else bytes(3)
        if operation in {"write-request", "read-answer"}:
            body += bytes([len(held)]) + held
        words = (2 + len(body) + 1) // 2
        return struct.pack(">HHH", SERVICES[operation], words, 2) + body.ljust(2 * words - 2, b"\0")

    def _payloads(self) -> list[bytes]:
        """Return the payloads of the packets, without the link type's own header."""
        last: dict[tuple[int, int, int], int] = {}
        payloads = []
        for item in self.items:
            if item.link != "sertap":
                payloads.append(item.raw if item.raw is not None else item.data)
                continue
            has_times = item.kind != record.Type.EVENT and item.raw is None
            line = item.section, item.interface, item.line
            silence = item.time_ns - last[line] if line in last else None
            payloads.append(item.record(silence if has_times else None))
            if has_times:
                last[line] = item.end_ns
        return payloads

    def _packet_flags(self, item: Item) -> int:
        errors = Flag.CHARACTER_ERROR | Flag.BREAK
        flags = {0: 0, 1: pcapng.PacketFlags.INBOUND, 2: pcapng.PacketFlags.OUTBOUND}[item.line]
        if any(flag & errors for flag in item.flags.values()):
            flags |= pcapng.PacketFlags.SYMBOL_ERROR
        if item.link == "sertap" and item.kind == record.Type.FRAME and item.data:
            flags |= 0 if telegram.checksum_good(item.data) else pcapng.PacketFlags.CRC_ERROR
        return flags

    def capture(self) -> bytes:
        """Return the whole capture file."""
        blocks: list[list[bytes]] = []
        for names in self._sections:
            interfaces = [pcapng.Interface(LINK_TYPES[self.link], name) for name in names]
            head = pcapng.section_header("test-captures/make.py", "")
            blocks.append([head, *map(pcapng.interface_description, interfaces)])
        for item, payload in zip(self.items, self._payloads(), strict=True):
            data = LINK_HEADERS[item.link](payload, item.time_ns)
            time_ns = item.time_ns + item.clock_ns
            packet = pcapng.enhanced_packet(item.interface, time_ns, data, self._packet_flags(item))
            blocks[item.section].append(packet)
        return b"".join(block for section in blocks for block in section)

    def dissection(self, tshark: Says, capture: Path) -> str:
        """Return tshark's output, 4.0 to 4.6: a line for each packet, followed by its tree if requested."""
        layers = ["-P", "-V", "-O", self.show] if self.show else []
        text = tshark.output("-r", str(capture), "-t", "r", *self.options, *layers)
        for pattern, replacement in _OF_ANY_VERSION:
            text = pattern.sub(replacement, text)
        return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"


def body_bytes(text: str) -> bytes:
    """Read hexadecimal digits, and characters in double quotes."""
    return bytes.fromhex(re.sub('"([^"]*)"', lambda quoted: quoted[1].encode("ascii").hex(), text))


def block_3964r(data: bytes) -> bytes:
    """Make a block of 3964R from its data: DLEs doubled, DLE ETX, and the XOR of all that."""
    block = data.replace(b"\x10", b"\x10\x10") + b"\x10\x03"
    return block + bytes([functools.reduce(operator.xor, block)])


def built_telegram(text: str, *, reaction: bool) -> bytes:
    """Make a telegram from `16>3/2/8:5 10 BODY`: stations and telegram number, service, useful data."""
    addresses, service, *body = text.split(None, 2)
    stations, _, number = addresses.partition(":")
    sender, _, route = stations.partition(">")
    receiver, *subaddresses = map(int, route.split("/"))
    return telegram.build(
        int(service, 16),
        int(sender),
        receiver,
        body_bytes("".join(body)),
        reaction=reaction,
        subaddresses=bytes(subaddresses),
        number=int(number) if number else None,
    )


def rtac_header(payload: bytes, time_ns: int) -> bytes:
    """Make RTAC's header (data received) and payload."""
    seconds, rest = divmod(time_ns, 1_000_000_000)
    return struct.pack(">IIBBH", seconds, rest // 1000, 2, 0, 0) + payload


def tcp_segment(port: int, from_client: bool, sequence: int, acknowledged: int, payload: bytes) -> bytes:
    """Make an IPv4 packet with one TCP segment; checksums are 0, which Wireshark does not judge."""
    ports = (CLIENT_PORT, port) if from_client else (port, CLIENT_PORT)
    addresses = (b"\x0a\x00\x00\x01", b"\x0a\x00\x00\x02")
    source, destination = addresses if from_client else addresses[::-1]
    tcp = struct.pack(">HHIIBBHHH", *ports, sequence, acknowledged, 0x50, 0x18, 8192, 0, 0) + payload
    return struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(tcp), 0, 0, 64, 6, 0, source, destination) + tcp


def udp_datagram(port: int, from_client: bool, payload: bytes) -> bytes:
    """Make an IPv4 packet with one UDP datagram; checksums are 0, which Wireshark does not judge."""
    ports = (CLIENT_PORT, port) if from_client else (port, CLIENT_PORT)
    addresses = (b"\x0a\x00\x00\x01", b"\x0a\x00\x00\x02")
    source, destination = addresses if from_client else addresses[::-1]
    udp = struct.pack(">HHHH", *ports, 8 + len(payload), 0) + payload
    return struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, source, destination) + udp


LINK_HEADERS: dict[str, Callable[[bytes, int], bytes]] = {
    "sertap": lambda payload, _: pcapng.upper_pdu("sertap", payload),
    "sis": lambda payload, _: pcapng.upper_pdu("sis", payload),
    "sisascii": lambda payload, _: pcapng.upper_pdu("sisascii", payload),
    "arcnet7f": lambda payload, _: pcapng.upper_pdu("arcnet7f", payload),
    "synaxpk": lambda payload, _: pcapng.upper_pdu("synaxpk", payload),
    "arcnet": lambda payload, _: payload,
    "arcnet-bsd": lambda payload, _: payload,
    "user0": lambda payload, _: payload,
    "rtac": rtac_header,
    "tcp": lambda payload, _: payload,
    "synaxpcp": lambda payload, _: pcapng.upper_pdu("synaxpcp", payload),
    "udp": lambda payload, _: payload,
}


def scenarios() -> list[Path]:
    """Return all NAME.txt of this folder and of the course, in order."""
    return [*sorted(HERE.glob("*.txt")), *sorted((HERE / "course").glob("*.txt"))]


def main() -> None:
    """Make everything."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--expected",
        action="store_true",
        help="also write NAME.expected (then check it by hand)",
    )
    arguments = parser.parse_args()
    for path in scenarios():
        path.with_suffix(".pcapng").write_bytes(Scenario(path).capture())
    if arguments.expected:
        write_expected()


def write_expected() -> None:
    """Write what tshark says, if it has the plugin."""
    with Tshark() as tshark:
        if "sis.so" not in tshark.output("-G", "plugins"):
            sys.exit(
                "make.py: tshark does not load sis.so; install the plugin, or name its folder in WIRESHARK_PLUGIN_DIR"
            )
        for path in scenarios():
            path.with_suffix(".expected").write_text(Scenario(path).dissection(tshark, path.with_suffix(".pcapng")))


if __name__ == "__main__":
    main()
