# SPDX-License-Identifier: GPL-2.0-or-later
"""A partner of procedure 3964R, written from Siemens' description alone, without code of sistap.

Its line is text: say() returns what it sends, hear() takes what came. One character takes a millisecond.
"""

from __future__ import annotations

STX, ETX, DLE, NAK = 2, 3, 16, 21
ZVZ_MS, QVZ_MS, TRIES = 220, 2000, 6


class ForeignPartner:
    """It sends one block at a time, and collects those that come."""

    def __init__(self) -> None:
        self.came: list[bytes] = []
        self.errors: list[str] = []
        self.delivered = 0
        self._job: bytes | None = None
        self._tries = 0
        self._doing = "nothing"
        self._clock_ms = 0
        self._block = bytearray()
        self._out = bytearray()

    def transmit(self, data: bytes) -> None:
        assert self._job is None, "one at a time"
        self._job, self._tries = data, 0
        self._request()

    @property
    def busy(self) -> bool:
        return self._job is not None

    def say(self) -> bytes:
        said, self._out = bytes(self._out), bytearray()
        return said

    def wait(self, ms: int) -> None:
        """Let time pass in which nothing came."""
        self._clock_ms += ms
        if self._doing in ("asking", "sent") and self._clock_ms >= QVZ_MS:
            self.errors.append(f"QVZ while {self._doing}")
            self._request()
        elif self._doing == "receiving" and self._clock_ms >= ZVZ_MS:
            self.errors.append("ZVZ")
            self._say(NAK, "nothing")

    def hear(self, character: int) -> None:
        self._clock_ms = 0
        if self._doing == "receiving":
            self._collect(character)
        elif self._doing == "asking" and character == DLE:
            assert self._job is not None
            doubled = b"".join(bytes([c, c]) if c == DLE else bytes([c]) for c in self._job)
            ended = doubled + bytes([DLE, ETX])
            parity = 0
            for value in ended:
                parity ^= value
            self._out += ended + bytes([parity])
            self._doing = "sent"
        elif self._doing == "sent" and character == DLE:
            self._job, self._doing = None, "nothing"
            self.delivered += 1
        elif self._doing in ("asking", "sent"):
            self.errors.append(f"{character:02X} while {self._doing}")
            self._request()
        elif character == STX:
            self._block.clear()
            self._say(DLE, "receiving")

    def _request(self) -> None:
        self._tries += 1
        if self._tries > TRIES:
            self.errors.append("gave up")
            self._job, self._doing = None, "nothing"
            return
        self._say(STX, "asking")

    def _collect(self, character: int) -> None:
        self._block.append(character)
        raw = bytes(self._block)
        # DLE ETX ends it where no DLE before belongs to a pair.
        head, end, _ = raw[:-1], raw[-3:-1], raw[-1]
        if end != bytes([DLE, ETX]) or (len(head[:-1]) - len(head[:-1].rstrip(bytes([DLE])))) % 2 == 0:
            return
        parity = 0
        for value in raw:
            parity ^= value
        if parity:
            self.errors.append("BCC")
            self._say(NAK, "nothing")
        else:
            self.came.append(raw[:-3].replace(bytes([DLE, DLE]), bytes([DLE])))
            self._say(DLE, "nothing")

    def _say(self, character: int, then: str) -> None:
        self._out.append(character)
        self._doing, self._clock_ms = then, 0
