# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts procedure 3964R: single handshake characters, and blocks with their check character.

A sender requests with STX; the receiver grants with DLE or refuses with NAK; then the block comes. In it each DLE is
doubled; DLE, ETX and BCC end it. The receiver acknowledges with DLE, or refuses with NAK. BCC is the XOR of everything
after STX.

A shared line (0) carries all of that. On a full-duplex tap (lines 1 and 2) each line has one half: the block follows
its STX directly, and the answers of the other partner are on the other line.
"""

from __future__ import annotations

from functools import reduce
from operator import xor

from sistap.line.settings import LineSettings
from sistap.records.framer import RUN_LIMIT, SILENCE_NS, ContentFramer
from sistap.records.record import Framing, Record

STX, ETX, DLE, NAK = 0x02, 0x03, 0x10, 0x15
HANDSHAKE_NAMES = {STX: "STX", DLE: "DLE", NAK: "NAK"}
HANDSHAKES = bytes(HANDSHAKE_NAMES)
BLOCK_LIMIT = 2 * 4096 + 3  # the longest block of controls has 4096 characters, all of which may be doubled
_END = 3  # characters: DLE, ETX, BCC


def check_character(characters: bytes) -> int:
    """Return the BCC of everything after STX, including DLE and ETX at its end."""
    return reduce(xor, characters, 0)


class Framer3964R(ContentFramer):
    """Cuts handshake characters and blocks; incomplete blocks and everything between blocks are other characters.

    A block with a wrong BCC is a frame, too (Record.checksum_bad), if no good one begins at an STX inside it.
    """

    framing = Framing.PROCEDURE_3964R

    def __init__(self, line: int, settings: LineSettings, silence_ns: int = SILENCE_NS) -> None:
        super().__init__(line, settings, silence_ns)
        self._shared = line == 0
        self._at = 0  # position of the next character to look at
        self._asked = False  # the last character was STX; a grant may take longer than the silence that ends a block
        self._block: int | None = None  # where it begins; None: no block
        self._begin_block(None)

    def flush(self) -> list[Record]:
        """Return all that is left. A request stays valid if nothing of its block has come."""
        waits = self._asked or self._block == len(self._data)
        records = super().flush()
        self._asked = waits
        self._begin_block(None)
        return records

    @property
    def _certain(self) -> int:
        return self._at if self._block is None else self._done

    def _cut(self, records: list[Record], *, final: bool) -> None:
        while self._at < len(self._data):
            at, value = self._at, self._data[self._at]
            self._at += 1
            if self._block is None:
                self._outside(records, at, value)
            elif self._closing:
                self._close(records, self._block, at + 1)
            else:
                self._inside(records, self._block, at, value)
        if final and self._block is not None:
            self._break_off(records, len(self._data))
        if final:
            self._emit_others(records, len(self._data))
        self._forget_done()

    def _begin_block(self, at: int | None) -> None:
        self._block = at
        self._escaped = False  # the last character was a DLE, not doubled yet
        self._closing = False  # DLE and ETX have come: the next is BCC
        self._broken = False  # a DLE was followed by an invalid character

    def _outside(self, records: list[Record], at: int, value: int) -> None:
        """Take a character outside a block."""
        asked, self._asked = self._asked, False
        if value == DLE and asked and self._shared:
            self._emit_frame(records, at, at + 1, checksum_bad=False)
            self._begin_block(at + 1)
        elif value in HANDSHAKES:
            self._emit_frame(records, at, at + 1, checksum_bad=False)
            if value == STX:
                self._asked = self._shared
                self._begin_block(None if self._shared else at + 1)
        elif asked:  # the grant was not heard here, or came before a pause
            self._begin_block(at)
        elif at + 1 - self._done >= RUN_LIMIT:
            self._emit_others(records, at + 1)

    def _inside(self, records: list[Record], block: int, at: int, value: int) -> None:
        """Take a character inside a block."""
        if not self._escaped:
            self._escaped = value == DLE
        elif value == DLE:
            self._escaped = False
        elif value == ETX:
            self._closing = True
        else:
            self._escaped = False
            self._interrupt(records, block, at, value)
        if self._block is not None and at + 1 - self._block >= BLOCK_LIMIT:
            self._emit_others(records, at + 1)
            self._begin_block(None)

    def _interrupt(self, records: list[Record], block: int, at: int, value: int) -> None:
        """Handle a single DLE before this character: a new request was granted, or the block is broken."""
        before = bytes(self._data[block:at]).rstrip(bytes([DLE]))
        if self._shared and before.endswith(bytes([STX])):
            stx = block + len(before) - 1
            self._break_off(records, stx)
            self._emit_frame(records, stx, stx + 1, checksum_bad=False)
            self._emit_frame(records, stx + 1, stx + 2, checksum_bad=False)
            self._begin_block(stx + 2)
        elif not self._shared and not bytes(self._data[block:at]).strip(HANDSHAKES):
            # It requested, gave way, and answered its partner's block.
            self._break_off(records, at)
            self._begin_block(None)
            self._outside(records, at, value)
        else:
            self._broken = True

    def _close(self, records: list[Record], block: int, end: int) -> None:
        """Decide about a block that is complete up to its BCC."""
        bad = check_character(self._data[block:end]) != 0
        stx = self._good_inside(block, end) if bad and not self._shared else None
        if stx is not None:
            self._break_off(records, stx)
            self._emit_frame(records, stx, stx + 1, checksum_bad=False)
            self._emit_frame(records, stx + 1, end, checksum_bad=False)
        elif self._broken:
            self._emit_others(records, end)
        else:
            self._emit_frame(records, block, end, checksum_bad=bad)
        self._begin_block(None)

    def _good_inside(self, block: int, end: int) -> int | None:
        """Return the place of the first STX from which everything to the end has a right BCC."""
        rest = check_character(self._data[block:end])
        for place in range(block, end - _END):
            rest ^= self._data[place]
            if self._data[place] == STX and rest == 0:
                return place
        return None

    def _break_off(self, records: list[Record], end: int) -> None:
        """Emit an incomplete block: other characters, or handshakes if it has nothing else."""
        left = bytes(self._data[self._done : end])
        refused = self._shared and left.endswith(bytes([NAK]))  # refused by its receiver
        handshakes = len(left) if not left.strip(HANDSHAKES) else int(refused)
        self._emit_others(records, end - handshakes)
        for place in range(end - handshakes, end):
            self._emit_frame(records, place, place + 1, checksum_bad=False)

    def _forget_done(self) -> None:
        done = self._done
        super()._forget_done()
        self._at -= done
        if self._block is not None:
            self._block -= done
