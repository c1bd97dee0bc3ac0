# SPDX-License-Identifier: GPL-2.0-or-later
"""USB transfers of usbmon and USBPcap, as tshark dissects them.

The dissectors of the adapters themselves are switched off: they need to see an adapter being plugged in. Any capture
has the requests and bytes.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from sistap.commands.imports.dissected import FieldRows, nanoseconds
from sistap.commands.imports.source import SENT
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings, Read

CONTROL, BULK, INTERRUPT = 2, 3, 1
INBOUND = 0x80  # in the address of an endpoint

_FIELDS = (
    "frame.time_epoch",
    "frame.len",
    "frame.cap_len",
    "usb.bus_id",
    "usb.device_address",
    "usb.endpoint_address",
    "usb.transfer_type",
    "usb.urb_type",
    "usb.urb_status",
    "usb.irp_info.direction",
    "usb.usbd_status",
    "usb.urb_id",
    "usb.irp_id",
    "usb.urb_len",
    "usb.data_len",
    "usb.bmRequestType",
    "usb.setup.bRequest",
    "usb.setup.wValue",
    "usb.setup.wIndex",
    "usb.data_fragment",
    "usb.capdata",
    "usb.idVendor",
    "usb.bInterfaceClass",
)
_TRUE = ("1", "0x01", "True")
# A transfer that the host cancels is no error: ENOENT, ECONNRESET, ESHUTDOWN; USBD_STATUS_CANCELED.
_CANCELLED = (-2, -104, -108)
_USBD_ERROR, _USBD_CANCELLED = 0x80000000, 0xC0010000
# Characters must not be dissected as some other protocol, either.
_OPTIONS = ("--disable-protocol", "ftdi-ft", "--disable-protocol", "usbcom", "-o", "usb.try_heuristics:FALSE")


class Setup(NamedTuple):
    """A control request (USB 2.0 chapter 9.3): bmRequestType, bRequest, wValue and wIndex."""

    type: int
    request: int
    value: int
    place: int


class Transfer(NamedTuple):
    """A transfer as it was submitted, or as it was completed."""

    time_ns: int
    device: str  # "BUS.ADDRESS"
    endpoint: int  # the address: 0x80 is the direction to the computer
    type: int  # CONTROL ...
    completed: bool
    id: str  # equal for submission and completion
    data: bytes
    actual: int | None  # number of bytes transferred, if known
    is_cut: bool  # the capture does not have all of the data
    failed: bool  # other than by the host's own will
    setup: Setup | None
    vendor: int | None
    classes: frozenset[int]  # of interfaces
    by_windows: bool

    @property
    def inbound(self) -> bool:
        """Tell whether the data go to the computer."""
        return bool(self.endpoint & INBOUND)


def with_requests(transfers: Iterable[Transfer]) -> Iterator[Transfer]:
    """Yield the transfers; a completed control transfer says, too, what was requested."""
    requests: dict[tuple[str, str], Transfer] = {}
    for transfer in transfers:
        of = transfer.device, transfer.id
        if transfer.type != CONTROL:
            yield transfer
        elif not transfer.completed:
            requests[of] = transfer
            yield transfer
        else:
            request = requests.pop(of, transfer)
            yield transfer._replace(setup=request.setup, data=request.data or transfer.data)


class Transfers:
    """The transfers in a capture."""

    def __init__(self, tshark: Tshark, capture: Path) -> None:
        self._rows = FieldRows(tshark, capture, _FIELDS, _OPTIONS)
        self.warning = ""  # what tshark said at the end of a capture that is cut off

    def __iter__(self) -> Iterator[Transfer]:
        """Yield the transfers in the order of the capture. May raise TsharkError."""
        for row in self._rows:
            if row["usb.transfer_type"] and row["usb.device_address"]:
                yield _transfer(row)
        self.warning = self._rows.warning


def _transfer(row: dict[str, str]) -> Transfer:
    by_windows = bool(row["usb.irp_id"])
    data_length, urb_length = _integer(row["usb.data_len"]), _integer(row["usb.urb_len"])
    completed = row["usb.irp_info.direction"] in _TRUE if by_windows else "S" not in row["usb.urb_type"]
    endpoint = _integer(row["usb.endpoint_address"])
    # Inbound data are in the completion, outbound data in the submission. usbmon keeps what fits into its buffer.
    has_data = completed == bool(endpoint & INBOUND)
    is_cut = row["frame.cap_len"] != row["frame.len"] or (has_data and data_length < urb_length)
    return Transfer(
        time_ns=nanoseconds(row["frame.time_epoch"]),
        device=f"{_integer(row['usb.bus_id'])}.{_integer(row['usb.device_address'])}",
        endpoint=endpoint,
        type=_integer(row["usb.transfer_type"]),
        completed=completed,
        id=row["usb.irp_id"] or row["usb.urb_id"],
        data=bytes.fromhex((row["usb.capdata"] or row["usb.data_fragment"]).replace(":", "")),
        actual=_actual(row, urb_length) if completed else None,
        is_cut=is_cut,
        failed=completed and _failed(row),
        setup=_setup(row),
        vendor=_integer(row["usb.idVendor"]) if row["usb.idVendor"] else None,
        classes=frozenset(int(number, 0) for number in row["usb.bInterfaceClass"].split(",") if number),
        by_windows=by_windows,
    )


def _failed(row: dict[str, str]) -> bool:
    by_windows = _integer(row["usb.usbd_status"])
    windows_failed = by_windows >= _USBD_ERROR and by_windows != _USBD_CANCELLED
    return windows_failed or is_failure(_integer(row["usb.urb_status"]))


def is_failure(status: int) -> bool:
    """Tell whether a status of Linux is an error that the host did not cause."""
    return status < 0 and status not in _CANCELLED


def _actual(row: dict[str, str], length: int) -> int | None:
    if "E" in row["usb.urb_type"]:  # it could not be submitted
        return 0
    return length if row["usb.urb_len"] else None


def _setup(row: dict[str, str]) -> Setup | None:
    if not row["usb.setup.bRequest"]:
        return None
    names = ("usb.bmRequestType", "usb.setup.bRequest", "usb.setup.wValue", "usb.setup.wIndex")
    return Setup(*(_integer(row[name]) for name in names))


def _integer(text: str) -> int:
    return int(text.split(",")[0], 0) if text else 0


# -- The two times between which the characters of a transfer were on the line. Nothing narrower is claimed ----------

FRAME_NS = 1_000_000  # the host asks at least once in a frame (USB 2.0 chapter 5.8)
# USBPcap takes the time from the Windows clock, which advances in ticks. A stamp is too early by up to a tick.
WINDOWS_TICK_NS = 15_625_000
_MS = 1_000_000


def latest_ns(transfer: Transfer) -> int:
    """Return the latest time at which a transfer can have been stamped."""
    return transfer.time_ns + (WINDOWS_TICK_NS if transfer.by_windows else 0)


class Arrivals:
    """An upper bound on how long the contents of a completed transfer were in the adapter.

    With a latency timer (FTDI), a transfer comes at least once per period, even an empty one, as long as the host asks.
    If the host did not ask, the adapter collected since it was last emptied.
    """

    def __init__(self) -> None:
        """Start with an adapter of which nothing has been seen."""
        self._emptied_ns: int | None = None
        self._asked_ns: int | None = None

    def ask(self, transfer: Transfer) -> None:
        """Note that the host asks for characters."""
        self._asked_ns = transfer.time_ns

    def waited_ns(self, transfer: Transfer, latency_ms: int | None, *, is_full: bool) -> int:
        """Return that bound in ns for a completed transfer. `latency_ms` is None for an adapter without a timer.

        `is_full`: the transfer has no room for more, so the adapter may not be empty after it.
        """
        waited_ns = FRAME_NS if latency_ms is None else latency_ms * _MS
        if latency_ms is not None and self._emptied_ns is not None:
            collected_ns = max(transfer.time_ns - self._emptied_ns, 0)
            was_asked = self._asked_ns is not None and transfer.time_ns - self._asked_ns >= FRAME_NS
            waited_ns = min(waited_ns, collected_ns) if was_asked else collected_ns
        if not is_full:
            self._emptied_ns = transfer.time_ns
        return waited_ns + FRAME_NS + latest_ns(transfer) - transfer.time_ns


class Departures:
    """When characters that were handed to the adapter have left it: one after the other, once the line is free."""

    def __init__(self) -> None:
        self._free_ns = (0, 0)  # earliest and latest

    def sent(
        self, submitted: Transfer, completed: Transfer | None, flags: bytes, settings: LineSettings
    ) -> Iterator[Read]:
        """Yield each character when it has left; `flags` has one byte for each character.

        None begins before it was handed over. When the transfer is completed, all are in the adapter. Without a
        completion nobody knows.
        """
        earliest_ns = max(submitted.time_ns, self._free_ns[0])
        begun_ns = max(latest_ns(completed or submitted) + FRAME_NS, self._free_ns[1])
        uncertainty_ns = bounded(begun_ns - earliest_ns) if completed else UNCERTAINTY_UNKNOWN
        character_ns = settings.character_ns
        for number, flag in enumerate(flags):
            time_ns = begun_ns + (number + 1) * character_ns
            yield Read(SENT, time_ns, submitted.data[number : number + 1], bytes([flag]), uncertainty_ns, settings)
        self._free_ns = (earliest_ns + len(flags) * character_ns, begun_ns + len(flags) * character_ns)


def bounded(uncertainty_ns: int) -> int:
    """Return an uncertainty that fits into a record; a larger one becomes unknown."""
    return uncertainty_ns if 0 <= uncertainty_ns < UNCERTAINTY_UNKNOWN else UNCERTAINTY_UNKNOWN
