# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads several captures as one: in the order of their time, joined into one file for tshark."""

from __future__ import annotations

import struct
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import BinaryIO, NamedTuple

from sistap.dissected.captures import reading
from sistap.tap.common import temporary
from sistap.tap.common.packed import is_text, making, no_capture, untold
from sistap.tap.files import pcapng
from sistap.tap.records.record import KEPT, Event
from sistap.tap.terminal.exits import NotCaptured, Refusal

_USB = {186, 189, 220, 249, 266}  # link types (tcpdump.org/linktypes.html): FreeBSD, Linux, Windows, macOS


def check_captures(named: Iterable[Path], say: Callable[[str], None], output: str | None = None) -> list[Path]:
    """Return all captures, those of a folder one by one. Say what is left out of a folder because it cannot be read.

    Refusal unless all others can be read, twice, and none is the output.
    """
    captures = [capture for path in named for capture in (_readable(_inside(path), say) if path.is_dir() else [path])]
    for capture in captures:
        if capture.exists() and not capture.is_file():
            raise Refusal(f"{capture} is not a file: it is read twice, so save the capture first")
        try:
            _check_contents(capture, say)
        except OSError as error:
            raise Refusal(f"cannot read {capture}: {error.strerror}; name a capture file") from None
        if output and Path(output).exists() and capture.samefile(output):
            raise Refusal(f"{output} is the capture itself; name another file with -o")
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
        return "" if _is_joinable(capture) else alone(capture)
    except OSError as error:
        return f"cannot read {capture}: {error.strerror}"
    except NotCaptured as error:
        return str(error)


def alone(capture: Path) -> str:
    """Say that it cannot be joined."""
    return f"{capture} cannot be read with others: open it in Wireshark and save it as pcapng"


class _JoinedCapture(NamedTuple):
    """A capture in a joined one."""

    first: int  # number of its first packet
    capture: Path


class Joined(NamedTuple):
    """A file with the packets of one or several captures."""

    path: Path
    parts: Sequence[_JoinedCapture]

    def place(self, number: int) -> tuple[Path, int]:
        """Return the capture of a packet, and its number there."""
        part = self.parts[bisect_right(self.parts, number, key=lambda part: part.first) - 1]
        return part.capture, number - part.first + 1

    def number(self, capture: Path) -> int:
        """Return the number of its first packet."""
        return next(part.first for part in self.parts if part.capture == capture)


def in_order(captures: Iterable[Path]) -> list[Path]:
    """Sort captures by their first packets. If any has no such time, the order stays."""
    given = [*captures]
    begins = {capture: begin_ns(capture) for capture in given}
    return given if None in begins.values() else sorted(given, key=lambda capture: begins[capture] or 0)


def together(captures: Sequence[Path], say: Callable[[str], None]) -> AbstractContextManager[Joined]:
    """Join captures; a single one stays as it is. Report damage. Raise NotCaptured for a foreign one."""
    if len(captures) == 1:
        return nullcontext(Joined(captures[0], [_JoinedCapture(1, captures[0])]))
    return joined(captures, say)


@contextmanager
def joined(captures: Sequence[Path], say: Callable[[str], None]) -> Iterator[Joined]:
    """Join captures. Report damage. Raise NotCaptured for a foreign one."""
    with temporary.folder() as folder:
        path = folder / "joined.pcapng"
        with path.open("wb") as file:
            joining = _Joining(file)
            parts = [joining.add(capture, say) for capture in captures]
        yield Joined(path, parts)


class _Joining:
    """A file with one section. Equal interfaces of several captures are one.

    A file that a recorder kept has a section of its own: the dissector must not take what comes after a seam, where
    nothing was kept, for the answer to what came before. It needs nothing from before: the file stands alone.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._has_section = False
        self._packets = 0
        self._interfaces: dict[bytes, int] = {}

    def add(self, capture: Path, say: Callable[[str], None]) -> _JoinedCapture:
        """Append the packets of a capture; report where it is damaged. Raise NotCaptured if it is foreign."""
        part = _JoinedCapture(self._packets + 1, capture)
        try:
            damage = self._append(capture)
        except OSError as error:  # also if a recorder has deleted it by now
            damage = f"{error.strerror}"
        if damage:
            say(f"{capture}: only what comes before the damage: {damage}")
        return part

    def _append(self, capture: Path) -> str:
        """Append its packets; return what is damaged."""
        if not _is_joinable(capture):
            raise NotCaptured(alone(capture))
        if _is_kept(capture):
            self._has_section = False
        try:
            with reading.opened(capture) as source:
                damages: list[str] = []
                for block in reading.blocks(source, capture, damages.append):
                    self._take(block, capture)
                return "".join(damages)
        except NotCaptured as error:
            return str(error)

    def _take(self, block: reading.Block, capture: Path) -> None:
        """Append a block if it is a packet or new."""
        kind, order, body = block
        if order != "<" or kind in reading.OTHER_PACKETS:
            raise NotCaptured(f"{capture} was not written by sistap: read it alone")
        if kind == pcapng.SECTION_HEADER:
            self._numbers: list[int] = []  # of its interfaces
            if not self._has_section:
                self._has_section, self._interfaces = True, {}
                self._write(kind, body)
        elif kind == pcapng.INTERFACE_DESCRIPTION:
            if body not in self._interfaces:
                self._interfaces[body] = len(self._interfaces)
                self._write(kind, body)
            self._numbers.append(self._interfaces[body])
        elif kind == pcapng.ENHANCED_PACKET:
            (number,) = struct.unpack_from("<I", body)
            if number >= len(self._numbers):
                raise NotCaptured(f"{capture} is damaged: a packet names interface {number}, which is not there")
            self._write(kind, struct.pack("<I", self._numbers[number]) + body[4:])
            self._packets += 1

    def _write(self, kind: int, body: bytes) -> None:
        self._file.write(pcapng.block(kind, body))


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
