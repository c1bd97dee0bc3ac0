# SPDX-License-Identifier: GPL-2.0-or-later
"""What each driver of Linux can say about line errors. Readers, `ports`, `doctor` and docs/line-errors.md use it.

The facts are those of the drivers themselves (drivers/usb/serial, drivers/usb/class, drivers/tty/serial). Only counters
(TIOCGICOUNT) tell of lost characters. They are ahead of the characters: what is counted with one read may belong to one
of the next.
"""

from __future__ import annotations

import enum
from typing import NamedTuple


class ErrorPlace(enum.Enum):
    """Where a damaged character is, as far as a driver says. The value is for a table."""

    CHARACTER = "at the character"
    PACKET = "somewhere in a USB packet"  # all its characters are marked
    READ = "somewhere in a read"  # an error is counted, no character is marked
    NOWHERE = "none"
    UNKNOWN = "not known"


class Driver(NamedTuple):
    """A driver, or several that say the same."""

    names: tuple[str, ...]  # as sysfs has them
    adapters: str  # for people
    place: ErrorPlace
    counts: bool = False  # it counts line errors, and so lost characters
    breaks: bool = False  # a break differs from a damaged 00
    begins_late: bool = False  # on a busy line, the first character may be a false 00
    caveat: str = ""  # what else to know, in sentences without the last full stop

    @property
    def clause(self) -> str:
        """Return what it says, as a clause for the description of a capture; empty if that is not known."""
        return _CLAUSES[self.place]

    @property
    def explanation(self) -> str:
        """Return all that a user should know, in sentences without the last full stop; empty if nothing is known."""
        limits = (
            (self.place == ErrorPlace.NOWHERE, "A damaged character looks like a good one"),
            (self.place == ErrorPlace.NOWHERE, "FTDI and CP210x adapters report line errors"),
            (self.errors and not self.breaks, "A break looks like any other error"),
            (self.errors and not self.counts, "Lost characters are not reported"),
        )
        return ". ".join(filter(None, (self.clause, *(text for applies, text in limits if applies), self.caveat)))

    @property
    def errors(self) -> bool:
        """Tell whether it is known to report line errors."""
        return self.place not in (ErrorPlace.NOWHERE, ErrorPlace.UNKNOWN)

    def warning(self, port: str) -> str:
        """Return a message about a port for the beginning of a capture, if its line errors say less than usual."""
        return f"{port}: {self.explanation}" if self.explanation and not self.breaks else ""


def reports(description: str) -> bool | None:
    """Tell from the description of a capture whether its adapter reports line errors; None: it does not say."""
    if NOT_REPORTED in description:
        return False
    return any(clause and clause in description for clause in _CLAUSES.values()) or None


NOT_REPORTED = "no line errors are reported"
_CLAUSES = {
    ErrorPlace.CHARACTER: "line errors at their character",
    ErrorPlace.PACKET: "line errors somewhere in their USB packet",
    ErrorPlace.READ: "line errors somewhere in their read or beside it",
    ErrorPlace.NOWHERE: NOT_REPORTED,
    ErrorPlace.UNKNOWN: "",
}
_UPORT = ("mxuport", "quatech-serial")
_EDGEPORT = ("edgeport_2", "edgeport_4", "edgeport_8", "epic", "edgeport_ti_1", "edgeport_ti_2")
_SILENT = (
    *("mct_u232", "moschip7720", "mos7840", "oti6858", "SPCP8x5", "xr_serial", "ti_usb_3410_5052_1"),
    *("ti_usb_3410_5052_2", "kl5kusb105d", "keyspan_pda", "whiteheat", "upd78f0730", "generic"),
)

UART = Driver((), "8250, 16550: ports without USB", ErrorPlace.CHARACTER, counts=True, breaks=True)
UNKNOWN = Driver((), "any other", ErrorPlace.UNKNOWN)
DRIVERS = (
    UART,
    Driver(
        ("cp210x",),
        "CP210x, from Linux 5.10 on",
        ErrorPlace.CHARACTER,
        counts=True,
        breaks=True,
        begins_late=True,
        caveat="Some copies of the CP2102 report nothing, and Linux does not tell. Damaged telegrams without any line "
        "error show it. On a busy line the first character may be a false 00. It is marked as an error without a place",
    ),
    Driver(
        ("ftdi_sio",),
        "FTDI: FT232, FT2232 ...",
        ErrorPlace.PACKET,
        counts=True,
        breaks=True,
        caveat="A damaged character that is alone in its packet is marked. After a break, Linux may "
        "take a good 00 for another break. In the next two reads, such a 00 is marked as an error without a place",
    ),
    Driver(
        ("pl2303", "belkin", "digi_2", "digi_4", "earthmate", "cyphidcom", "nokiaca42v2"),
        "PL2303; Belkin, Digi AccelePort, Cypress M8",
        ErrorPlace.PACKET,
        caveat="The damaged character may also be beside the packet. After a break, Linux makes 00 of all characters "
        "of a packet. So a 00 with such an error is doubtful",
    ),
    Driver(("ark3116", "ssu100"), "ARK3116, SSU-100", ErrorPlace.PACKET, counts=True, caveat="As PL2303"),
    Driver(
        ("cdc_acm",),
        "CDC ACM: `ttyACM0`",
        ErrorPlace.READ,
        counts=True,
        breaks=True,
        caveat="Errors come by another way than the characters. So the next two reads are marked, too. If a device "
        "tells of an error still earlier or later, the damaged character has no mark",
    ),
    Driver((*_UPORT, *_EDGEPORT), "Moxa UPort, Quatech, Edgeport", ErrorPlace.READ, counts=True, caveat="As CDC ACM"),
    Driver(
        ("f81232", "f81534", "f81534a", "keyspan_1", "keyspan_2", "keyspan_4"),
        "Fintek F81232, F81534; Keyspan",
        ErrorPlace.CHARACTER,
    ),
    Driver(
        ("ch341-uart",),
        "CH340, CH341",
        ErrorPlace.NOWHERE,
        caveat="Chips of a version below 0x30 never get the format, and Linux does not tell",
    ),
    Driver(_SILENT, "MCT U232, MosChip, OTi-6858, SPCP8x5, XR21, TI 3410 ...", ErrorPlace.NOWHERE),
)
_BY_NAME = {name: driver for driver in DRIVERS for name in driver.names}


def driver(name: str, *, is_uart: bool = False) -> Driver:
    """Return what a driver can say, by its name in sysfs."""
    return UART if is_uart else _BY_NAME.get(name, UNKNOWN)
