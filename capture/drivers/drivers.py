# SPDX-License-Identifier: GPL-2.0-or-later
"""The drivers to judge: how each gets its ports, what happens on their lines, what the devices were told."""

from __future__ import annotations

import json
import re
import socket
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

sys.path.insert(0, str(Path(__file__).parent / "guest"))

from chips import CHIPS, Ft232r
from machine import Guest, Program, eventually
from truth import BREAK, FRAMING, Character

from sistap.tap.line.drivers import UART, driver
from sistap.tap.line.drivers import Driver as Telling

UART_RATE = 115200  # of divisor 1
ALL = frozenset({"list", "unplug", "loop"})  # what nearly every line can do


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
        """Send characters to the guest; `errors`, a line status, apply to all of them, on a line that supports them."""

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

    def __init__(self, program: Program, port: str) -> None:
        """Control the program by its input."""
        self.port, self.program = port, program
        self._played = 0
        self._sent_before = b""

    @property
    def sent(self) -> bytes:
        """Return what the guest has sent."""
        return self._sent_before + b"".join(bytes.fromhex(one["sent"]) for one in self.messages() if "sent" in one)

    def messages(self, start: int = 0) -> list[dict[str, Any]]:
        """Return what the program has said, from that line of its output on."""
        return [json.loads(line) for line in self.program.lines()[start:]]

    def renew(self, program: Program) -> None:
        """Continue with another program: the adapter was unplugged and plugged in again."""
        self._sent_before, self._played = self.sent, 0
        self.program = program

    def play(self, data: bytes, errors: int = 0) -> None:
        """Send characters together; return when the computer has taken them."""
        self.play_characters([(value, errors) for value in data])

    def play_characters(self, characters: Sequence[Character]) -> None:
        """Send characters, each with its line status."""
        self.say(play=characters)
        self._played += len(characters)
        self.program.until(f'{{"played": {self._played}}}')

    def settle(self) -> None:
        """Do nothing: play waits already."""

    def send_break(self) -> None:
        """Send a break."""
        self.play(b"\0", BREAK | FRAMING)

    def loop(self, *, on: bool) -> None:
        """Return to the guest what it sends."""
        self.say(loop=on)

    def say(self, **message: Any) -> None:
        """Send the program a message."""
        self.program.say(json.dumps(message))


class GadgetLine(ProgramLine):
    """The line of the adapter that is the guest itself: it supports no line errors."""

    def send_break(self) -> None:
        """Send a break, which is no character."""
        self.say(**{"break": True})


class State(NamedTuple):
    """A state of DTR and RTS."""

    dtr: bool
    rts: bool
    ns: int = 0  # when it began, by some clock
    sets: bool = False  # rate or format were set in it


class Watch(Protocol):
    """Observes the settings of a device."""

    def mark(self) -> None:
        """Forget earlier settings."""

    def lines(self) -> list[State]:
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

    def lines(self) -> list[State]:
        """Return the states of DTR and RTS."""
        told: list[tuple[int, dict[str, Any]]] = []
        for ns, register, value in self._written(self._from):
            if register == 4:
                told.append((ns, {"dtr": bool(value & 1), "rts": bool(value & 2)}))
            elif register == 3:
                told.append((ns, {"format": value}))
        return _states(told)

    def settings(self) -> Settings | None:
        """Return rate and format; the divisor is in registers 0 and 1 while bit 7 of register 3 is set."""
        control, divisor = 0, [0, 0]
        for _, register, value in self._written(0):
            if register == 3:
                control = value
            elif register < 2 and control & 0x80:
                divisor[register] = value
        if not any(divisor):
            return None
        parity = "NOXEXMXS"[control >> 3 & 7] if control & 8 else "N"
        stop = "2" if control & 4 else "1"
        return Settings(UART_RATE / (divisor[0] + 256 * divisor[1]), f"{5 + (control & 3)}{parity}{stop}")

    def _written(self, start: int) -> Iterator[tuple[int, int, int]]:
        """Yield time, register and value."""
        with self._file.open() as trace:
            trace.seek(start)
            for seconds, register, value in re.findall(
                r"@([\d.]+):serial_write .*addr 0x(\w+) val 0x(\w+)", trace.read()
            ):
                yield round(float(seconds) * 1e9), int(register, 16), int(value, 16)


class ToldWatch:
    """An adapter in software, or a UART of a module: its program says what the driver has set."""

    def __init__(self, line: ProgramLine) -> None:
        """Read its output."""
        self._line = line
        self._from = 0

    def mark(self) -> None:
        """Forget earlier settings."""
        self._from = len(self._line.program.lines())

    def lines(self) -> list[State]:
        """Return the states of DTR and RTS."""
        return _states([(one["ns"], one["told"]) for one in self._line.messages(self._from) if "told" in one])

    def settings(self) -> Settings | None:
        """Return rate and format."""
        told: dict[str, Any] = {}
        for one in self._line.messages():
            told |= one.get("told", {})
        return Settings(told["baud"], told["format"]) if {"baud", "format"} <= told.keys() else None


class UsbWatch:
    """The requests to QEMU's FTDI adapter: usbmon in the guest shows them, the chip in software understands them."""

    def __init__(self, usbmon: Program) -> None:
        """Read the output of guest/usbmon.py."""
        self._usbmon = usbmon
        self._from = 0

    def mark(self) -> None:
        """Forget earlier requests."""
        self._from = len(self._usbmon.lines())

    def lines(self) -> list[State]:
        """Return the states of DTR and RTS."""
        return _states(list(self._told(self._from)))

    def settings(self) -> Settings | None:
        """Return rate and format."""
        told: dict[str, Any] = {}
        for _, one in self._told(0):
            told |= one
        return Settings(told["baud"], told["format"]) if {"baud", "format"} <= told.keys() else None

    def _told(self, start: int) -> Iterator[tuple[int, dict[str, Any]]]:
        told: list[dict[str, Any]] = []
        chip = Ft232r(lambda **settings: told.append(settings))
        for line in self._usbmon.lines()[start:]:
            message = json.loads(line)
            if "request" in message:
                kind, request, value, index = message["request"]
                chip.control(kind, request, value, index, bytes.fromhex(message["data"]))
                while told:
                    yield message["ns"], told.pop()


def _states(told: Sequence[tuple[int, dict[str, Any]]]) -> list[State]:
    """Return each state of the lines that differs from the one before, beginning with both low."""
    states = [State(False, False)]
    for ns, settings in told:
        now = states[-1]
        dtr, rts = settings.get("dtr", now.dtr), settings.get("rts", now.rts)
        if (dtr, rts) != (now.dtr, now.rts):
            states.append(State(dtr, rts, ns))
        elif settings.keys() & {"baud", "format"}:
            states[-1] = now._replace(sets=True)
    return states


@dataclass
class Driver:
    """A driver with two ports; checks that its device cannot do here are not judged."""

    name: str
    devices: tuple[str, ...]  # for QEMU
    described: tuple[str, ...]  # its description in `sistap ports`
    tells: Telling  # what the driver can say of line errors
    can: frozenset[str] = ALL  # also "break", "errors", "overrun"
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

    def end(self, guest: Guest) -> None:
        """Make room for other drivers."""


class Uart(Driver):
    """The driver 8250 with UARTs of QEMU. Unplugging removes the device from the driver."""

    def __init__(self, name: str, chardevs: tuple[str, str], device: str, bus: str, ports: tuple[str, str]) -> None:
        """Use the chardevs as ports."""
        sockets = " ".join(_socket(one) for one in chardevs)
        super().__init__(
            name,
            (*sockets.split(), *device.split()),
            ("16550A UART", "serial", "FIFO trigger 8"),
            UART,
            ALL | {"break", "overrun"},
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
            driver("ftdi_sio"),
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


class Software(Usb):
    """A driver with two adapters in software (guest/adapter.py), with all line errors."""

    def __init__(self, name: str, chip: str, latency: str = "", **more: Any) -> None:
        """Create two adapters with a chip of guest/chips.py. Before the comma, the name is the driver's in sysfs."""
        sysfs = name.partition(",")[0]
        tells = driver(sysfs)
        described = (CHIPS[chip].product, sysfs, latency, tells.place.value)
        super().__init__(name, (), described, tells, ALL | {"break", "errors", "overrun"}, **more)
        self._chip, self._module = chip, sysfs.partition("-")[0]

    def start(self, guest: Guest) -> None:
        """Plug both in."""
        _module(guest, "vhci_hcd")
        _module(guest, self._module)
        self.lines = [ProgramLine(*self._plugged(guest, number)) for number in range(2)]

    def watch(self, guest: Guest, usbmon: Program) -> Watch:  # noqa: ARG002 - QEMU's adapter needs it
        """Return the observer of the first adapter."""
        return ToldWatch(self.lines[0])

    def unplug(self, guest: Guest) -> None:
        """Pull it out."""
        self.lines[0].program.kill()
        _goes(guest, self.lines[0].port)

    def plug(self, guest: Guest) -> None:
        """Put it in again."""
        self.lines[0].renew(self._plugged(guest, 0)[0])

    def end(self, guest: Guest) -> None:
        """Pull both out: the next driver has the same ports of the controller."""
        for line in self.lines:
            line.program.kill()
            _goes(guest, line.port)

    def _plugged(self, guest: Guest, number: int) -> tuple[Program, str]:
        serial = f"{self._chip}{number}"
        program = guest.start("adapter", self._chip, str(number), serial)
        program.until("{}")
        return program, _by_id(guest, f"*{serial}*")


class ModuleUart(Driver):
    """8250 with the UART of guest/uart.c: QEMU's has no line errors, and a break has no place in its FIFO.

    pyserial does not list a port on the platform bus.
    """

    def __init__(self) -> None:
        """Create it."""
        super().__init__(
            "8250, errors in the FIFO",
            (),
            ("16550A UART", "FIFO trigger 8", UART.place.value),
            UART,
            frozenset({"break", "errors", "overrun"}),
            tuned={"FIFO trigger": ("8", "1"), "low latency": (False, True)},
        )

    def start(self, guest: Guest) -> None:
        """Load the module."""
        before = set(guest.find("/sys/class/tty/ttyS*/type"))
        known = {name for name in before if guest.read(name).strip() != b"0"}
        done = guest.run("insmod", "/guest/uart.ko")
        assert done.code == 0, f"no module of this kernel (it needs gcc and make): {done.said}"
        found = [name for name in before - known if guest.read(name).strip() != b"0"]
        assert found, "the driver 8250 does not take the UART"
        program = guest.start("uart")
        program.until("{}")
        self.lines = [ProgramLine(program, f"/dev/{Path(found[0]).parent.name}")]

    def watch(self, guest: Guest, usbmon: Program) -> Watch:  # noqa: ARG002 - QEMU's adapter needs it
        """Return the observer of the UART."""
        return ToldWatch(self.lines[0])


class Cdc(Usb):
    """cdc_acm; its adapter with two ports is the guest itself (g_serial on dummy_hcd). For record.py."""

    def __init__(self) -> None:
        """Create an adapter."""
        super().__init__("cdc_acm", (), ("Gadget Serial", "cdc_acm"), driver("cdc_acm"), apart=False)

    def start(self, guest: Guest) -> None:
        """Plug it in."""
        _module(guest, "dummy_hcd")
        self.lines = [GadgetLine(*end) for end in self._plugged(guest)]

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
    timer = {"latency timer": ("16", "1")}
    return [
        Uart("8250, 16550A (ISA)", ("isa0", "isa1"), isa, "pnp", ("/dev/ttyS1", "/dev/ttyS2")),
        Uart("8250, pci-serial-4x", ("pci0", "pci1"), pci, "pci", ("/dev/ttyS4", "/dev/ttyS5")),
        ModuleUart(),
        QemuFtdi(),
        Software("ftdi_sio, FT232R", "ft232r", "latency timer 16 ms", tuned=timer),
        Software("cp210x, CP2102", "cp2102"),
        Software("ch341-uart, CH340", "ch340"),
        Software("pl2303, PL2303", "pl2303"),
        Software("cdc_acm, CDC", "cdc"),
    ]
