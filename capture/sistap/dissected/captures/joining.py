# SPDX-License-Identifier: GPL-2.0-or-later
"""Several captures as one: what can be read together, in the order of their time, and joined into one file."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import BinaryIO, NamedTuple

from sistap.dissected.captures import reading
from sistap.dissected.captures.twice import check_once
from sistap.tap.common.packed import is_text, making, no_capture, unpack, untold
from sistap.tap.files import pcapng
from sistap.tap.records.record import KEPT, Event
from sistap.tap.terminal.exits import NotCaptured, Refusal

_USB = {186, 189, 220, 249, 266}  # link types (tcpdump.org/linktypes.html): FreeBSD, Linux, Windows, macOS


def check_captures(named: Iterable[Path], say: Callable[[str], None], output: str | None = None) -> list[Path]:
    """Return all captures, those of a folder one by one. Say what is left out of a folder because it cannot be read.

    Refusal unless all others can be read again, none is the output, and each is there once. A packed one among several
    is refused: nobody can tell whether it is a copy.
    """
    captures = [capture for path in named for capture in (_readable(_inside(path), say) if path.is_dir() else [path])]
    for capture in captures:
        if capture.exists() and not capture.is_file():
            raise Refusal(f"{capture} is not a file: it is read twice, so save the capture first")
        try:
            if len(captures) > 1 and untold(capture):
                raise Refusal(unpack(capture))
            _check_contents(capture, say)
        except OSError as error:
            raise Refusal(f"cannot read {capture}: {error.strerror}; name a capture file") from None
        if output and Path(output).exists() and capture.samefile(output):
            raise Refusal(f"{output} is the capture itself; name another file with -o")
    check_once(captures)
    return captures


def _check_contents(capture: Path, say: Callable[[str], None]) -> None:
    """Say that a capture is empty, or may be cut off. Refusal if it is a text, or of USB alone; OSError."""
    if is_text(capture):
        raise Refusal(no_capture(capture))
    if warning := untold(capture):
        say(warning)
    link_types, has_packets = reading.beginning(capture)
    if not has_packets:
        say(f"{capture} has no packets")
    elif link_types and link_types <= _USB:
        raise Refusal(f"{capture} has packets of USB alone. First make one of the bus: {making('import', capture)}")


def _inside(folder: Path) -> list[Path]:
    """Return the captures in a folder. What a recorder has kept is in its ring, too."""
    names = {path.name for path in folder.glob("*.pcapng")}
    # Compressed, and then not removed: the recorder was killed between.
    names |= {path.name for path in folder.glob("*.pcapng.gz") if path.stem not in names}
    rings = {name for name in names if name.startswith("ring_")}
    found = [folder / name for name in sorted(rings or names)]
    if not found:
        raise Refusal(f"{folder} has no captures: name one, or another folder")
    return found


def _readable(captures: Sequence[Path], say: Callable[[str], None]) -> Sequence[Path]:
    """Leave out what nobody can read together with the others. A single one, or if none can be read: all."""
    if len(captures) == 1:
        return captures
    reasons = [_unreadable(capture) for capture in captures]
    if all(reasons):
        return captures
    for reason in filter(None, reasons):
        say(f"left out: {reason}")
    return [capture for capture, reason in zip(captures, reasons, strict=True) if not reason]


def _unreadable(capture: Path) -> str:
    """Return why a capture cannot be read with others; empty if it can."""
    if not capture.is_file():
        return f"{capture} is not a file"
    try:
        if next(reading.packets(capture), None) is None:
            return f"{capture} has no packets"
        return "" if _is_joinable(capture) else unjoinable(capture)
    except OSError as error:
        return f"cannot read {capture}: {error.strerror}"
    except NotCaptured as error:
        return str(error)


def unjoinable(capture: Path) -> str:
    """Say that it cannot be joined."""
    return f"{capture} cannot be read with others: open it in Wireshark and save it as pcapng"


def in_order(captures: Iterable[Path]) -> list[Path]:
    """Sort captures by their first packets. If any has no such time, the order stays."""
    given = [*captures]
    begins = {capture: begin_ns(capture) for capture in given}
    return given if None in begins.values() else sorted(given, key=lambda capture: begins[capture] or 0)


class CapturedPacket(NamedTuple):
    """A packet of a capture."""

    capture: Path
    number: int  # there
    description: bytes  # of its interface: the body of the block
    body: bytes  # of its block
    is_apart: bool = False  # a file begins here that a recorder kept: nothing is known of what came just before it

    @property
    def raw(self) -> reading.RawPacket:
        """Return what is in it, of an interface that counts nanoseconds."""
        high, low, length = struct.unpack_from("<III", self.body, 4)
        (link_type,) = struct.unpack_from("<H", self.description)
        return reading.RawPacket(link_type, high << 32 | low, self.body[20 : 20 + length], self.description)


def packets(capture: Path, say: Callable[[str], None]) -> Iterator[CapturedPacket]:
    """Yield its packets; report where it is damaged."""
    damages: list[str] = []
    try:
        yield from _packets(capture, damages.append)
    except OSError as error:  # also if a recorder has deleted it by now
        damages.append(f"{error.strerror}")
    except NotCaptured as error:
        damages.append(str(error))
    for damage in damages:
        say(f"{capture}: only what comes before the damage: {damage}")


def _packets(capture: Path, say: Callable[[str], None]) -> Iterator[CapturedPacket]:
    """Yield its packets. Raise OSError or NotCaptured."""
    is_apart, number = _is_kept(capture), 0
    descriptions: list[bytes] = []
    with reading.opened(capture) as source:
        for kind, order, body in reading.blocks(source, capture, say):
            if order != "<" or kind in reading.OTHER_PACKETS:
                raise NotCaptured(unjoinable(capture))
            if kind == pcapng.SECTION_HEADER:
                descriptions = []
            elif kind == pcapng.INTERFACE_DESCRIPTION:
                descriptions.append(body)
            elif kind == pcapng.ENHANCED_PACKET:
                (interface,) = struct.unpack_from("<I", body)
                if interface >= len(descriptions):
                    raise NotCaptured(f"{capture} is damaged: a packet names interface {interface}, which is not there")
                number += 1
                yield CapturedPacket(capture, number, descriptions[interface], body, is_apart and number == 1)


class Joining:
    """A file with packets of several captures. Equal interfaces are one.

    A file that a recorder kept has a section of its own: the dissector must not take what comes after a seam, where
    nothing was kept, for the answer to what came before. It needs nothing from before: the file stands alone.
    """

    def __init__(self, file: BinaryIO) -> None:
        """Begin a section."""
        self.packets = 0  # so far
        self._file = file
        self._begin()

    def put(self, packet: CapturedPacket) -> None:
        """Append a packet; describe its interface if it is new."""
        if packet.is_apart and self.packets:
            self._begin()
        if packet.description not in self._interfaces:
            self._interfaces[packet.description] = len(self._interfaces)
            self._file.write(pcapng.block(pcapng.INTERFACE_DESCRIPTION, packet.description))
        number = struct.pack("<I", self._interfaces[packet.description])
        self._file.write(pcapng.block(pcapng.ENHANCED_PACKET, number + packet.body[4:]))
        self.packets += 1

    def _begin(self) -> None:
        self._interfaces: dict[bytes, int] = {}
        self._file.write(pcapng.section_header("sistap", ""))


def _is_joinable(capture: Path) -> bool:
    with reading.opened(capture) as file:
        try:
            first = next(reading.blocks(file, capture), None)
        except NotCaptured:
            return False
    return first is not None and first.order == "<"


def is_foreign(capture: Path) -> bool:
    """Tell whether it cannot be joined. One that a recorder has deleted by now is not foreign."""
    try:
        return not _is_joinable(capture)
    except OSError:
        return False


def _is_kept(capture: Path) -> bool:
    """Tell whether a recorder kept it, apart from others."""
    try:
        first = next(reading.records(capture), None)
    except (OSError, NotCaptured):
        return False
    return first is not None and first.event == Event.CAPTURE_STARTED and KEPT.encode() in first.data


def begin_ns(capture: Path) -> int | None:
    """Return the time of its first packet; None if it has none, or another program wrote it."""
    try:
        return next((packet.time_ns for packet in reading.packets(capture)), None)
    except (OSError, NotCaptured):
        return None
