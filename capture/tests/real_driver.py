# SPDX-License-Identifier: GPL-2.0-or-later
"""A pseudo terminal that poses as a real port, with a driver that supports formats."""

from __future__ import annotations

import termios
from collections.abc import Callable

import pytest

from sistap.tap.line import ports


class Driver:
    """The driver of a real port instead of a pseudo terminal's, which supports no format."""

    def __init__(
        self, monkeypatch: pytest.MonkeyPatch, size: int | None = None, name: str = "CP2102", driver: str = "cp210x"
    ) -> None:
        """`size` is the only number of data bits that it accepts; it silently ignores others."""
        monkeypatch.setattr(ports, "adapter", lambda port: ports.Adapter(name, driver))
        monkeypatch.setattr(termios, "TIOCEXCL", termios.TIOCNXCL)  # a pseudo terminal would stay claimed
        monkeypatch.setattr(termios, "tcsetattr", self._set)
        monkeypatch.setattr(termios, "tcgetattr", self._get)
        self.asked: list[list[int]] = []
        self._size = size

    def _set(self, fd: int, when: int, attributes: list[int], real: Callable[..., None] = termios.tcsetattr) -> None:
        assert when == termios.TCSANOW  # the others wait for output or drop input
        self.asked.append(attributes.copy())
        plain = attributes[2] & ~(termios.CSIZE | termios.PARENB) | termios.CS8
        real(fd, when, [*attributes[:2], plain, *attributes[3:]])

    def _get(self, fd: int, real: Callable[[int], list[int]] = termios.tcgetattr) -> list[int]:
        attributes = real(fd)
        if self.asked:
            attributes[2] = self.asked[-1][2]
        if self._size is not None:
            attributes[2] = attributes[2] & ~termios.CSIZE | self._size
        return attributes
