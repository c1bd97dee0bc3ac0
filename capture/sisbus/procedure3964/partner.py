# SPDX-License-Identifier: GPL-2.0-or-later
"""One partner of procedure 3964R: takes each character and the time, and returns what to send.

The times are those of Siemens' controls. A fault (Disturb) changes what a partner sends, so that the other one handles
it by the procedure alone.
"""

from __future__ import annotations

import enum
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from sistap.tap.records.framer_3964r import DLE, ETX, NAK, STX, check_character

MS = 1_000_000
ZVZ_NS = 220 * MS  # between two characters
QVZ_NS = 2000 * MS  # for an answer
BWT_NS = 4000 * MS  # for a block to be sent again
ATTEMPTS = 6  # to be granted, and to be acknowledged


class Saying(NamedTuple):
    """What a partner sends at once."""

    said: bytes  # what reaches the line
    marks: tuple[str, ...] = ()
    delay_ns: int = 0  # extra delay; until it is sent, the partner is not heard


class Occasion(enum.Enum):
    """What is sent."""

    ASK = "ask"
    GRANT = "grant"
    BLOCK = "block"
    ACKNOWLEDGE = "acknowledge"


class Trouble(NamedTuple):
    """A fault in it; `number` is a time in ns, or where a block breaks off."""

    kind: str
    number: int = 0


Disturb = Callable[[Occasion], Trouble | None]


class State(enum.Enum):
    """What a partner waits for, and how long."""

    IDLE = 0
    ASKED = 1
    SENT = 2
    RECEIVING = 3
    REFUSING = 4  # until the line is silent
    REFUSED = 5  # the block will be sent again


_LIMITS_NS = {
    State.ASKED: QVZ_NS,
    State.SENT: QVZ_NS,
    State.RECEIVING: ZVZ_NS,
    State.REFUSING: ZVZ_NS,
    State.REFUSED: BWT_NS,
}


def packed(data: bytes) -> bytes:
    """Return a block: each DLE doubled, then DLE, ETX, BCC."""
    block = data.replace(bytes([DLE]), bytes([DLE, DLE])) + bytes([DLE, ETX])
    return block + bytes([check_character(block)])


class Partner:
    """One side. Queues hold what it has received, and whether its blocks were acknowledged."""

    def __init__(self, *, high: bool, disturb: Disturb = lambda occasion: None) -> None:
        """Begin idle. If both request, the one of low priority gives way."""
        self.received: deque[bytes] = deque()
        self.outcomes: deque[bool] = deque()
        self._high = high
        self._disturb = disturb
        self._state = State.IDLE
        self._to_send: bytes | None = None
        self._ready_ns = 0  # it does not request earlier
        self._since_ns = 0  # start of the present wait
        self._asked = self._sent = 0  # attempts
        self._expect()

    # -- What it is told ------------------------------------------------------------------------------------------

    def send(self, data: bytes, ready_ns: int) -> None:
        """Send a block as soon as possible, replacing one that has not been sent."""
        self._to_send, self._ready_ns = data, ready_ns
        self._asked = self._sent = 0

    def drop(self) -> None:
        """Send nothing."""
        self._to_send = None

    def said(self, end_ns: int) -> None:
        """Note when everything was sent: the next wait begins there."""
        self._since_ns = end_ns

    @property
    def due_ns(self) -> int | None:
        """Return when to call look again; None: only a character matters."""
        if self._state == State.IDLE:
            return None if self._to_send is None else self._ready_ns
        return self._since_ns + _LIMITS_NS[self._state]

    def hear(self, value: int, now_ns: int) -> Saying | None:
        """Take a character."""
        self._since_ns = now_ns
        if self._state == State.RECEIVING:
            return self._take(value)
        if self._state == State.ASKED:
            return self._take_grant(value)
        if self._state == State.SENT:
            return self._done(good=True) if value == DLE else self._again()
        return self._grant() if value == STX and self._state != State.REFUSING else None

    def look(self, now_ns: int) -> Saying | None:
        """Act on what is due."""
        due_ns = self.due_ns
        if due_ns is None or now_ns < due_ns:
            return None
        if self._state in (State.RECEIVING, State.REFUSING):
            return self._refuse()
        if self._state == State.REFUSED:
            self._state = State.IDLE
            return None
        return self._again() if self._state == State.SENT else self.ask()

    # -- The sender -----------------------------------------------------------------------------------------------

    def ask(self) -> Saying | None:
        """Request, unless all attempts failed."""
        self._asked += 1
        if self._to_send is None or self._asked > ATTEMPTS:
            return self._done(good=False)
        self._state = State.ASKED
        trouble = self._disturb(Occasion.ASK)
        return Saying(bytes([STX]), (trouble.kind,) if trouble else ())

    def _take_grant(self, value: int) -> Saying | None:
        if value == STX:
            return None if self._high else self._grant()
        if value != DLE or self._to_send is None:
            return self.ask()
        self._asked = 0
        self._sent += 1
        self._state = State.SENT
        block = packed(self._to_send)
        trouble = self._disturb(Occasion.BLOCK)
        if trouble and trouble.kind == "broken":
            return Saying(block[: trouble.number], (f"broken@{trouble.number}",))
        if trouble:
            return Saying(block[:-1] + bytes([block[-1] ^ 0xFF]), (trouble.kind,))
        return Saying(block)

    def _again(self) -> Saying | None:
        """Request again, because the block was not acknowledged."""
        return self.ask() if self._sent < ATTEMPTS else self._done(good=False)

    def _done(self, *, good: bool) -> Saying | None:
        """Note the outcome; nothing is sent."""
        if self._to_send is not None:
            self.outcomes.append(good)
        self._to_send = None
        self._asked = self._sent = 0
        self._state = State.IDLE
        return None

    # -- The receiver ---------------------------------------------------------------------------------------------

    def _expect(self) -> None:
        self._data = bytearray()
        self._sum = 0
        self._escaped = self._closing = False

    def _grant(self) -> Saying | None:
        self._state = State.IDLE
        self._asked = 0  # the side that gave way starts again
        trouble = self._disturb(Occasion.GRANT)
        if trouble and trouble.kind == "unheard":
            return None
        if trouble and trouble.kind == "refused":
            return Saying(bytes([NAK]), (trouble.kind,))
        self._state = State.RECEIVING
        self._expect()
        return _answer(DLE, trouble)

    def _take(self, value: int) -> Saying | None:
        """Take a character of a block."""
        closing, escaped = self._closing, self._escaped
        self._escaped = False
        if closing:
            return self._acknowledge() if value == self._sum else self._refuse()
        self._sum ^= value
        if not escaped:
            self._escaped = value == DLE
        elif value == ETX:
            self._closing = True
        elif value != DLE:
            self._state = State.REFUSING
        if value != DLE or escaped:
            self._data.append(value)
        return None

    def _acknowledge(self) -> Saying:
        self._state = State.IDLE
        self.received.append(bytes(self._data[:-1]))  # without ETX
        return _answer(DLE, self._disturb(Occasion.ACKNOWLEDGE))

    def _refuse(self) -> Saying:
        self._state = State.REFUSED
        return Saying(bytes([NAK]))


def _answer(value: int, trouble: Trouble | None) -> Saying:
    if trouble is None:
        return Saying(bytes([value]))
    is_late = trouble.kind == "late"  # or lost
    return Saying(bytes([value]) if is_late else b"", (trouble.kind,), trouble.number)
