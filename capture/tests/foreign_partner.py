# SPDX-License-Identifier: GPL-2.0-or-later
"""A partner of procedure 3964R, written from Siemens' description alone, without code of sistap.

say() returns what it sends, hear() takes what came, wait() lets time pass. A Commander sends commands. A Servant
reacts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

STX, ETX, DLE, NAK = 2, 3, 16, 21
ZVZ_MS, QVZ_MS, BWT_MS, TRIES = 220, 2000, 4000, 6
REACTION_MS = 5000


def block_of(data: bytes) -> bytes:
    """Return data as a block on the line."""
    doubled = b"".join(bytes([c, c]) if c == DLE else bytes([c]) for c in data)
    parity = 0
    for value in (ended := doubled + bytes([DLE, ETX])):
        parity ^= value
    return ended + bytes([parity])


class Receiver:
    """Collects one block."""

    def __init__(self) -> None:
        self.data = bytearray()
        self._parity = 0
        self._state = "data"

    def take(self, character: int) -> bool | None:
        """Take a character; return at the end whether the block is good."""
        if self._state == "parity":
            return character == self._parity
        self._parity ^= character
        if self._state == "data" and character == DLE:
            self._state = "single"
        elif self._state == "single" and character == ETX:
            self._state = "parity"
        elif self._state == "single" and character != DLE:
            self._state = "lost"  # nobody knows the end: silence shows it
        elif self._state != "lost":
            self._state = "data"
            self.data.append(character)
        return None


class ForeignPartner:
    """It sends one block at a time, and collects those that come."""

    def __init__(self, *, high: bool = True) -> None:
        """If both ask, low priority gives way."""
        self.came: list[bytes] = []
        self.errors: list[str] = []
        self.delivered: bool | None = None  # the last job; False: given up
        self._high = high
        self._job: bytes | None = None
        self._asked = self._sent = 0  # tries
        self._doing = "nothing"
        self._clock_ms = 0.0  # since something was said or heard
        self._receiver = Receiver()
        self._out = bytearray()

    def transmit(self, data: bytes) -> None:
        assert self._job is None, "one at a time"
        self._take_job(data)
        self.wait(0)

    @property
    def busy(self) -> bool:
        return self._job is not None

    def say(self) -> bytes:
        said, self._out = bytes(self._out), bytearray()
        return said

    def wait(self, ms: float) -> None:
        """Let time pass in which nothing came."""
        self._clock_ms += ms
        if self._doing in ("asking", "sent") and self._clock_ms >= QVZ_MS:
            self._again(f"QVZ while {self._doing}")
        elif self._doing == "receiving" and self._clock_ms >= ZVZ_MS:
            self._refuse("ZVZ")
        elif self._doing == "refused" and self._clock_ms >= BWT_MS:
            self._doing = "nothing"
        if self._doing == "nothing":
            self._rest()

    def hear(self, character: int) -> None:
        self._clock_ms = 0
        if self._doing == "receiving":
            self._collect(character)
        elif self._doing == "asking":
            self._hear_grant(character)
        elif self._doing == "sent" and character == DLE:
            self._end_job(delivered=True)
        elif self._doing == "sent":
            self._again(f"{character:02X} while sent")
        elif character == STX:
            self._grant()

    def _take_job(self, data: bytes) -> None:
        self._job, self.delivered, self._asked, self._sent = data, None, 0, 0

    def _end_job(self, *, delivered: bool) -> None:
        self._job, self.delivered, self._doing = None, delivered, "nothing"

    def _rest(self) -> None:
        """Neither sends nor receives."""
        if self._job is not None:
            self._request()

    def _request(self) -> None:
        self._asked += 1
        if self._asked > TRIES or self._sent >= TRIES:
            self._end_job(delivered=False)
        else:
            self._say(STX, "asking")

    def _again(self, error: str) -> None:
        self.errors.append(error)
        self._request()

    def _hear_grant(self, character: int) -> None:
        if character == DLE:
            assert self._job is not None
            self._asked, self._sent = 0, self._sent + 1
            self._out += block_of(self._job)
            self._doing = "sent"
        elif character != STX:
            self._again(f"{character:02X} while asking")
        elif not self._high:
            self._asked = 0
            self._grant()

    def _grant(self) -> None:
        self._receiver = Receiver()
        self._say(DLE, "receiving")

    def _collect(self, character: int) -> None:
        good = self._receiver.take(character)
        if good:
            self.came.append(bytes(self._receiver.data))
            self._say(DLE, "nothing")
        elif good is False:
            self._refuse("BCC")

    def _refuse(self, error: str) -> None:
        self.errors.append(error)
        self._say(NAK, "refused")

    def _say(self, character: int, then: str) -> None:
        self._out.append(character)
        self._doing, self._clock_ms = then, 0


class Commander(ForeignPartner):
    """It sends one command after the other, and waits for the reaction to each."""

    def __init__(self, commands: Iterable[bytes], *, high: bool = True) -> None:
        super().__init__(high=high)
        self.outcomes: list[bytes | None] = []  # the reaction to each command; None: given up
        self._commands = iter(commands)
        self._command: bytes | None = next(self._commands)
        self._take_job(self._command)
        self._seen = 0
        self._rested_ms = 0.0

    @property
    def over(self) -> bool:
        return self._command is None

    def wait(self, ms: float) -> None:
        self._rested_ms = self._rested_ms + ms if self._doing == "nothing" and not self.busy else 0
        super().wait(ms)

    def _rest(self) -> None:
        new, self._seen = self.came[self._seen :], len(self.came)
        if self.delivered and new:  # while its command is not acknowledged, a reaction is an old one
            self._go_on(new[-1])
        elif self.delivered is False or (self.delivered and self._rested_ms >= REACTION_MS):
            self._go_on(None)
        super()._rest()

    def _go_on(self, reaction: bytes | None) -> None:
        self.outcomes.append(reaction)
        self.delivered = None
        self._command = next(self._commands, None)
        if self._command is not None:
            self._take_job(self._command)


class Servant(ForeignPartner):
    """It reacts to each block."""

    def __init__(self, reaction: Callable[[bytes], bytes], *, high: bool = False) -> None:
        super().__init__(high=high)
        self._reaction = reaction
        self._seen = 0

    def _rest(self) -> None:
        if len(self.came) > self._seen:  # a reaction that is still to be sent is no longer wanted
            self._seen = len(self.came)
            self._take_job(self._reaction(self.came[-1]))
        super()._rest()
