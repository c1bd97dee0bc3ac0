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


class _Terminal:
    """A pty, raw: nothing is echoed or translated, even before somebody configures it. May raise OSError."""

    name: str

    def __init__(self, baud: int, noise: str) -> None:
        self._ours, self._theirs = os.openpty()
        self.name = os.ttyname(self._theirs)
        tty.setraw(self._theirs)
        set_speed(self._theirs, baud)
        os.set_blocking(self._ours, False)
        self._poll = select.poll()
        self._poll.register(self._ours, 0)
        self._noise = random.Random(noise)

    def _is_open(self) -> bool:
        """Tell whether somebody has it open, if we do not."""
        return not any(event & select.POLLHUP for _, event in self._poll.poll(0))

    def _rate(self, usual: int) -> int:
        """Return the rate that somebody has set."""
        return speed(self._ours) or usual

    def _heard(self, value: int, line: LineSettings, baud: int) -> int:
        """Return what is heard of a character at another rate; parity is unknown."""
        return value if line.baud == baud else hear(value, line, line._replace(baud=baud), self._noise)[0]

    def _write(self, value: int) -> bool:
        try:
            return os.write(self._ours, bytes([value])) == 1
        except BlockingIOError:
            return False


class PseudoTerminal(_Terminal):
    """A pty whose master side plays the bus."""

    deserted = False  # a bus plays with or without listeners

    def __init__(self, pace: Pace, baud: int, seed: int = 0) -> None:
        """Open it."""
        super().__init__(baud, f"{seed} tap")
        self._pace = pace
        os.close(self._theirs)
        self._was_open = False

    def wait_for_listener(self) -> None:
        """Wait until somebody has opened it, and a little longer."""
        while not self._is_open():
            time.sleep(LOOK_S)
        self._was_open = True
        self._pace.start(SETTLE_S)

    def deliver(self, played: Played) -> list[str]:
        """Write each character at its time; marks "overrun=2" and "unheard=3" count lost characters."""
        overrun = unheard = 0
        for character in played.characters:
            self._pace.wait_until(character.time_ns)
            if not self._is_open():
                unheard += 1
                if self._was_open:
                    self._forget_unread()
                self._was_open = False
                continue
            self._was_open = True
            heard = self._heard(character.value, played.settings, self._rate(played.settings.baud))
            overrun += not self._write(heard)
        return [f"{name}={count}" for name, count in (("overrun", overrun), ("unheard", unheard)) if count]

    def close(self) -> None:
        """Close it after a silence: closing discards what a listener has not read yet."""
        if self._is_open():
            time.sleep(SETTLE_S)
        os.close(self._ours)

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


class PseudoTerminalPort(_Terminal):
    """A pty with stations. As on a wire, master and stations with different rates hear noise.

    Its other side stays open, to keep its settings between two masters.
    """

    def __init__(self, settings: LineSettings, seed: int) -> None:
        """Open it. May raise OSError."""
        super().__init__(settings.baud, f"{seed} port")
        self.settings = settings

    def wait_for_partner(self) -> None:
        """Wait until somebody else has opened it, and a little longer."""
        os.close(self._theirs)
        while not self._is_open():
            time.sleep(LOOK_S)
        self._theirs = os.open(self.name, os.O_RDWR | os.O_NOCTTY)
        time.sleep(SETTLE_S)

    def read(self, timeout_s: float) -> bytes:
        """Return what arrived; empty if nothing did in that time."""
        if not select.select([self._ours], [], [], timeout_s)[0]:
            return b""
        masters = self.settings._replace(baud=self._rate(self.settings.baud))
        return bytes(self._heard(value, masters, self.settings.baud) for value in os.read(self._ours, _READ_SIZE))

    def write(self, data: bytes) -> None:
        """Send each character at its time; as on a wire, what a master does not read is lost."""
        begun = time.monotonic()
        for place, value in enumerate(data, start=1):
            time.sleep(max(0.0, begun + place * self.settings.character_ns / 1e9 - time.monotonic()))
            if not self._write(self._heard(value, self.settings, self._rate(self.settings.baud))):
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
