# SPDX-License-Identifier: GPL-2.0-or-later
"""Telegrams of RK512: a command with up to 128 bytes of data, its follow-ups, and the reaction to each."""

from __future__ import annotations

import enum
import struct
from collections.abc import Iterator
from typing import NamedTuple

from sisbus.devices.parameters import ident

# -- The Indramat extension: the head before the data of a first telegram. All words are high byte first --------------

_HEAD_LAYOUT = struct.Struct(">HBBH")  # info access, axis, parameter type, parameter
HEAD_SIZE = _HEAD_LAYOUT.size
_WRITE, _LAST = 0x01, 0x02  # bits of the info access; without _LAST a "current transmission" follows


class Head(NamedTuple):
    """The contents of a head; `parameter` is type and number, as in SIS (chapter 8.1) but high byte first."""

    write: bool
    last: bool
    axis: int
    parameter: bytes

    @classmethod
    def of(cls, name: str, axis: int, *, write: bool, last: bool = True) -> Head:
        """Return the head of a parameter such as "S-0-0237". ValueError for anything else."""
        kind, low, high = ident(name)
        return cls(write, last, axis, bytes([kind, high, low]))

    @classmethod
    def read(cls, data: bytes) -> Head:
        """Parse a head. ValueError if it is incomplete."""
        if len(data) < HEAD_SIZE:
            raise ValueError("the head is cut")
        access, axis, _, _ = _HEAD_LAYOUT.unpack_from(data)
        return cls(bool(access & _WRITE), bool(access & _LAST), axis, data[3:HEAD_SIZE])

    def __bytes__(self) -> bytes:
        access = (_WRITE if self.write else 0) | (_LAST if self.last else 0)
        return struct.pack(">HB", access, self.axis) + self.parameter


# -- RK512 -----------------------------------------------------------------------------------------------------------

LARGEST = 128  # bytes of data in one telegram
LIST_WORDS = 1984  # in a data block, when an S5 sends a long list in several
SEND, FETCH = ord("A"), ord("E")
_DATA_BLOCK = ord("D")
_FIRST, _FOLLOW_UP = 0x00, 0xFF
_HEAD, _SHORT_HEAD, _REACTION = 10, 4, 4  # bytes


class RkError(enum.IntEnum):
    """The last byte of a reaction, with Siemens' numbers: those of SYNAX are not known."""

    NONE = 0x00
    NO_SUCH_BLOCK = 0x14
    NO_SUCH_COMMAND = 0x16
    WRONG_LENGTH = 0x34
    OUT_OF_SEQUENCE = 0x36  # a follow-up without a command


class Command(NamedTuple):
    """The contents of a command telegram; a follow-up has the letter and data only."""

    follow_up: bool
    letter: int
    block: int
    words: int
    data: bytes


class Reaction(NamedTuple):
    """The contents of a reaction."""

    follow_up: bool
    error: int
    data: bytes

    def __bytes__(self) -> bytes:
        return bytes([_FOLLOW_UP if self.follow_up else _FIRST, 0, 0, self.error]) + self.data


def command(letter: int, block: int, words: int, data: bytes = b"") -> bytes:
    """Return the first telegram of a command; SYNAX writes 00 00 where Siemens has a coordination flag."""
    return bytes([_FIRST, 0, letter, _DATA_BLOCK, block, 0]) + words.to_bytes(2, "big") + bytes(2) + data


def follow_up(letter: int, data: bytes = b"") -> bytes:
    """Return a follow-up telegram."""
    return bytes([_FOLLOW_UP, 0, letter, _DATA_BLOCK]) + data


def sending(block: int, data: bytes) -> Iterator[bytes]:
    """Yield all telegrams that write data into a block. The data are whole words."""
    yield command(SEND, block, len(data) // 2, data[:LARGEST])
    for start in range(LARGEST, len(data), LARGEST):
        yield follow_up(SEND, data[start : start + LARGEST])


def blocks(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the data blocks of a long list, the highest number first: the lower ones hold what does not fit."""
    size = 2 * LIST_WORDS
    count = -(-len(data) // size)
    for place in range(count):
        yield count - place, data[place * size : (place + 1) * size]


def read_command(telegram: bytes) -> Command:
    """Parse a command telegram. ValueError if it is none."""
    if len(telegram) >= _SHORT_HEAD and telegram[0] == _FOLLOW_UP:
        return Command(True, telegram[2], 0, 0, telegram[_SHORT_HEAD:])
    if len(telegram) < _HEAD or telegram[0] != _FIRST or telegram[3] != _DATA_BLOCK:
        raise ValueError("no command telegram")
    words = int.from_bytes(telegram[6:8], "big")
    return Command(False, telegram[2], telegram[4], words, telegram[_HEAD:])


def read_reaction(telegram: bytes) -> Reaction:
    """Parse a reaction. ValueError if it is none."""
    if len(telegram) < _REACTION or telegram[0] not in (_FIRST, _FOLLOW_UP):
        raise ValueError("no reaction")
    return Reaction(telegram[0] == _FOLLOW_UP, telegram[3], telegram[_REACTION:])
