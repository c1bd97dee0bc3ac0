# SPDX-License-Identifier: GPL-2.0-or-later
"""A SIS master at a terminal, from the specification alone (chapters 2, 6 and 8), without code of sistap."""

from __future__ import annotations

import os
import select
import termios
import time

ADDRESS = 20  # of this master
READ, READ_PHASE, SWITCH_PHASE, WRITE = 0x10, 0x12, 0x1D, 0x1F
DATA = 7  # element


class NoReaction(Exception):
    """Nothing came in time."""


class Client:
    """Sends commands and parses reactions; a fault in one is an AssertionError."""

    def __init__(self, terminal: str, tza_s: float, trs_s: float, twm_s: float, repeats: int) -> None:
        """Open the terminal. TwM passes before a command is repeated."""
        self._port = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
        self._silence_s = 3 * tza_s  # before a start
        self._trs_s = trs_s
        self._twm_s = twm_s
        self._repeats = repeats

    def set_rate(self, speed: int) -> None:
        """Set the rate, a constant of termios; raw, eight bits."""
        settings = [
            0,
            0,
            termios.CS8 | termios.CREAD | termios.CLOCAL,
            0,
            speed,
            speed,
            termios.tcgetattr(self._port)[6],
        ]
        termios.tcsetattr(self._port, termios.TCSADRAIN, settings)

    def close(self) -> None:
        """Close the terminal."""
        os.close(self._port)

    def send(self, service: int, receiver: int, body: bytes, route: bytes = b"", number: int | None = None) -> bytes:
        """Send a command; return its first eight bytes, and what a reaction must repeat of the rest."""
        control = len(route) | (0x08 if number is not None else 0)
        rest = route + (bytes([number]) if number is not None else b"")
        length = len(rest) + len(body)
        telegram = bytearray([0x02, 0, length, length, control, service, ADDRESS, receiver]) + rest + body
        telegram[1] = -sum(telegram) & 0xFF
        time.sleep(self._silence_s)
        assert os.write(self._port, telegram) == len(telegram)
        return bytes([control | 0x10, service, ADDRESS, receiver]) + rest

    def tell(self, service: int, receiver: int, body: bytes) -> None:
        """Send a command for several stations; nobody answers, and the next command waits until they could have
        (chapter 10.3).
        """
        self.send(service, receiver, body)
        time.sleep(self._trs_s)

    def ask(self, service: int, receiver: int, body: bytes, route: bytes = b"", number: int | None = None) -> bytes:
        """Send a command, again if nothing comes; return the body of the reaction."""
        expected = self.send(service, receiver, body, route, number)
        repeats = self._repeats
        while not select.select([self._port], [], [], self._twm_s)[0]:
            if not repeats:
                raise NoReaction
            repeats -= 1
            self.send(service, receiver, body, route, number)
        head = self._take(8)
        telegram = head + self._take(head[3])
        assert head[0] == 0x02 and head[2] == head[3] and sum(telegram) & 0xFF == 0, telegram.hex(" ")
        assert telegram[4 : 4 + len(expected)] == expected, telegram.hex(" ")
        return telegram[4 + len(expected) :]

    def _take(self, count: int) -> bytes:
        taken = b""
        while len(taken) < count:
            assert select.select([self._port], [], [], self._twm_s)[0], taken.hex(" ")
            taken += os.read(self._port, count - len(taken))
        return taken


def parameter(number: int, device: int, element: int = DATA, last: bool = True) -> bytes:
    """Return the useful data header for a parameter of a drive; bit 15 of the number selects S or P."""
    return bytes([element << 3 | last << 2, device, 0, number & 0xFF, number >> 8])
