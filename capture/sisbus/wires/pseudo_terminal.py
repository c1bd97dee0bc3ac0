# SPDX-License-Identifier: GPL-2.0-or-later
"""The bus at a pseudo terminal: real time and a real tty, but no parity and no breaks, which a pty cannot carry.

As on a wire, a character without a listener is lost. So is one that does not fit into the buffer of a listener that
does not read.
"""

from __future__ import annotations

import os
import random
import select
import sys
import termios
import time
import tty

from sisbus.playing.characters import Played, hear
from sisbus.wires.wire import Pace
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.rates import RATES

if sys.platform == "win32":
    raise ImportError("Windows has no pseudo terminals")

SETTLE_S = 0.5  # time for a listener to open, configure and flush the port
LOOK_S = 0.02
_RATES = {getattr(termios, f"B{baud}"): baud for baud in RATES}


class PseudoTerminal:
    """A pty whose master side plays the bus."""

    deserted = False  # a bus plays with or without listeners

    def __init__(self, pace: Pace, baud: int, seed: int = 0) -> None:
        """Open it raw: nothing is echoed or translated, even before a listener configures it."""
        self._pace = pace
        self._master, slave = os.openpty()
        self.name = os.ttyname(slave)
        tty.setraw(slave)
        set_speed(slave, baud)
        os.close(slave)  # from now on POLLHUP means that nobody has it open
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, 0)
        self._heard = False
        self._noise = random.Random(f"{seed} tap")

    def wait_for_listener(self) -> None:
        """Wait until somebody has opened it, and a little longer."""
        while not self._listening():
            time.sleep(LOOK_S)
        self._heard = True
        self._pace.start(SETTLE_S)

    def deliver(self, played: Played) -> list[str]:
        """Write each character at its time; marks "overrun=2" and "unheard=3" count lost characters."""
        overrun = unheard = 0
        for character in played.characters:
            self._pace.wait_until(character.time_ns)
            if not self._listening():
                unheard += 1
                if self._heard:
                    self._forget_unread()
                self._heard = False
                continue
            self._heard = True
            overrun += not self._write(self._hear(character.value, played.settings))
        return [f"{name}={count}" for name, count in (("overrun", overrun), ("unheard", unheard)) if count]

    def close(self) -> None:
        """Close it after a silence: closing discards what a listener has not read yet."""
        if self._listening():
            time.sleep(SETTLE_S)
        os.close(self._master)

    def _hear(self, value: int, line: LineSettings) -> int:
        """Return what a listener with another rate hears of a character; its parity setting is unknown."""
        rate = speed(self._master)
        if rate is None or rate == line.baud:
            return value
        return hear(value, line, line._replace(baud=rate), self._noise)[0]

    def _write(self, value: int) -> bool:
        try:
            return os.write(self._master, bytes([value])) == 1
        except BlockingIOError:
            return False

    def _listening(self) -> bool:
        return not any(event & select.POLLHUP for _, event in self._poll.poll(0))

    def _forget_unread(self) -> None:
        """Discard what the listener left in the buffer: the next one must hear the bus as it is then."""
        try:
            slave = os.open(self.name, os.O_RDWR | os.O_NOCTTY)
        except OSError:  # the next listener has it already
            return
        termios.tcflush(slave, termios.TCIFLUSH)
        os.close(slave)


def set_speed(slave: int, baud: int) -> None:
    """Set the rate if the terminal supports it: to the pty it is only a note."""
    speed = getattr(termios, f"B{baud}", None)
    if speed is not None:
        attributes = termios.tcgetattr(slave)
        attributes[4] = attributes[5] = speed
        termios.tcsetattr(slave, termios.TCSANOW, attributes)


def speed(terminal: int) -> int | None:
    """Return the rate that the listener has set; None if it is not in RATES."""
    return _RATES.get(termios.tcgetattr(terminal)[4])


# -- Opened by a real master instead of a port -----------------------------------------------------------------------

_READ_SIZE = 4096


class PseudoTerminalPort:
    """A pty with stations. As on a wire, master and stations with different rates hear noise."""

    name: str

    def __init__(self, settings: LineSettings, seed: int) -> None:
        """Open it raw. May raise OSError."""
        self.settings = settings
        self._noise = random.Random(f"{seed} port")
        self._ours, self._theirs = os.openpty()  # theirs stays open, to keep its settings between two masters
        self.name = os.ttyname(self._theirs)
        tty.setraw(self._theirs)
        set_speed(self._theirs, settings.baud)
        os.set_blocking(self._ours, False)

    def wait_for_partner(self) -> None:
        """Wait until somebody else has opened it, and a little longer."""
        os.close(self._theirs)
        poll = select.poll()
        poll.register(self._ours, 0)
        while any(event & select.POLLHUP for _, event in poll.poll(0)):
            time.sleep(LOOK_S)
        self._theirs = os.open(self.name, os.O_RDWR | os.O_NOCTTY)
        time.sleep(SETTLE_S)

    def read(self, timeout_s: float) -> bytes:
        """Return what arrived; empty if nothing did in that time."""
        if not select.select([self._ours], [], [], timeout_s)[0]:
            return b""
        masters = self._masters
        return bytes(self._heard(value, masters, self.settings) for value in os.read(self._ours, _READ_SIZE))

    def write(self, data: bytes) -> None:
        """Send each character at its time; as on a wire, what a master does not read is lost."""
        begun = time.monotonic()
        for place, value in enumerate(data, start=1):
            time.sleep(max(0.0, begun + place * self.settings.character_ns / 1e9 - time.monotonic()))
            try:
                os.write(self._ours, bytes([self._heard(value, self.settings, self._masters)]))
            except BlockingIOError:
                return

    def drain(self) -> None:
        """Do nothing: all was sent."""

    def change(self, settings: LineSettings) -> None:
        """Continue at another rate."""
        self.settings = settings

    def close(self) -> None:
        """Disconnect the master."""
        os.close(self._theirs)
        os.close(self._ours)

    @property
    def _masters(self) -> LineSettings:
        """Return the settings with which the master has it open; its parity is unknown."""
        return self.settings._replace(baud=speed(self._ours) or self.settings.baud)

    def _heard(self, value: int, line: LineSettings, other: LineSettings) -> int:
        return value if line.baud == other.baud else hear(value, line, other, self._noise)[0]
