# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the hardware of a port pass characters on at once, as far as permitted, and restores its settings.

This does not affect the line: it changes when the driver learns of characters.
"""

from __future__ import annotations

import atexit
import fcntl
import os
import struct
import sys
import termios
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import NamedTuple

from sistap.tap.line import ports
from sistap.tap.line.reader.latency import held_by_fifo_ns
from sistap.tap.line.settings import LineSettings

if sys.platform == "win32":
    raise ImportError("Windows has none of these knobs")

# Linux, <linux/serial.h>: the first members of struct serial_struct, of which the fifth is flags; the buffer is larger
# than any system's.
_SERIAL_SIZE = 128
_FLAGS, _FLAGS_AT = struct.Struct("i"), 16
_ASYNC_LOW_LATENCY = 1 << 13

Ioctl = Callable[[int, int, bytes], bytes]


class _Knob(NamedTuple):
    """A number in sysfs that delays characters; 1 gives the smallest delay."""

    name: str
    unit: str
    file: str  # below /sys, by the name of the terminal
    late_ns: Callable[[int, LineSettings], int]  # delay of times at a given value
    for_good: str  # how to set it permanently


_UDEV_RULE = 'ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1"'

_KNOBS = (
    _Knob(
        "latency timer",
        " ms",
        "bus/usb-serial/devices/{}/latency_timer",
        lambda value, _: value * 1_000_000,
        f"for good, the udev rule {_UDEV_RULE}",
    ),
    _Knob(
        "FIFO trigger",
        "",
        "class/tty/{}/rx_trig_bytes",
        held_by_fifo_ns,
        "or run sistap with sudo",
    ),
)


class Tuning:
    """The changed settings of a port. `undo` restores them; otherwise the end of the program does."""

    def __init__(
        self,
        port: str,
        descriptor: int,
        settings: LineSettings,
        sysfs: Path | None = None,
        ioctl: Ioctl | None = None,
    ) -> None:
        """Set what can be set; never raise. `sysfs` and `ioctl` are those of Linux."""
        self.done: list[str] = []  # a phrase for each setting
        self.missed: list[str] = []  # a message for each setting: what it costs, and the cure
        self._ioctl: Ioctl = ioctl or fcntl.ioctl
        self._before = ExitStack()
        atexit.register(self.undo)
        self._set_low_latency(port, descriptor)
        terminal = Path(os.path.realpath(port)).name
        for knob in _KNOBS:
            self._turn(knob, port, (sysfs or ports.SYSFS) / knob.file.format(terminal), settings)

    def undo(self) -> None:
        """Restore everything; ignore what has gone with its port."""
        with suppress(OSError):
            self._before.close()
        atexit.unregister(self.undo)

    def _set_low_latency(self, port: str, descriptor: int) -> None:
        """Set ASYNC_LOW_LATENCY: ftdi_sio takes it as a latency timer of 1 ms, and every user may set it."""
        try:
            if self._low_latency(descriptor):
                return
            # A descriptor of its own: at the time of undo, the port's number may belong to something else.
            own = os.dup(descriptor)
            self._before.callback(os.close, own)
            self._before.callback(self._write_low_latency, own, on=False)
            self._write_low_latency(own, on=True)
            if self._low_latency(own):
                self.done.append("low latency mode")
        except PermissionError:
            self.missed.append(
                f"{port}: low latency mode is not permitted, so times may be late, depending on the driver: "
                "run sistap with sudo"
            )
        except OSError:
            return  # the driver has no such mode

    def _low_latency(self, descriptor: int) -> bool:
        state = self._ioctl(descriptor, termios.TIOCGSERIAL, bytes(_SERIAL_SIZE))
        return bool(_FLAGS.unpack_from(state, _FLAGS_AT)[0] & _ASYNC_LOW_LATENCY)

    def _write_low_latency(self, descriptor: int, *, on: bool) -> None:
        state = bytearray(self._ioctl(descriptor, termios.TIOCGSERIAL, bytes(_SERIAL_SIZE)))
        (flags,) = _FLAGS.unpack_from(state, _FLAGS_AT)
        _FLAGS.pack_into(state, _FLAGS_AT, flags & ~_ASYNC_LOW_LATENCY | (_ASYNC_LOW_LATENCY if on else 0))
        self._ioctl(descriptor, termios.TIOCSSERIAL, bytes(state))

    def _turn(self, knob: _Knob, port: str, file: Path, settings: LineSettings) -> None:
        before = ports.number(file)
        if before is None or before <= 1:
            return
        self._before.callback(_write, file, before)
        _write(file, 1)
        now = ports.number(file)
        if now != before:
            self.done.append(f"{knob.name} {before} -> {now}{knob.unit}")
        if now is not None and now > 1:
            self.missed.append(
                f"{port}: its {knob.name} stays at {now}{knob.unit}, so times are up to "
                f"{knob.late_ns(now, settings) / 1e6:.1f} ms late: `echo 1 | sudo tee {file}`; {knob.for_good}"
            )


def _write(file: Path, value: int) -> None:
    with suppress(OSError):
        file.write_text(str(value))
