# SPDX-License-Identifier: GPL-2.0-or-later
"""The simulated line: who has the word, when a reaction counts, and where faults act, without a file or a terminal."""

from __future__ import annotations

import random
from collections.abc import Sequence

import pytest

from sisbus.playing.characters import Branch, Faults, Sending, SentCharacter, Slot, hear, reads, uncertainty
from sisbus.playing.conducting import Action, Script, Token, Wait, conduct, is_answered, repeating
from sisbus.playing.player import Player, Times, collide
from sisbus.stations.making import make
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.sis.telegram import build, parse

MS = 1_000_000
LINE = LineSettings()  # 9600 Bd 8E1: eleven bits, 1.146 ms
CHARACTER_NS = LINE.character_ns
READ_PHASE = build(0x12, 16, 3)
TIMES = Times(trs=50, tza=5, tmas=100)


def player(faults: Faults = Faults(), seed: int = 1) -> Player:  # noqa: B008 - a tuple
    return Player(LINE, faults, seed, make([{"address": 3}], 1), TIMES)


def script(*actions: Action) -> Script:
    for action in actions:  # noqa: UP028 - a tuple takes no reactions
        yield action


def said(*scripts: tuple[int, Script]) -> list[tuple[int, int, bool]]:
    """Return sender, service and direction of what is said."""
    parsed = (parse(one.sent) for one in conduct(player(), dict(scripts)))
    return [(one.sender, one.service, one.reaction) for one in parsed]


def test_a_reaction_begins_after_tza_and_the_next_command_after_the_master_has_waited() -> None:
    line = player()
    played = [*line.exchange(READ_PHASE)]
    command, reaction = played
    between_ns = reaction.time_ns - CHARACTER_NS - command.characters[-1].time_ns
    assert 6 * MS <= between_ns < 11 * MS + CHARACTER_NS  # TzA, and 1 to 6 ms
    assert 10 * MS <= line.now_ns - reaction.characters[-1].time_ns < 30 * MS  # TzA, and 5 to 25 ms
    for one in played:
        intervals = [b.time_ns - a.time_ns for a, b in zip(one.characters, one.characters[1:], strict=False)]
        assert all(CHARACTER_NS <= interval <= 1.2 * CHARACTER_NS for interval in intervals)


def test_without_a_reaction_the_master_waits_for_trs() -> None:
    line = player()
    (command,) = line.exchange(build(0x12, 16, 4))
    assert 60 * MS <= line.now_ns - command.characters[-1].time_ns < 80 * MS  # TrS, TzA, and 5 to 25 ms


def test_times_for_a_slow_line_are_four_characters() -> None:
    assert Times.for_line(LINE) == (50, 5, 500)
    assert Times.for_line(LINE._replace(baud=1200)) == (370, 37, 3700)  # of 9.17 ms


def test_the_word_goes_to_who_gets_the_token_or_to_the_next() -> None:
    token = Token(17, build(0x0F, 16, 17))
    first = 16, script(READ_PHASE, token, READ_PHASE)
    other = 17, script(build(0x10, 17, 3))
    read, answer, give = (16, 0x12, False), (16, 0x12, True), (16, 0x0F, False)
    asked = [(17, 0x10, False), (17, 0x10, True)]
    assert said(first, other) == [read, answer, give, *asked, read, answer]
    lost = Token(99, build(0x0F, 16, 99))  # whose script has ended
    assert said((16, script(lost, READ_PHASE)), (17, script(build(0x10, 17, 3)))) == [give, *asked, read, answer]


def test_what_began_before_the_end_is_completed() -> None:
    line = player()
    found = [*conduct(line, {16: script(*[READ_PHASE] * 9)}, end_ns=1)]
    assert len(found) == 2
    assert [*conduct(line, {16: script(READ_PHASE)}, end_ns=line.now_ns)] == []


def test_a_command_is_repeated_until_it_is_answered() -> None:
    def heard(*reactions: bytes | None, command: bytes = READ_PHASE) -> list[object]:
        asking = repeating(script(command), 2, 7)
        found: list[object] = [next(asking)]
        for reaction in reactions:
            try:
                found.append(asking.send(reaction))
            except StopIteration:
                return [*found, "end"]
        return found

    assert heard(b"yes") == [READ_PHASE, "end"]
    assert heard(None, None, b"yes") == [READ_PHASE, Wait(7), READ_PHASE, "end"]
    assert heard(None, None, None, None, None) == [READ_PHASE, Wait(7), READ_PHASE, Wait(7), READ_PHASE, "end"]
    to_all = build(0x12, 16, 255)
    assert heard(None, command=to_all) == [to_all, "end"]
    assert is_answered(READ_PHASE) and not is_answered(to_all)
    assert is_answered(build(0x12, 16, 3, subaddresses=b"\4")) and not is_answered(
        build(0x12, 16, 3, subaddresses=b"\xfe")
    )


@pytest.mark.parametrize(
    ("most", "times", "sizes"),
    [
        (4, range(6), [4, 2]),
        (14, range(6), [6]),
        (14, [0, 1, 7, 8], [2, 2]),
        (14, [0, 1, 6, 7], [4]),
        (1, range(2), [1, 1]),
    ],
)
def test_reads_of_a_coarse_adapter(most: int, times: Sequence[int], sizes: Sequence[int]) -> None:
    """Up to so many, or until a silence of four character times: five from end to end."""
    found = [*reads([SentCharacter(100 * time, 0, 0) for time in times], most, 100)]
    assert [len(read) for read in found] == sizes
    assert uncertainty(found[0]) == 100 * (times[sizes[0] - 1] - times[0])


def test_faults_of_the_branch() -> None:
    def branch(**faults: float) -> Branch:
        return Branch(Faults(**faults), 1)

    marks: list[str] = []
    assert branch(pause=1).pause(0, 100, marks) is None and marks == []  # before the first there is silence
    assert 150 <= (branch(pause=1).pause(3, 100, marks) or 0) <= 300 and marks == ["pause@3"]
    losing = branch(loss=1)
    assert losing.arrived(2, Slot(7), 5, marks) is None and marks[-1] == "loss@2"
    losing._faults = Faults()
    assert losing.arrived(3, Slot(7), 6, marks) == (6, 7, Flag.LOST_BEFORE)
    assert losing.arrived(4, Slot(7), 7, marks) == (7, 7, 0)
    assert branch(break_=1).arrived(5, Slot(7), 8, marks) == (8, 0, Flag.BREAK) and marks[-1] == "break@5"
    _, value, flags = branch(parity=1).arrived(6, Slot(7), 9, marks) or (0, 0, 0)
    assert (value ^ 7).bit_count() == 1 and flags == Flag.CHARACTER_ERROR and marks[-1] == f"parity@6={value:02X}"
    sending = Sending(READ_PHASE, LINE)
    branch(checksum=1).falsify(sending)
    assert sending.marks == ["checksum@1"] and sending.sent[2:] == READ_PHASE[2:]
    assert sending.slots[1].value == sending.sent[1] != READ_PHASE[1]


@pytest.mark.parametrize("text", ["loss", "loss=x", "none=1", "loss=1.1", "loss=-0.1", ""])
def test_faults_that_are_none(text: str) -> None:
    with pytest.raises(ValueError, match="fault"):
        Faults.parse(text)
    assert Faults.parse("break=0.5, loss=1") == Faults(break_=0.5, loss=1)


@pytest.mark.parametrize(
    ("value", "tap", "heard"),
    [
        (0x41, "8E1", (0x41, 0)),
        (0x41, "8O1", (0x41, Flag.CHARACTER_ERROR)),
        (0x43, "8N1", (0x43, 0)),  # three bits: the parity bit is 1, and taken for the stop bit
        (0x41, "8N1", (0x41, Flag.CHARACTER_ERROR)),  # it is 0: no stop bit
        (0xC1, "7E1", (0x41, Flag.CHARACTER_ERROR)),  # its last bit is taken for a wrong parity
        (0x00, "8E1", (0x00, 0)),
        (0x00, "8N1", (0x00, Flag.BREAK)),  # no bit of it is 1
    ],
)
def test_a_receiver_with_another_format(value: int, tap: str, heard: tuple[int, int]) -> None:
    assert hear(value, LINE, LineSettings.parse(9600, tap), random.Random(1)) == heard


def test_two_at_once_have_the_bits_on_which_both_agree() -> None:
    for seed in range(20):
        sending = Sending(b"\xf0" * 4, LINE)
        collide(sending, b"\xff" * 4, random.Random(seed))
        (mark,) = sending.marks
        start = int(mark.partition("@")[2].partition("=")[0])
        assert len(sending.slots) == 4 + start and sending.damaged and mark.endswith("=FFFFFFFF")
        assert [slot.value for slot in sending.slots[:start]] == [0xF0] * start
        for slot in sending.slots[start:4]:
            assert slot.value & 0xF0 == 0xF0
            # Both have an even number of bits, and so a parity bit of 0.
            assert bool(slot.flags) == bool(slot.value.bit_count() % 2)
        assert [slot.value for slot in sending.slots[4:]] == [0xFF] * start
