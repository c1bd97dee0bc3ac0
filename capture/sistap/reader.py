# SPDX-License-Identifier: GPL-2.0-or-later
"""Readers: characters with their times and errors from a serial device, a pyserial URL, or a virtual bus.

A reader only listens. It never writes to a port, sends no break, flushes no output, and lowers RTS and DTR: on many
adapters RTS switches the RS485 transmitter on.
"""

from __future__ import annotations

import errno
import functools
import os
import select
import socket
import stat
import struct
import sys
import threading
import time
from collections import deque
from pathlib import Path
from time import monotonic_ns
from typing import TYPE_CHECKING, Protocol
from urllib.parse import urlsplit

from sistap import ports, wire
from sistap.clock import CLOCK
from sistap.line import UNCERTAINTY_UNKNOWN, Flag, LineSettings, Read

if sys.platform != "win32":
    import fcntl
    import grp
    import pty
    import pwd
    import termios
    import tty

if TYPE_CHECKING:  # imported where it is needed: without pyserial the rest still works
    import serial

READ_SIZE = 4096  # as much as the line discipline of Linux holds
MEASURE_NS = 200_000_000
CONNECT_TIMEOUT_S = 5
_URL_TIMEOUT_S = 0.05  # pyserial's own; changing it per read would configure the port each time

# Linux, <asm-generic/ioctls.h>: struct termios2, of it c_ospeed; struct serial_icounter_struct, of it the counters
# frame, overrun, parity, brk and buf_overrun.
_TCGETS2 = 0x802C542A
_TERMIOS2 = struct.Struct("40xI")
_TIOCGICOUNT = 0x545D
_COUNTERS = struct.Struct("24x5i36x")

# A 16550 raises its interrupt four character times after the last character if its trigger level is not reached.
_FIFO_TIMEOUT_CHARACTERS = 4


class PortError(Exception):
    """A port cannot be opened; the text is one line that names the cure."""


class PortLost(Exception):
    """A port was lost while it was read; the text is one line that names the cure."""


class Reader(Protocol):
    """A source of characters."""

    name: str  # what the user called it, e.g. "/dev/ttyUSB0"
    adapter: str  # e.g. "FT232R USB UART (ftdi_sio, latency timer 16 ms)"
    timing: str  # one phrase: how the times are bounded
    settings: LineSettings
    line: int

    def read(self, timeout_s: float) -> Read | None:
        """Give what arrived, None if nothing did in that time. May raise PortLost."""

    def close(self) -> None:
        """Let the port go."""


def open_reader(port: str, settings: LineSettings, line: int = 0) -> Reader:
    """Open a device, a pyserial URL or a virtual bus ("bus://HOST:PORT", "bus:///SOCKET"). May raise PortError."""
    if port.startswith("bus://"):
        return WireReader(port, settings, line)
    if settings.baud <= 0:
        raise PortError(f"{port} needs a rate: say it with --baud")
    if "://" in port or sys.platform == "win32":
        return UrlReader(port, settings, line)
    return PosixReader(port, settings, line)


# -- A serial device of this machine --------------------------------------------------------------------------------


class MarkDecoder:
    """Takes the error marks of PARMRK out of what a terminal delivers (termios(3)), wherever reads cut it.

    FF FF is the character FF, FF 00 xx a character xx with an error, FF 00 00 a break. Any other FF is kept as it is.
    """

    def __init__(self) -> None:
        """Start with nothing received."""
        self.pending = b""  # the beginning of a mark that the last read cut

    def feed(self, data: bytes) -> tuple[bytes, bytes]:
        """Give the characters and, for each, its Flag."""
        if self.pending:
            data, self.pending = self.pending + data, b""
        at = data.find(0xFF)
        if at < 0:
            return data, bytes(len(data))
        characters, flags, start = bytearray(), bytearray(), 0
        while at >= 0:
            characters += data[start:at]
            flags += bytes(at - start)
            mark = data[at : at + 3]
            start = at + len(mark)
            if mark in (b"\xff", b"\xff\x00"):
                self.pending = mark
            elif mark[1]:
                characters.append(0xFF)
                flags.append(0)
                start = at + (2 if mark[1] == 0xFF else 1)
            else:
                characters.append(mark[2])
                flags.append(Flag.CHARACTER_ERROR if mark[2] else Flag.BREAK)
            at = data.find(0xFF, start)
        characters += data[start:]
        flags += bytes(len(data) - start)
        return bytes(characters), bytes(flags)


class PosixReader:
    """Reads a descriptor itself, by poll and read: a time stamp is microseconds late, through pyserial tens of them."""

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Open and configure the port. May raise PortError."""
        behind = ports.adapter(port)
        self.name = port
        self.adapter = str(behind)
        self.settings = settings
        self.line = line
        # Before opening: the port would fill while this is measured.
        self._latency_ns, self.timing = _latency(behind, settings)
        self._serial = _open_device(port, settings, behind.pseudo_terminal)
        self._lost = _lost_text(port, behind.pseudo_terminal)
        self._fd: int = self._serial.fileno()
        poll = select.poll()
        poll.register(self._fd, select.POLLIN)
        self._poll = poll.poll
        self._decoder = MarkDecoder()
        self._counters = _error_counters(self._fd)
        self._emptied_ns = monotonic_ns()  # when everything that had arrived had been read

    def read(self, timeout_s: float) -> Read | None:
        """Give what arrived, None if nothing did in that time. May raise PortLost."""
        late = bool(self._poll(0))
        if not late and not self._poll(timeout_s * 1000):
            return None
        try:
            data = os.read(self._fd, READ_SIZE)
        except BlockingIOError:
            return None
        except OSError:
            data = b""
        now = monotonic_ns()
        if not data:
            raise PortLost(self._lost)
        uncertainty_ns = self._latency_ns
        decoder = self._decoder
        if late or decoder.pending:  # it was here before it was asked for: since when, nobody knows
            uncertainty_ns = min(uncertainty_ns + now - self._emptied_ns, UNCERTAINTY_UNKNOWN)
        characters, flags = decoder.feed(data)
        if not decoder.pending and len(data) < READ_SIZE:
            self._emptied_ns = now
        if not characters:
            return None
        if len(characters) > 1 and not late:
            # Several at once: it was woken late, and its last character waited, too, for as long as one more takes.
            uncertainty_ns = min(uncertainty_ns + self.settings.character_ns, UNCERTAINTY_UNKNOWN)
        if self._counters is not None:
            flags = self._with_counted(flags)
        return Read(self.line, CLOCK.wall_ns(now), characters, flags, uncertainty_ns)

    def close(self) -> None:
        """Let the port go."""
        self._serial.close()

    def _with_counted(self, flags: bytes) -> bytes:
        """Add to the flags of a read what only the driver's error counters tell."""
        before, now = self._counters, _error_counters(self._fd)
        if now is None or before is None or now == before:
            return flags
        self._counters = now
        framing, overrun, parity, breaks, buffer_overrun = map(int.__ne__, now, before)
        unmarked = (framing or parity or breaks) and not any(flags)
        marked = bytearray(flags)
        # A loss is before one of the characters, an error that left no mark at one of them.
        if unmarked or ((overrun or buffer_overrun) and len(flags) > 1):
            marked = bytearray(flag | Flag.UNLOCATED_ERROR for flag in flags)
        if overrun or buffer_overrun:
            marked[0] |= Flag.LOST_BEFORE
        return bytes(marked)


def _error_counters(fd: int) -> tuple[int, ...] | None:
    """Read the driver's counters of frame, overrun, parity, break and buffer overrun; None where it has none."""
    try:
        return _COUNTERS.unpack(fcntl.ioctl(fd, _TIOCGICOUNT, bytes(_COUNTERS.size)))
    except OSError:
        return None


def _open_device(port: str, settings: LineSettings, pseudo_terminal: bool) -> serial.Serial:
    """Open a device exclusively, RTS and DTR down, no flow control, errors marked. May raise PortError."""
    try:
        device = _closed_serial(port, settings)
        if pseudo_terminal:
            # Linux strips these from a pty, and libc takes it for an error when nothing else was to change.
            device.bytesize, device.parity = 8, "N"
        device.open()
        try:
            _mark_errors(device.fileno())
            _check_speed(device.fileno(), settings.baud)
        except BaseException:
            device.close()
            raise
    except (OSError, ValueError, OverflowError, termios.error) as error:
        raise PortError(_device_trouble(port, settings, error)) from error
    return device


def _closed_serial(port: str, settings: LineSettings) -> serial.Serial:
    """Make pyserial's port, not yet open, so that RTS and DTR are known to be low before it is."""
    import serial

    device: serial.Serial = serial.serial_for_url(
        port,
        do_not_open=True,
        baudrate=settings.baud,
        bytesize=settings.data_bits,
        parity=settings.parity,
        stopbits=settings.stop_half_bits / 2,
        exclusive=True,
        timeout=_URL_TIMEOUT_S,
    )
    device.dtr = False
    device.rts = False
    return device


def _mark_errors(fd: int) -> None:
    """Let the line discipline mark errors, which pyserial has switched off, and drop what came before."""
    attributes = termios.tcgetattr(fd)
    attributes[0] |= termios.PARMRK | termios.INPCK  # INPCK: without it no framing errors either
    attributes[0] &= ~(termios.IGNPAR | termios.IGNBRK | termios.BRKINT | termios.ISTRIP)
    attributes[6][termios.VMIN] = 1  # so that a read of nothing means that the port has gone
    attributes[6][termios.VTIME] = 0
    termios.tcsetattr(fd, termios.TCSANOW, attributes)
    termios.tcflush(fd, termios.TCIFLUSH)


def _check_speed(fd: int, baud: int) -> None:
    """Raise ValueError if the driver quietly set another rate; 3 % is what a character can bear."""
    try:
        (speed,) = _TERMIOS2.unpack(fcntl.ioctl(fd, _TCGETS2, bytes(_TERMIOS2.size)))
    except OSError:
        return  # not Linux
    if abs(speed - baud) > baud * 0.03:
        raise ValueError(f"the driver set {speed} Bd")


def _device_trouble(port: str, settings: LineSettings, error: Exception) -> str:
    """Say why a device could not be opened, and what to do."""
    number = _errno(error)
    text = f"{port} cannot be opened: {error}"
    if number == errno.ENOENT:
        text = f"{port} does not exist: `sistap ports` lists the ports there are"
    elif number in (errno.ENOTTY, errno.EISDIR):
        text = f"{port} is not a serial port: `sistap ports` lists the ports there are"
    elif number in (errno.EACCES, errno.EPERM):
        text = f"no permission to open {port}: {_permission_cure(port)}"
    elif number in (errno.EBUSY, errno.EWOULDBLOCK):
        text = f"{port} is in use by another program (often ModemManager): `sudo fuser -v {port}` names it"
    elif number in (errno.ENXIO, errno.ENODEV, errno.EIO):
        text = f"there is no working hardware behind {port}: `sistap ports` lists the ports there are"
    elif isinstance(error, ValueError | OverflowError) or number == errno.EINVAL:
        text = f"{port} cannot do {settings.baud} Bd {settings.format}: choose another --baud or --format"
    return text


def _errno(error: BaseException) -> int | None:
    """Find the number of an error that pyserial may have wrapped without it."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, OSError | termios.error) and cause.args and isinstance(cause.args[0], int):
            return cause.args[0]
        cause = cause.__context__
    return None


def _permission_cure(port: str) -> str:
    try:
        status = Path(port).stat()
    except OSError:
        return "its folder is not open to you"
    if not stat.S_ISCHR(status.st_mode):
        return "it is not a serial port; `sistap ports` lists the ports there are"
    if status.st_mode & 0o060 == 0o060 and status.st_gid != 0:
        group = _group(status.st_gid)
        return f"it is for group {group}: `sudo usermod -aG {group} $USER`, then log in again"
    return f"it belongs to {_user(status.st_uid)}: run sistap as that user"


def _group(number: int) -> str:
    try:
        return grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


def _user(number: int) -> str:
    try:
        return pwd.getpwuid(number).pw_name
    except KeyError:
        return str(number)


def _latency(behind: ports.Adapter, settings: LineSettings) -> tuple[int, str]:
    """Bound the time from a character's arrival to its time stamp: ns, and a phrase that says how."""
    own = measured_latency_ns()
    if own >= UNCERTAINTY_UNKNOWN:
        return UNCERTAINTY_UNKNOWN, "uncertainty unknown: there is no pseudo terminal to measure it with"
    held, why, note = 0, "", ""
    if behind.latency_ms is not None:
        held, why = behind.latency_ms * 1_000_000, behind.latency
    elif behind.fifo_trigger is not None and behind.fifo_trigger > 1:
        held, why = (
            _FIFO_TIMEOUT_CHARACTERS * settings.character_ns,
            f"FIFO time-out {_FIFO_TIMEOUT_CHARACTERS} characters",
        )
    elif behind.fifo_trigger is None and not behind.pseudo_terminal:
        note = "; what the adapter adds is not known"
    total = min(held + own, UNCERTAINTY_UNKNOWN)
    parts = f": {why} and {_ms(own)}" if why else ""
    return total, f"uncertainty {_ms(total)}{parts}, measured when the capture started{note}"


def _ms(ns: int) -> str:
    return f"{ns / 1e6:.2f} ms"


@functools.cache
def measured_latency_ns() -> int:
    """Measure how late, at worst, this process sees a character: MEASURE_NS on a pty of its own, once in its life.

    Fewer than a thousand samples: so the bound p99.9 is the largest. UNCERTAINTY_UNKNOWN without a pty.
    """
    try:
        master, slave = pty.openpty()
    except OSError:
        return UNCERTAINTY_UNKNOWN
    try:
        tty.setraw(slave)
        written: list[int] = []
        writer = threading.Thread(target=_write_for_measuring, args=(master, written), daemon=True)
        writer.start()
        worst = _worst_delay(slave, written, writer)
        writer.join()
        return worst
    finally:
        os.close(master)
        os.close(slave)


def _write_for_measuring(master: int, written: list[int]) -> None:
    end = monotonic_ns() + MEASURE_NS
    while (now := monotonic_ns()) < end:
        written.append(now)
        os.write(master, b"\0")
        time.sleep(0.0005)


def _worst_delay(slave: int, written: list[int], writer: threading.Thread) -> int:
    """Read what the writer writes; give the largest time from write to read, in ns."""
    poll = select.poll()
    poll.register(slave, select.POLLIN)
    worst = seen = 0
    while writer.is_alive() or seen < len(written):
        if poll.poll(10):
            count = len(os.read(slave, READ_SIZE))
            worst = max(worst, monotonic_ns() - written[seen])
            seen += count
    return worst


def _lost_text(port: str, pseudo_terminal: bool) -> str:
    if pseudo_terminal:
        return f"{port}: the program at its other end has ended: start it and a new capture"
    return f"{port} is gone: plug the adapter in and start a new capture"


# -- Any port that pyserial can open ----------------------------------------------------------------------------------


class UrlReader:
    """Reads through pyserial: URLs such as socket:// and rfc2217://, and the ports of Windows. No error flags."""

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Open the port. May raise PortError."""
        self.name = port
        self.adapter = port
        self.settings = settings
        self.line = line
        over = f"{urlsplit(port).scheme}://" if "://" in port else port
        self.timing = f"times are those of arrival at this program over {over}; no bound known"
        try:
            self._device = _closed_serial(port, settings)
            self._device.open()
        except (OSError, ValueError) as error:
            raise PortError(_url_trouble(port, settings, error)) from error
        self._lost: str | None = None

    def read(self, timeout_s: float) -> Read | None:
        """Give what arrived, None if nothing did in that time. May raise PortLost."""
        end = time.monotonic() + timeout_s
        data = b""
        while not self._lost and not data and time.monotonic() <= end:
            data = self._waiting()
        if data:
            return Read(self.line, CLOCK.wall_ns(monotonic_ns()), data, bytes(len(data)))
        if self._lost:
            raise PortLost(self._lost)
        return None

    def _waiting(self) -> bytes:
        """Take one character, and all that are there with it; what came before the port was lost is kept."""
        data = b""
        try:
            data = self._device.read(1)
            while data and len(data) < READ_SIZE and (waiting := self._device.in_waiting):
                data += self._device.read(waiting)
        except OSError as error:
            self._lost = f"{self.name} is gone ({error}): connect it again and start a new capture"
        return data

    def close(self) -> None:
        """Let the port go."""
        self._device.close()


def _url_trouble(port: str, settings: LineSettings, error: Exception) -> str:
    """Say why pyserial could not open a port, and what to do."""
    import serial

    known = "bus://HOST:PORT, socket://HOST:PORT, rfc2217://HOST:PORT"
    text = f"{port} cannot be opened: {error}"
    cause = error.__context__
    if isinstance(cause, OSError) and not isinstance(cause, serial.SerialException):
        text = _connection_trouble(port, cause)
    elif "://" in port and (cause or isinstance(error, ValueError)):
        text = f"{port} is not the URL of a port: it is written {known}"
    elif "FileNotFoundError" in str(error):  # Windows
        text = f"{port} does not exist: `sistap ports` lists the ports there are"
    elif "PermissionError" in str(error):
        text = f"{port} is in use by another program: close that one first"
    elif "Cannot configure port" in str(error):
        text = f"{port} cannot do {settings.baud} Bd {settings.format}: choose another --baud or --format"
    return text


def _connection_trouble(port: str, error: OSError) -> str:
    """Say why a connection failed, and what to do."""
    if isinstance(error, ConnectionRefusedError | FileNotFoundError):
        return f"nothing listens at {port}: start the other end first"
    if isinstance(error, socket.gaierror):
        return f"{port}: no host of that name is known"
    if isinstance(error, TimeoutError):
        return f"{port} does not answer: check address and network"
    return f"{port} cannot be reached: {error.strerror or error}"


# -- The virtual bus --------------------------------------------------------------------------------------------------


class WireReader:
    """Reads the socket of a virtual bus (sistap.wire): its reads carry their own times, errors and line."""

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Connect and say the line settings. May raise PortError."""
        self.name = port
        self.adapter = f"virtual bus at {port}"
        self.timing = "times and their uncertainty are those the virtual bus says"
        self.settings = settings
        self.line = line
        try:
            self._socket = _connect(port)
            self._socket.sendall(wire.pack_settings(settings))
        except OSError as error:
            raise PortError(_connection_trouble(port, error)) from error
        self._decoder = wire.ReadDecoder()
        self._reads: deque[Read] = deque()

    def read(self, timeout_s: float) -> Read | None:
        """Give what arrived, None if nothing did in that time. May raise PortLost."""
        if not self._reads:
            self._receive(timeout_s)
        return self._reads.popleft() if self._reads else None

    def _receive(self, timeout_s: float) -> None:
        self._socket.settimeout(timeout_s)
        try:
            data = self._socket.recv(65536)
            self._reads.extend(self._decoder.feed(data))
        except (TimeoutError, BlockingIOError):
            return
        except OSError:
            data = b""
        except ValueError as error:
            raise PortLost(f"{self.name}: {error}: give the address that `sistap bus` prints") from error
        if not data:
            raise PortLost(f"the bus has ended ({self.name}): start it and a new capture")

    def close(self) -> None:
        """Leave the bus."""
        self._socket.close()


def _connect(port: str) -> socket.socket:
    """Connect to bus://HOST:PORT or bus:///SOCKET. OSError, or PortError if it is written otherwise."""
    try:
        url = urlsplit(port)
        host, number, path = url.hostname, url.port, url.path
    except ValueError:
        host, number, path = None, None, ""
    if host and number:
        return socket.create_connection((host, number), CONNECT_TIMEOUT_S)
    if host or not path:
        raise PortError(f"{port} is not the address of a bus: it is written bus://HOST:PORT or bus:///SOCKET")
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.settimeout(CONNECT_TIMEOUT_S)
    connection.connect(path)
    return connection
