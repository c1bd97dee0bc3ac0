# SPDX-License-Identifier: GPL-2.0-or-later
"""USB transfers in the text of Linux' usbmon: `cat /sys/kernel/debug/usb/usbmon/1u`.

Documentation/usb/usbmon.rst. Each line has a transfer, of its data at most 32 bytes. The times count from an unknown
moment.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from sistap.commands.imports.source import lines
from sistap.commands.imports.usb_transfers import BULK, CONTROL, INBOUND, INTERRUPT, Setup, Transfer, is_failure
from sistap.tap.common.usbmon import LINE

FIRST_LINE = rf"(?ms).*?^\s*{LINE.pattern}"  # behind what somebody has written above

_TYPES = {"C": CONTROL, "B": BULK, "I": INTERRUPT}
_ISOCHRONOUS = "Z"  # of no adapter
_TRANSFER = re.compile(
    LINE.pattern + r" (?:s(?P<setup>(?: [0-9a-f]{2,4}){5})|[^\d\s](?: \S+){5}|(?P<status>-?\d{1,9})\S*)"
    r" (?P<length>\d{1,9})(?: =(?P<data>(?: (?:[0-9a-f]{2}){1,4})+)| [^=])?"
)
# The microseconds are those of the last 4096 s; in old kernels, what fits into 32 bits.
_US = 1000
_PERIOD_US, _OLD_PERIOD_US = 4096_000_000, 1 << 32
_DEVICE, _CONFIGURATION, _INTERFACE = b"\x12\x01", b"\x09\x02", 4  # beginnings of descriptors, and a type


class UsbmonTransfers:
    """The transfers in a text."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.warning = ""

    def __iter__(self) -> Iterator[Transfer]:
        """Yield the transfers in the order of the text."""
        self.warning = ""
        before_us = begun_us = 0
        for number, line in enumerate(map(str.strip, lines(self._path)), 1):
            known = LINE.match(line)
            if not known or known["type"] == _ISOCHRONOUS:
                continue
            match = _TRANSFER.fullmatch(line)
            if not match:
                self.warning = self.warning or f"line {number} cannot be read: it is left out"
                continue
            time_us = int(match["us"])
            if before_us - time_us > _PERIOD_US // 2:
                begun_us += _PERIOD_US if before_us < _PERIOD_US else _OLD_PERIOD_US
            before_us = time_us
            yield _transfer(match, (begun_us + time_us) * _US)


def _transfer(match: re.Match[str], time_ns: int) -> Transfer:
    inbound, completed = match["way"] == "i", match["event"] != "S"
    data, length = bytes.fromhex(match["data"] or ""), int(match["length"])
    setup = [int(word, 16) for word in (match["setup"] or "").split()]
    vendor, classes = _described(data if match["type"] == "C" else b"")
    return Transfer(
        time_ns=time_ns,
        device=f"{int(match['bus'] or 0)}.{int(match['device'])}",
        endpoint=int(match["endpoint"]) | (INBOUND if inbound else 0),
        type=_TYPES[match["type"]],
        completed=completed,
        id=match["id"],
        data=data,
        actual=length if completed else None,
        is_cut=completed == inbound and len(data) < length,
        failed=completed and is_failure(int(match["status"] or 0)),
        setup=Setup(*setup[:4]) if setup else None,
        vendor=vendor,
        classes=classes,
        by_windows=False,
    )


def _described(data: bytes) -> tuple[int | None, frozenset[int]]:
    """Return the vendor, and the classes of interfaces, that descriptors name (USB 2.0 chapter 9.6)."""
    vendor = int.from_bytes(data[8:10], "little") if data.startswith(_DEVICE) and len(data) >= 10 else None
    classes, at = set(), 0
    while data.startswith(_CONFIGURATION) and at + 5 < len(data) and data[at]:
        if data[at + 1] == _INTERFACE:
            classes.add(data[at + 5])
        at += data[at]
    return vendor, frozenset(classes)
