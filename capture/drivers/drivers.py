# SPDX-License-Identifier: GPL-2.0-or-later
"""The drivers to judge: how each gets its ports, what happens on their lines, what the devices were told."""

from __future__ import annotations

import json
import re
import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from machine import Guest, Program, eventually

# Error bits in the line status of an FTDI adapter, as a software FT232R takes them.
OVERRUN, PARITY, FRAMING, BREAK = 0x02, 0x04, 0x08, 0x10

UART_RATE = 115200  # of divisor 1
FTDI_RATE = 3_000_000
# FTDI's AN232B-05: eighths of a divisor, keyed by their code.
FTDI_EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)
SPECIAL_DIVISORS: dict[float, float] = {0: 1, 1: 1.5}
STOPS = ("1", "1.5", "2")
PARITIES = "NOEMS"  # as FTDI and CDC number them


class Settings(NamedTuple):
    """The settings of a device."""

    baud: float
    format: str


class Line(Protocol):
    """The line behind a port."""

    port: str

    @property
    def sent(self) -> bytes:
        """Return what the guest has sent."""

    def play(self, data: bytes, errors: int = 0) -> None:
        """Send characters to the guest; `errors` apply to all of them, on a line that supports errors."""

    def settle(self) -> None:
        """Wait until the driver has taken what was played."""

    def send_break(self) -> None:
        """Send a break to the guest."""

    def loop(self, *, on: bool) -> None:
        """Return to the guest what it sends."""


class SocketLine:
    """A line that QEMU connects to a socket."""

    def __init__(self, guest: Guest, name: str, port: str) -> None:
        """Connect to it."""
        self.port = port
        self._sent = b""
        self._guest, self._name, self._loop = guest, name, False
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.connect(str(guest.folder / name))
        threading.Thread(target=self._read, daemon=True).start()

    @property
    def sent(self) -> bytes:
        """Return what the guest has sent."""
        return self._sent

    def play(self, data: bytes, errors: int = 0) -> None:
        """Send characters as fast as the guest takes them."""
        assert not errors
        self._socket.sendall(data)

    def settle(self) -> None:
        """Do nothing: this line needs no wait."""

    def send_break(self) -> None:
        """Send a break at once: it may overtake characters."""
        self._guest.monitor("chardev-send-break", id=self._name)

    def loop(self, *, on: bool) -> None:
        """Return to the guest what it sends."""
        self._loop = on

    def _read(self) -> None:
        with suppress(OSError):  # the guest was killed
            while data := self._socket.recv(4096):
                self._sent += data
                if self._loop:
                    self._socket.sendall(data)


class UartLine(SocketLine):
    """The line of a UART of QEMU. It does not store a break with its character: it marks the first one in the FIFO."""

    _due = 0

    def play(self, data: bytes, errors: int = 0) -> None:
        """Send characters after the driver has taken all earlier ones."""
        self._due = received(self._guest, self.port) + len(data)
        super().play(data, errors)

    def settle(self) -> None:
        """Wait until the driver has taken them: a break would overtake them."""
        eventually(lambda: received(self._guest, self.port) >= self._due, lambda: "the driver does not take them")


class ProgramLine:
    """A line whose other end is a program in the guest."""

    def __init__(self, program: Program, port: str, *, has_status: bool) -> None:
        """Control the program by its input; `has_status`: it supports line errors."""
        self.port, self.program = port, program
        self._has_status = has_status
        self._played = 0
        self._sent_before = b""

    @property
    def sent(self) -> bytes:
        """Return what the guest has sent."""
        told = [json.loads(line) for line in self.program.look().splitlines()]
        return self._sent_before + b"".join(bytes.fromhex(one["sent"]) for one in told if "sent" in one)

    def renew(self, program: Program) -> None:
        """Continue with another program: the adapter was unplugged and plugged in again."""
        self._sent_before, self._played = self.sent, 0
        self.program = program

    def play(self, data: bytes, errors: int = 0) -> None:
        """Send characters together; return when the computer has taken them."""
        self.say(play=[(value, errors) for value in data])
        self._played += len(data)
        self.program.until(f'{{"played": {self._played}}}')

    def settle(self) -> None:
        """Do nothing: play waits already."""

    def send_break(self) -> None:
        """Send a break; for an FTDI adapter it is a character."""
        if self._has_status:
            self.play(b"\0", BREAK | FRAMING)
        else:
            self.say(**{"break": True})

    def loop(self, *, on: bool) -> None:
        """Return to the guest what it sends."""
        self.say(loop=on)

    def say(self, **message: Any) -> None:
        """Send the program a message."""
        self.program.say(json.dumps(message))


class Watch(Protocol):
    """Observes the settings of a device."""

    def mark(self) -> None:
        """Forget earlier settings."""

    def lines(self) -> list[tuple[bool, bool]]:
        """Return the states of DTR and RTS since the mark, beginning with both low."""

    def settings(self) -> Settings | None:
        """Return its present settings."""


class UartWatch:
    """The registers of a 16550: QEMU's trace shows writes to them."""

    def __init__(self, guest: Guest) -> None:
        """Read the trace of the guest."""
        self._file = guest.folder / "trace"
        self._from = 0

    def mark(self) -> None:
        """Forget earlier writes."""
        self._from = self._file.stat().st_size

    def lines(self) -> list[tuple[bool, bool]]:
        """Return the states of DTR and RTS."""
        modem_control = [value for register, value in self._written(self._from) if register == 4]
        return _changes([(bool(value & 1), bool(value & 2)) for value in modem_control])

    def settings(self) -> Settings | None:
        """Return rate and format; the divisor is in registers 0 and 1 while bit 7 of register 3 is set."""
        control, divisor = 0, [0, 0]
        for register, value in self._written(0):
            if register == 3:
                control = value
            elif register < 2 and control & 0x80:
                divisor[register] = value
        if not any(divisor):
            return None
        parity = "NOXEXMXS"[control >> 3 & 7] if control & 8 else "N"
        stop = "2" if control & 4 else "1"
        return Settings(UART_RATE / (divisor[0] + 256 * divisor[1]), f"{5 + (control & 3)}{parity}{stop}")

    def _written(self, start: int) -> Iterator[tuple[int, int]]:
        with self._file.open() as trace:
            trace.seek(start)
            for register, value in re.findall(r"serial_write .*addr 0x(\w+) val 0x(\w+)", trace.read()):
                yield int(register, 16), int(value, 16)


class UsbWatch:
    """The requests to adapters: usbmon in the guest shows them."""

    def __init__(self, usbmon: Program) -> None:
        """Read the output of guest/usbmon.py."""
        self._usbmon = usbmon
        self._from = 0

    def mark(self) -> None:
        """Forget earlier requests."""
        self._from = len(self._usbmon.look())

    def lines(self) -> list[tuple[bool, bool]]:
        """Return the states of DTR and RTS."""
        state, states = 0, []
        for (kind, request, value, _), _data in self._requests(self._from):
            if (kind, request) == (0x40, 1):  # FTDI: the high byte selects the lines
                state = state & ~(value >> 8) | value & (value >> 8)
                states.append((bool(state & 1), bool(state & 2)))
            elif (kind, request) == (0x21, 0x22):  # CDC: SET_CONTROL_LINE_STATE
                states.append((bool(value & 1), bool(value & 2)))
        return _changes(states)

    def settings(self) -> Settings | None:
        """Return rate and format."""
        baud, text = 0.0, ""
        for (kind, request, value, index), data in self._requests(0):
            if (kind, request) == (0x40, 3):
                eighths = FTDI_EIGHTHS[value >> 14 | (index & 1) << 2]
                divisor = (value & 0x3FFF) + eighths / 8
                baud = FTDI_RATE / SPECIAL_DIVISORS.get(divisor, divisor)
            elif (kind, request) == (0x40, 4):
                text = f"{value & 0xF}{PARITIES[value >> 8 & 7]}{STOPS[value >> 11 & 3]}"
            elif (kind, request) == (0x21, 0x20):
                rate, stop, parity, bits = struct.unpack("<IBBB", data)
                baud, text = float(rate), f"{bits}{PARITIES[parity]}{STOPS[stop]}"
        return Settings(baud, text) if baud and text else None

    def _requests(self, start: int) -> Iterator[tuple[list[int], bytes]]:
        for line in self._usbmon.look()[start:].splitlines():
            message = json.loads(line)
            if "request" in message:
                yield message["request"], bytes.fromhex(message["data"])


def _changes(states: list[tuple[bool, bool]]) -> list[tuple[bool, bool]]:
    """Return each state that differs from the one before, beginning with both low."""
    changes = [(False, False)]
    for state in states:
        if state != changes[-1]:
            changes.append(state)
    return changes


@dataclass
class Driver:
    """A driver with two ports; checks that its device cannot do here are not judged."""

    name: str
    devices: tuple[str, ...]  # for QEMU
    described: tuple[str, ...]  # its description in `sistap ports`
    can: frozenset[str] = frozenset()  # "break", "errors", "overrun"
    apart: bool = True  # each port can be unplugged alone
    tuned: dict[str, tuple[object, object]] = field(default_factory=dict)  # before and during a capture
    lines: list[Any] = field(default_factory=list)

    def start(self, guest: Guest) -> None:
        """Make the ports; then `lines` has them."""

    def watch(self, guest: Guest, usbmon: Program) -> Watch:  # noqa: ARG002 - USB adapters override this
        """Return the observer of its devices."""
        return UartWatch(guest)

    def unplug(self, guest: Guest) -> None:
        """Unplug the first port."""

    def plug(self, guest: Guest) -> None:
        """Plug it in again."""


class Uart(Driver):
    """The driver 8250 with UARTs of QEMU. Unplugging removes the device from the driver."""

    def __init__(self, name: str, chardevs: tuple[str, str], device: str, bus: str, ports: tuple[str, str]) -> None:
        """Use the chardevs as ports."""
        sockets = " ".join(_socket(one) for one in chardevs)
        super().__init__(
            name,
            (*sockets.split(), *device.split()),
            ("16550A UART", "serial", "FIFO trigger 8"),
            frozenset({"break", "overrun"}),
            apart=bus == "pnp",
            tuned={"FIFO trigger": ("8", "1"), "low latency": (False, True)},
        )
        self._chardevs, self._bus, self._ports = chardevs, bus, ports

    def start(self, guest: Guest) -> None:
        """Connect to both."""
        self.lines = [UartLine(guest, *one) for one in zip(self._chardevs, self._ports, strict=True)]

    def unplug(self, guest: Guest) -> None:
        """Remove the device from the driver."""
        (link,) = guest.find(f"/sys/bus/{self._bus}/drivers/serial/{self._bound(guest)}")
        self._place = Path(link).name
        guest.write(f"/sys/bus/{self._bus}/drivers/serial/unbind", self._place)

    def plug(self, guest: Guest) -> None:
        """Give the device to the driver again."""
        guest.write(f"/sys/bus/{self._bus}/drivers/serial/bind", self._place)
        eventually(lambda: guest.run("port", self.lines[0].port).code == 0, lambda: "the port does not come back")

    def _bound(self, guest: Guest) -> str:
        done = guest.run("readlink", "-f", f"/sys/class/tty/{Path(self.lines[0].port).name}/device")
        parts = re.findall(r"[\w:.]+", done.said)
        bound = f"/sys/bus/{self._bus}/drivers/serial/"
        return str(next(part for part in reversed(parts) if guest.find(bound + part)))


class Usb(Driver):
    """A driver of adapters."""

    def watch(self, guest: Guest, usbmon: Program) -> Watch:  # noqa: ARG002 - a UART has another one
        """Return the observer of its devices."""
        return UsbWatch(usbmon)


class QemuFtdi(Usb):
    """ftdi_sio with adapters of QEMU: no line errors, and a break without a character, which Linux drops."""

    def __init__(self) -> None:
        """Create two adapters."""
        arguments = ["-device", "qemu-xhci,id=xhci"]
        for number in range(2):
            arguments += [*_socket(f"ftdi{number}").split(), "-device", ",".join(_pairs(self._device(number)))]
        # QEMU's adapter first reports a timer of 0.
        tuned: dict[str, tuple[object, object]] = {"latency timer": ("0", "1")}
        super().__init__(
            "ftdi_sio, QEMU's adapter",
            tuple(arguments),
            ("QEMU USB SERIAL", "ftdi_sio", "latency timer"),
            tuned=tuned,
        )

    def start(self, guest: Guest) -> None:
        """Connect to both."""
        self.lines = [SocketLine(guest, f"ftdi{number}", _by_id(guest, f"*FTDI{number}*")) for number in range(2)]

    def unplug(self, guest: Guest) -> None:
        """Pull it out."""
        guest.monitor("device_del", id="adapter0")
        _goes(guest, self.lines[0].port)

    def plug(self, guest: Guest) -> None:
        """Put it in again."""

        def added() -> bool:
            try:
                guest.monitor("device_add", **self._device(0))
            except OSError:  # the old one is still there
                return False
            return True

        eventually(added, lambda: "the adapter cannot be plugged in again")
        _by_id(guest, "*FTDI0*")

    @staticmethod
    def _device(number: int) -> dict[str, Any]:
        own = {"id": f"adapter{number}", "chardev": f"ftdi{number}", "serial": f"FTDI{number}", "bus": "xhci.0"}
        return {"driver": "usb-serial", "always-plugged": True} | own


class SoftwareFtdi(Usb):
    """ftdi_sio with adapters in software (guest/ft232r.py), with all line errors."""

    SERIALS = ("A6008isP", "A6008isQ")

    def __init__(self) -> None:
        """Create two adapters."""
        super().__init__(
            "ftdi_sio, FT232R in software",
            (),
            ("FT232R USB UART", "ftdi_sio", "latency timer 16 ms"),
            frozenset({"break", "errors", "overrun"}),
            tuned={"latency timer": ("16", "1")},
        )

    def start(self, guest: Guest) -> None:
        """Plug both in."""
        _module(guest, "vhci_hcd")
        self.lines = [ProgramLine(*self._plugged(guest, number), has_status=True) for number in range(2)]

    def unplug(self, guest: Guest) -> None:
        """Pull it out."""
        self.lines[0].program.kill()
        _goes(guest, self.lines[0].port)

    def plug(self, guest: Guest) -> None:
        """Put it in again."""
        self.lines[0].renew(self._plugged(guest, 0)[0])

    def _plugged(self, guest: Guest, number: int) -> tuple[Program, str]:
        program = guest.start("ft232r", str(number))
        program.until("{}")
        return program, _by_id(guest, f"*{self.SERIALS[number]}*")


class Cdc(Usb):
    """cdc_acm; its adapter with two ports is the guest itself (g_serial on dummy_hcd)."""

    def __init__(self) -> None:
        """Create an adapter."""
        super().__init__("cdc_acm", (), ("Gadget Serial", "cdc_acm"), frozenset({"break"}), apart=False)

    def start(self, guest: Guest) -> None:
        """Plug it in."""
        _module(guest, "dummy_hcd")
        self.lines = [ProgramLine(*end, has_status=False) for end in self._plugged(guest)]

    def unplug(self, guest: Guest) -> None:
        """Pull it out."""
        for line in self.lines:
            line.program.kill()
        _module(guest, "-r", "g_serial")
        for line in self.lines:
            _goes(guest, line.port)

    def plug(self, guest: Guest) -> None:
        """Put it in again."""
        for line, (program, _) in zip(self.lines, self._plugged(guest), strict=True):
            line.renew(program)

    @staticmethod
    def _plugged(guest: Guest) -> list[tuple[Program, str]]:
        """Load the adapter; return its other ends and its ports."""
        _module(guest, "g_serial", "use_acm=1", "n_ports=2")
        ends = []
        for number, interface in enumerate(("if00", "if02")):
            program = guest.start("gadget", _appears(guest, f"/dev/ttyGS{number}"))
            program.until("{}")
            ends.append((program, _by_id(guest, f"*Gadget*{interface}")))
        return ends


def received(guest: Guest, port: str) -> int:
    """Return how many characters the driver has taken from a UART."""
    rows = re.findall(r"^(\d+):.*? rx:(\d+)", guest.read("/proc/tty/driver/serial").decode(), re.MULTILINE)
    return int(dict(rows)[Path(port).name.removeprefix("ttyS")])


def _socket(name: str) -> str:
    return f"-chardev socket,id={name},path={name},server=on,wait=off"


def _pairs(device: dict[str, Any]) -> list[str]:
    driver, *others = device.items()
    return [driver[1], *(f"{key}={'on' if value is True else value}" for key, value in others)]


def _by_id(guest: Guest, pattern: str) -> str:
    """Wait for a port with this udev name; return its device."""
    return _appears(guest, f"/dev/serial/by-id/{pattern}")


def _appears(guest: Guest, pattern: str) -> str:
    """Wait for a file; return its name."""
    found: list[str] = []

    def is_there() -> bool:
        found[:] = guest.find(pattern)
        return bool(found)

    eventually(is_there, lambda: f"no {pattern}; there are {guest.find('/dev/serial/*/*')}")
    return found[0]


def _goes(guest: Guest, name: str) -> None:
    """Wait until a file is gone."""
    eventually(lambda: not guest.find(name), lambda: f"{name} stays")


def _module(guest: Guest, *words: str) -> None:
    done = guest.run("modprobe", *words)
    assert done.code == 0, done.said


def all_drivers() -> list[Driver]:
    """Return each of them."""
    isa = "-device isa-serial,chardev=isa0,index=1 -device isa-serial,chardev=isa1,index=2,irq=5"
    pci = "-chardev null,id=none2 -chardev null,id=none3 -device pci-serial-4x,chardev1=pci0,chardev2=pci1,"
    pci += "chardev3=none2,chardev4=none3"
    return [
        Uart("8250, 16550A (ISA)", ("isa0", "isa1"), isa, "pnp", ("/dev/ttyS1", "/dev/ttyS2")),
        Uart("8250, pci-serial-4x", ("pci0", "pci1"), pci, "pci", ("/dev/ttyS4", "/dev/ttyS5")),
        QemuFtdi(),
        SoftwareFtdi(),
        Cdc(),
    ]
