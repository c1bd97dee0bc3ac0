# SPDX-License-Identifier: GPL-2.0-or-later
"""COM ports of Windows: the characters, the errors that their driver tells, and how exact the times are."""

from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import pytest

from sistap.tap import windows
from sistap.tap.line import measurement
from sistap.tap.line.ports import Adapter
from sistap.tap.line.reader import PortError, PortLost, computer, latency
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, Flag, LineSettings
from sistap.tap.windows import CommPort, flags

pytestmark = pytest.mark.tap

SETTINGS = LineSettings()
OVERRUN, PARITY, FRAME, BREAK = 0x02, 0x04, 0x08, 0x10
MS = 1_000_000
MACHINE_NS = 300_000
FTDI = Adapter("USB Serial Port (COM5)", "FTSER2K", latency_ms=16)


class Came(NamedTuple):
    """Something at the port: characters, errors, or both."""

    data: bytes
    errors: int = 0


class Win32:
    """The reading functions of serial.win32: each ReadFile delivers what came next; errors are reported once."""

    DWORD = ctypes.c_uint32

    class COMSTAT(ctypes.Structure):
        _fields_ = [("flags", ctypes.c_uint32), ("cbInQue", ctypes.c_uint32), ("cbOutQue", ctypes.c_uint32)]

    class OVERLAPPED(ctypes.Structure):
        _fields_ = [("hEvent", ctypes.c_void_p)]

    class COMMTIMEOUTS(ctypes.Structure):
        _fields_ = [
            ("ReadIntervalTimeout", ctypes.c_uint32),
            ("ReadTotalTimeoutMultiplier", ctypes.c_uint32),
            ("ReadTotalTimeoutConstant", ctypes.c_uint32),
        ]

    def __init__(self, *came: Came, waiting: bytes = b"") -> None:
        self.came = list(came)
        self.waiting = waiting
        self.errors = 0
        self.time_outs: list[tuple[int, int, int]] = []
        self.is_gone = False
        self.why_gone = 5
        self.last_error = 0
        self.is_timed_out = False  # wine says that a read of nothing failed

    def CreateEvent(self, *_: object) -> int:
        return 7

    def CloseHandle(self, handle: int) -> None:
        assert handle == 7

    def ResetEvent(self, handle: int) -> None: ...

    def GetLastError(self) -> int:
        return self.last_error

    def SetCommTimeouts(self, handle: int, place: Any) -> None:
        time_outs = place._obj
        self.time_outs.append(
            (time_outs.ReadIntervalTimeout, time_outs.ReadTotalTimeoutMultiplier, time_outs.ReadTotalTimeoutConstant)
        )

    def ClearCommError(self, handle: int, errors: Any, status: Any) -> bool:
        errors._obj.value, self.errors = self.errors, 0
        status._obj.cbInQue = len(self.waiting)
        self.last_error = self.why_gone if self.is_gone else 0
        return not self.is_gone

    def ReadFile(self, handle: int, buffer: Any, size: int, count: Any, overlapped: object) -> bool:
        assert handle == 99
        assert size <= (len(self.waiting) or 1)  # it would wait for more
        if not self.waiting and self.came:
            came = self.came.pop(0)
            self.waiting, self.errors = came.data, self.errors | came.errors
        data, self.waiting = self.waiting[:size], self.waiting[size:]
        ctypes.memmove(buffer, data, len(data))
        self.count, self.last_error = len(data), 997
        return False

    def GetOverlappedResult(self, handle: int, overlapped: object, count: Any, wait: bool) -> bool:
        count._obj.value = self.count
        self.last_error = self.why_gone if self.is_gone else 1460
        return not (self.is_gone or self.is_timed_out)


class Device:
    """Pyserial's port."""

    _port_handle = 99
    is_open = False

    def open(self) -> None:
        self.is_open = True

    def close(self) -> None:
        self.is_open = False


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Device:
    port = Device()
    monkeypatch.setattr(windows, "closed_serial", lambda *_: port)
    monkeypatch.setattr(latency, "measured_ns", lambda: MACHINE_NS)
    return port


def opened(api: Win32, behind: Adapter = FTDI) -> windows.WindowsReader:
    return windows.WindowsReader("COM5", SETTINGS, 1, behind, lambda device: CommPort(device, api))


@pytest.mark.parametrize(
    ("errors", "count", "expected"),
    [
        (0, 2, [0, 0]),
        (PARITY, 1, [Flag.UNLOCATED_ERROR]),
        (FRAME, 2, [Flag.UNLOCATED_ERROR] * 2),
        (BREAK, 1, [Flag.UNLOCATED_ERROR]),
        (OVERRUN, 1, [Flag.LOST_BEFORE]),
        (OVERRUN, 2, [Flag.LOST_BEFORE | Flag.UNLOCATED_ERROR, Flag.UNLOCATED_ERROR]),
    ],
)
def test_an_error_is_somewhere_in_its_read(errors: int, count: int, expected: list[int]) -> None:
    assert list(flags(errors, count)) == expected


def test_characters_and_errors_come_through(device: Device) -> None:
    source = opened(Win32(Came(b"A"), Came(b"BC", PARITY), Came(b"D")))
    reads = [source.read(0.01) for _ in range(4)]
    assert [(read.data, list(read.flags)) for read in reads if read] == [
        (b"A", [0]),
        (b"BC", [Flag.UNLOCATED_ERROR] * 2),
        (b"D", [0]),
    ]
    assert reads[3] is None
    assert reads[0] and (reads[0].line, reads[0].settings) == (1, SETTINGS)
    source.close()
    assert not device.is_open


def test_an_error_told_before_its_character_is_not_dropped(device: Device) -> None:
    api = Win32()
    source = opened(api)
    api.errors = FRAME
    assert source.read(0) is None  # asks for errors, reads nothing
    api.came.append(Came(b"A"))
    read = source.read(0.01)
    assert read and list(read.flags) == [Flag.UNLOCATED_ERROR]


def test_what_waits_when_an_error_is_told_is_part_of_its_read(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    api = Win32(Came(b"A"))
    source = opened(api)
    read_file = api.ReadFile

    def and_more(*arguments: Any) -> bool:
        result = read_file(*arguments)
        if not api.came and not api.errors:
            api.came.append(Came(b""))
            api.waiting, api.errors = b"B", PARITY
        return result

    monkeypatch.setattr(api, "ReadFile", and_more)
    read = source.read(0.01)
    assert read and (read.data, list(read.flags)) == (b"AB", [Flag.UNLOCATED_ERROR] * 2)


def test_no_read_waits_longer_than_a_step(device: Device) -> None:
    api = Win32()
    source = opened(api)
    source.change(LineSettings(19200))
    assert api.time_outs == [(0, 0, 10)] * 2  # again after pyserial set its own
    assert source.settings.baud == 19200


def test_the_latency_timer_bounds_the_times(device: Device) -> None:
    source = opened(Win32(Came(b"A")))
    read = source.read(0.01)
    assert read and read.uncertainty_ns == 16 * MS + MACHINE_NS
    assert source.adapter == "USB Serial Port (COM5) (FTSER2K, latency timer 16 ms)"
    assert source.timing.startswith("uncertainty 16.30 ms: latency timer 16 ms and 0.30 ms, measured when the ")
    assert "; clock " in source.timing
    assert source.notes == (
        "COM5: its latency timer is 16 ms, so times are up to that late: in Device Manager > Ports (COM & LPT) > "
        "USB Serial Port (COM5) > Properties > Port Settings > Advanced set Latency Timer (msec) to 1, then "
        "start again",
    )
    assert opened(Win32(), FTDI._replace(latency_ms=1)).notes == ()


def test_characters_that_waited_are_older(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [1_000_000_000]
    monkeypatch.setattr(windows, "monotonic_ns", lambda: now[0])
    api = Win32()
    source = opened(api)
    assert source.read(0) is None
    now[0] += 7 * MS
    api.waiting = b"A"
    read = source.read(0)
    assert read and read.uncertainty_ns == 16 * MS + MACHINE_NS + 7 * MS


def test_other_adapters_have_no_bound(device: Device) -> None:
    source = opened(Win32(Came(b"A")), Adapter())
    read = source.read(0.01)
    assert read and read.uncertainty_ns == UNCERTAINTY_UNKNOWN
    assert source.adapter == "COM5"
    assert source.timing.startswith("Windows does not report how exact its times are; clock ")
    assert [note.partition(":")[0] for note in source.notes] == ["COM5"]


def test_a_read_that_times_out_is_no_loss(device: Device) -> None:
    api = Win32()
    source = opened(api)
    api.is_timed_out = True
    assert source.read(0.01) is None


def test_a_port_that_is_unplugged(device: Device) -> None:
    api = Win32(Came(b"A"))
    source = opened(api)
    assert source.read(0.01)
    api.is_gone = True
    for _ in range(2):
        with pytest.raises(PortLost, match="^COM5 is gone: plug the adapter in and start a new capture$"):
            source.read(0.01)


@pytest.mark.parametrize(("number", "words"), [(31, "does not work"), (121, "does not answer")])
def test_an_adapter_that_hangs(device: Device, number: int, words: str) -> None:
    api = Win32(Came(b"A"))
    source = opened(api)
    assert source.read(0.01)
    api.is_gone, api.why_gone = True, number
    with pytest.raises(PortLost, match=rf"{words} \(Windows error {number}\): unplug it, .* start a new capture$"):
        source.read(0.01)


@pytest.mark.parametrize(
    ("why", "said"),
    [
        (
            "could not open port 'COM5': PermissionError(13, 'Zugriff verweigert', None, 5)",
            "is in use by another program: close that program first",
        ),
        (
            "could not open port 'COM5': FileNotFoundError(2, 'Das System ...', None, 2)",
            "does not exist: `sistap ports` lists the ports there are",
        ),
        (
            "could not open port 'COM5': OSError(22, 'Das Zeitlimit (Semaphor)', None, 121)",
            r"is there, but its adapter does not answer \(Windows error 121\): unplug it, and plug it in again",
        ),
        (
            "Cannot configure port, something went wrong. Original message: OSError(22, 'Ein Gerät', None, 31)",
            r"is there, but its adapter does not work \(Windows error 31\): unplug it, and plug it in again",
        ),
        (
            "Cannot configure port, something went wrong. Original message: OSError(22, 'Falsch', None, 87)",
            "cannot do 9600 Bd 8E1: choose another --baud or --format",
        ),
    ],
)
def test_a_port_that_cannot_be_opened(device: Device, monkeypatch: pytest.MonkeyPatch, why: str, said: str) -> None:
    def refuse() -> None:
        raise OSError(why)

    monkeypatch.setattr(device, "open", refuse)
    with pytest.raises(PortError, match=f"^COM5 {said}$"):
        opened(Win32())


def test_the_machine_is_measured_through_a_socket() -> None:
    measured = (computer.through_socket(50 * MS) for _ in range(100))  # a busy machine may sleep for longer than that
    delays = next(delays for delays in measured if len(delays) > 10)
    assert min(delays) > 0


def test_a_self_test_takes_the_place_of_measuring() -> None:
    measurement.store(measurement.Result("machine", "2026-11-20", 5000, 250_000, 3 * MS, measurement.conditions()))
    known = latency.known()
    assert latency.bound(known, "COM5", FTDI, SETTINGS).ns(known.machine_ns) == 16 * MS + 250_000
