# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts procedure 3964R: single handshake characters, and blocks with their check character.

A sender requests with STX; the receiver grants with DLE or refuses with NAK; then the block comes. In it each DLE is
doubled; DLE, ETX and BCC end it. The receiver acknowledges with DLE, or refuses with NAK. BCC is the XOR of everything
after STX.

A shared line (0) carries all of that. On a full-duplex tap (lines 1 and 2) each line has one half: the block follows
its STX directly, and the answers of the other partner are on the other line.

BCC does not show where a block begins: after one STX in 256, the rest of a block has a right BCC, too. So a block
begins where its receiver lets it begin, after a request and a grant. If the grant was not heard, pauses must show that
the sender waited for it. A block ends at its BCC, or at a pause above ZVZ. An STX in it is data, unless pauses or the
other line show a new request. Nobody can see that a block lost 00 or a pair 10 10: its BCC stays right.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from functools import reduce
from operator import xor
from typing import NamedTuple

from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings, Read
from sistap.tap.records.framer import RUN_LIMIT, SILENCE_NS, ContentFramer
from sistap.tap.records.record import Framing, Record

STX, ETX, DLE, NAK = 0x02, 0x03, 0x10, 0x15
HANDSHAKE_NAMES = {STX: "STX", DLE: "DLE", NAK: "NAK"}
HANDSHAKES = bytes(HANDSHAKE_NAMES)
BLOCK_LIMIT = 2 * 4096 + 3  # the longest block of controls has 4096 characters, all of which may be doubled
ZVZ_NS = 220_000_000  # Siemens' limit of the interval between two characters of a block
_LONGEST_ANSWER = 3  # characters: STX of a partner that gives way, DLE, noise. More are a block of the other line
_MOST_NOISE = 1  # characters directly before or after a request. What directly follows more of them belongs to them


def check_character(characters: bytes) -> int:
    """Return the BCC of everything after STX, including DLE and ETX at its end."""
    return reduce(xor, characters, 0)


class _Word(NamedTuple):
    """A character of the other line, and when it can have come. Each port has its own delay."""

    value: int
    earliest_ns: int
    latest_ns: int
    run: int  # characters directly before it


@dataclass
class _Request:
    """An STX outside a block, and what the other line may have said since."""

    earliest_ns: int  # when it came
    latest_ns: int
    after_ns: int  # the pause before it
    answer: list[_Word]

    def hear(self, word: _Word) -> None:
        """Take a character of the other line. One that ends at the same time as STX is no answer to it."""
        if word.latest_ns > self.earliest_ns:
            self.answer.append(word)

    @property
    def _certain(self) -> list[_Word]:
        """Return what certainly came after it."""
        return [word for word in self.answer if word.earliest_ns >= self.latest_ns]

    @property
    def grant(self) -> _Word | None:
        """Return the DLE that grants it, if there is one. Too long an answer is a block of the other line."""
        answers = reversed(self.answer[-_LONGEST_ANSWER:])
        grants = (word for word in answers if word.value == DLE and word.run < _LONGEST_ANSWER)
        return next(grants, None) if len(self._certain) <= _LONGEST_ANSWER else None

    def begins(self, value: int, time_ns: int) -> bool:
        """Tell whether the next character of this line is the first one of the block, and no answer or new request."""
        grant, certain = self.grant, self._certain
        if value in HANDSHAKES:
            answer = next((word for word in reversed(self.answer) if word.value in HANDSHAKES), None)
            return grant is not None and grant == answer and time_ns - grant.latest_ns <= ZVZ_NS
        refused = len(certain) > _LONGEST_ANSWER or any(word.value in (STX, NAK) for word in certain)
        return grant is not None or not refused


@dataclass
class _Block:
    """A block that is not complete."""

    begin: int  # position in the data
    granted: bool
    expected: bool = False  # even without a grant
    word: _Word | None = None  # what the other line said after the beginning
    request: int | None = None  # position of an STX in it that may be a new request
    escaped: bool = False  # the last character was a DLE, not doubled yet
    closing: bool = False  # DLE and ETX have come: the next is BCC
    broken: bool = False  # a DLE was followed by an invalid character

    def take(self, value: int) -> None:
        """Take a character before BCC."""
        if not self.escaped:
            self.escaped = value == DLE
            return
        self.escaped = False
        self.closing = value == ETX
        self.broken |= value not in (ETX, DLE)


class Framer3964R(ContentFramer):
    """Cuts handshake characters and blocks; incomplete blocks and everything between blocks are other characters.

    A block with a wrong BCC is a frame, too (Record.checksum_bad).
    """

    framing = Framing.PROCEDURE_3964R

    def __init__(self, line: int, settings: LineSettings, silence_ns: int = SILENCE_NS) -> None:
        super().__init__(line, settings, silence_ns)
        self._shared = line == 0
        self._at = 0  # position of the next character to look at
        self._pause_ns = ZVZ_NS  # certain pause before that character; at the beginning, nobody knows it
        self._earliest: list[int] = []  # of the data: when each can have come
        self._last_ns = 0  # the same of the character before the next one
        self._heard: deque[_Word] = deque(maxlen=_LONGEST_ANSWER + 1)  # last on the other line
        self._paced = True  # characters come as slowly as the rate says; at a pseudo terminal they need not
        self._run = 0  # characters without a pause that are neither handshakes nor a good block
        self._in_step = False  # the last block was good
        self._request: _Request | None = None  # the last character was a request, or noise directly after it
        self._block: _Block | None = None

    def feed(self, read: Read) -> list[Record]:
        """Take what was read; return the records that it completes."""
        if not self._times:
            self._last_ns = read.time_ns - self.silence_ns
        self._watch_pace(read, self._last_ns)
        self._earliest += self._earliest_of(read)
        return super().feed(read)

    def _watch_pace(self, read: Read, last_ns: int) -> None:
        """Note characters that come faster than the rate allows; the one before them came at that time."""
        self._paced = self._paced and read.time_ns - last_ns >= 0.9 * len(read.data) * self.settings.character_ns

    def _earliest_of(self, read: Read) -> list[int]:
        """Return when each character can have come at the earliest."""
        last = len(read.data) - 1
        first_ns = read.time_ns - read.uncertainty_ns
        return [first_ns - (last - place) * self.settings.character_ns for place in range(last + 1)]

    def beside(self, read: Read) -> list[Record]:
        """Take what came on the other line, where this line's requests are answered. A shared line has no other."""
        records: list[Record] = []
        if self._shared:
            return records
        if self._heard:
            self._watch_pace(read, self._heard[-1].earliest_ns)
        for value, earliest_ns in zip(read.data, self._earliest_of(read), strict=True):
            word = _Word(value, earliest_ns, read.time_ns, self._run_before(earliest_ns + read.uncertainty_ns))
            self._heard.append(word)
            if self._request:
                self._request.hear(word)
            elif self._block:
                self._interrupt(records, self._block, word)
            elif value in HANDSHAKES:
                self._run = 0
        self._forget_done()
        return records

    def _run_before(self, latest_ns: int) -> int:
        """Return how many characters of the other line certainly came directly before one of that time."""
        last = self._heard[-1] if self._heard else None
        return last.run + 1 if last and 0 <= latest_ns - last.earliest_ns < self._adjacent_ns else 0

    def flush(self) -> list[Record]:
        """Return all that is left. A request stays valid if nothing of its block has come."""
        granted = self._block is not None and self._block.begin == len(self._data)
        records = super().flush()
        self._pause_ns = self.silence_ns
        self._block = None
        if granted:
            self._request = _Request(0, 0, self.silence_ns, [])
        return records

    def _silent(self, pause_ns: int, uncertainty_ns: int) -> bool:
        """Accept only a certain pause above ZVZ. Note a shorter one, too."""
        known = uncertainty_ns != UNCERTAINTY_UNKNOWN
        self._pause_ns = max(self._pause_ns, pause_ns - uncertainty_ns if known else pause_ns)
        return known and pause_ns - uncertainty_ns > ZVZ_NS

    @property
    def _adjacent_ns(self) -> float:
        """Return an upper bound of the interval between characters that are sent at once; 0 if it is not known."""
        return 1.5 * self.settings.character_ns if self._paced else 0

    @property
    def _paused(self) -> bool:
        """Tell whether the next character certainly does not follow the one before it directly."""
        return self._paced and self._pause_ns > self._adjacent_ns

    @property
    def _certain(self) -> int:
        return self._done if self._block else self._at

    def _cut(self, records: list[Record], *, final: bool) -> None:
        self._take_all(records)
        if final and self._block:
            self._give_up(records, len(self._data))
        if final:
            self._emit_others(records, len(self._data))
        self._forget_done()

    def _take_all(self, records: list[Record]) -> None:
        while self._at < len(self._data):
            at, value = self._at, self._data[self._at]
            self._at += 1
            if self._block is None:
                self._outside(records, at, value)
            elif value == STX and self._refused(self._block, at):
                self._begin_again(records, at)
            elif self._block.closing:
                self._close(records, self._block, at + 1)
            else:
                self._inside(records, self._block, at, value)
            if self._at > at:
                self._pause_ns, self._last_ns = 0, self._earliest[at]

    # -- Outside a block ------------------------------------------------------------------------------------------

    def _outside(self, records: list[Record], at: int, value: int) -> None:
        """Take a character outside a block."""
        time_ns = self._times[at + 1]
        adjacent = time_ns - self._last_ns < self._adjacent_ns
        self._run = self._run if adjacent else 0
        request, self._request = self._request, None
        if request is None or self._run > _MOST_NOISE:
            self._between(records, at, value)
        elif self._shared and value in HANDSHAKES and not self._run:
            self._between(records, at, value)
            self._block = _Block(at + 1, granted=True) if value == DLE else None
        elif adjacent:  # noise: nobody can have answered yet
            self._request = request
            self._take_other(records, at)
        elif request.begins(value, time_ns):
            expected = self._in_step or request.after_ns > self._adjacent_ns
            self._block = _Block(at, request.grant is not None, expected)
            self._inside(records, self._block, at, value)
        else:
            self._between(records, at, value)

    def _between(self, records: list[Record], at: int, value: int) -> None:
        """Take a character that begins no block."""
        if value not in HANDSHAKES or self._run > _MOST_NOISE:
            self._take_other(records, at)
            return
        self._emit_frame(records, at, at + 1, checksum_bad=False)
        if value == STX:
            self._request = _Request(self._earliest[at], self._times[at + 1], self._pause_ns, [])
            for word in self._heard:
                self._request.hear(word)

    def _take_other(self, records: list[Record], at: int) -> None:
        self._in_step = False
        self._run += 1
        if at + 1 - self._done >= RUN_LIMIT:
            self._emit_others(records, at + 1)

    # -- A block --------------------------------------------------------------------------------------------------

    def _inside(self, records: list[Record], block: _Block, at: int, value: int) -> None:
        """Take a character inside a block."""
        if self._paused and block.request == at - 1 and (at == block.begin + 1 or (self._shared and value == DLE)):
            self._begin_again(records, at - 1)
            return
        if self._interrupted(block, at) and not block.granted:
            self._give_up(records, at)
            return
        if value == STX and not block.escaped and (at == block.begin or self._may_request(block, at)):
            block.request = at
        block.take(value)
        if at + 1 - block.begin >= BLOCK_LIMIT:
            self._give_up(records, at + 1)

    def _may_request(self, block: _Block, at: int) -> bool:
        """Tell whether an STX at this place of a block may be a new request."""
        return (self._paused or not block.granted) if self._shared else self._interrupted(block, at)

    def _interrupted(self, block: _Block, at: int) -> bool:
        """Tell whether the other line has certainly said something in a block before this character."""
        return block.word is not None and block.word.latest_ns <= self._earliest[at]

    def _refused(self, block: _Block, at: int) -> bool:
        """Tell whether a block paused, and the other line said NAK: its ZVZ may be shorter. That ends the block."""
        return self._paused and self._interrupted(block, at) and block.word is not None and block.word.value == NAK

    def _interrupt(self, records: list[Record], block: _Block, word: _Word) -> None:
        """Take a character of the other line while a block comes: perhaps a late grant, or the answer to a request."""
        if word.earliest_ns < self._times[block.begin + 1]:
            block.granted |= word.value == DLE
        elif block.request is not None and self._answers(block.request, word):
            self._begin_again(records, block.request)
            self._take_all(records)
        else:
            block.word = block.word or word

    def _answers(self, request: int, word: _Word) -> bool:
        """Tell whether this is the answer to a new request: the last character of this line."""
        is_last = request == len(self._data) - 1
        return is_last and word.earliest_ns >= self._times[request + 1] and word.value in HANDSHAKES

    def _close(self, records: list[Record], block: _Block, end: int) -> None:
        """Decide about a block that is complete up to its BCC."""
        good = not block.broken and check_character(self._data[block.begin : end]) == 0
        if block.broken or not (block.granted or block.expected):
            self._emit_others(records, end)
        else:
            self._emit_frame(records, block.begin, end, checksum_bad=not good)
        self._in_step = good
        self._run = 0 if good else end - block.begin
        self._block = None

    def _give_up(self, records: list[Record], end: int) -> None:
        """End an incomplete block here."""
        self._emit_others(records, end)
        self._in_step = False
        self._run = end
        self._at = end
        self._block = None

    def _begin_again(self, records: list[Record], request: int) -> None:
        """End an incomplete block before a new request."""
        self._give_up(records, request)
        self._run = self._pause_ns = 0

    def _forget_done(self) -> None:
        done = self._done
        super()._forget_done()
        self._at -= done
        if self._block:
            self._block.begin -= done
            if self._block.request is not None:
                self._block.request -= done

    def _drop(self, count: int) -> None:
        super()._drop(count)
        del self._earliest[:count]
