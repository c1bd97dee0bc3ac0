# SPDX-License-Identifier: GPL-2.0-or-later
"""An S5 and a PPC over 3964R and RK512: the procedure, the telegrams, the scenarios, and an independent partner."""

from __future__ import annotations

import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from sisbus.playing.characters import Played
from sisbus.procedure3964 import rk512
from sisbus.procedure3964.controls import ControlMemory
from sisbus.procedure3964.partner import MS, Occasion, Partner, Saying, Trouble, packed
from sisbus.procedure3964.procedure import _KINDS, _STEPS
from sisbus.procedure3964.rk512 import Head, RkError
from sisbus.scenarios import scenario
from sisbus.scenarios.scenario import Playing, load
from sistap import cli
from sistap.dissected.captures.reading import records
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import Framing, Record, Type

STX, ETX, DLE, NAK = b"\x02", b"\x03", b"\x10", b"\x15"
ONCE = Playing(cycles=1)
# S-0-0237 (number 0ED hex) of axis 2 is read: BCC by hand 45 ^ 44 ^ 01 ^ 02 ^ 02 ^ ED ^ 10 ^ 03 = FE.
READ = "00 00 45 44 00 00 00 01 00 00 00 02 02 00 00 ED"
IS_7 = "00 00 00 00 00 07"


def octets(text: str) -> bytes:
    return bytes.fromhex(text)


# -- The procedure --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "block"),
    [
        (READ, READ + "10 03 FE"),
        (IS_7, IS_7 + "10 03 14"),
        ("10", "10 10 10 03 13"),  # the pair is nothing in the sum
        ("02 03 15", "02 03 15 10 03 07"),
    ],
)
def test_a_block(data: str, block: str) -> None:
    assert packed(octets(data)) == octets(block)


class Alone:
    """One partner; the test plays the other one."""

    def __init__(self, *, high: bool = True, **troubles: tuple[str, int]) -> None:
        self.partner = Partner(high=high, disturb=self._disturb)
        self._troubles = troubles
        self.now_ns = 0

    def _disturb(self, occasion: Occasion) -> Trouble | None:
        trouble = self._troubles.pop(occasion.value, None)
        return Trouble(*trouble) if trouble else None

    def hears(self, *characters: bytes) -> bytes:
        """Send these characters, a millisecond each; return the answer."""
        answered = b""
        for value in b"".join(characters):
            self.now_ns += MS
            answered += self._said(self.partner.hear(value, self.now_ns))
        return answered

    def waits(self, ms: float) -> bytes:
        """Let that much time pass at once."""
        self.now_ns += int(ms * MS)
        return self._said(self.partner.look(self.now_ns))

    def _said(self, saying: Saying | None) -> bytes:
        if saying is None:
            return b""
        self.partner.said(self.now_ns)
        return saying.said


def sender(*, high: bool = True, data: str = "41") -> Alone:
    alone = Alone(high=high)
    alone.partner.send(octets(data), 0)
    assert alone.waits(0) == STX
    return alone


BLOCK_41 = octets("41 10 03 52")


def test_a_sender_asks_sends_and_is_acknowledged() -> None:
    one = sender()
    assert one.hears(DLE) == BLOCK_41
    assert list(one.partner.outcomes) == []
    assert one.hears(DLE) == b""
    assert list(one.partner.outcomes) == [True]
    assert one.partner.due_ns is None


@pytest.mark.parametrize("answer", [NAK, b"x"])
def test_a_sender_that_is_not_granted_asks_six_times(answer: bytes) -> None:
    one = sender()
    assert [one.hears(answer) for _ in range(6)] == [STX] * 5 + [b""]
    assert list(one.partner.outcomes) == [False]


def test_an_answer_is_waited_for_two_seconds() -> None:
    one = sender()
    assert one.waits(1999) == b""
    assert one.waits(1) == STX
    assert one.hears(DLE) == BLOCK_41
    assert one.waits(1999) == b""
    assert one.waits(1) == STX


def test_a_block_is_sent_six_times() -> None:
    one = sender()
    for _ in range(5):
        assert one.hears(DLE) == BLOCK_41
        assert one.hears(NAK) == STX
    assert one.hears(DLE) == BLOCK_41
    assert one.hears(NAK) == b""
    assert list(one.partner.outcomes) == [False]


def test_a_receiver_grants_collects_and_acknowledges() -> None:
    one = Alone()
    assert one.hears(STX) == DLE
    # BCC by hand: 03 ^ 10 ^ 03 = 10. It is not doubled.
    assert one.hears(octets("00 10 10 03 10 03 10")) == DLE
    assert list(one.partner.received) == [octets("00 10 03")]


def test_a_wrong_bcc_is_refused_and_the_block_comes_again() -> None:
    one = Alone()
    one.hears(STX)
    assert one.hears(octets("41 10 03 53")) == NAK
    assert not one.partner.received
    one.partner.send(b"B", one.now_ns)
    assert one.waits(3999) == b""  # it waits for the repetition
    assert one.hears(STX, BLOCK_41) == DLE + DLE
    assert list(one.partner.received) == [b"A"]


def test_a_repetition_that_does_not_come_is_waited_for_four_seconds() -> None:
    one = Alone()
    one.hears(STX, octets("41 10 03 53"))
    one.partner.send(b"B", one.now_ns)
    assert one.waits(4000) == b""
    assert one.waits(0) == STX


def test_a_block_that_stops_is_refused_after_220_ms() -> None:
    one = Alone()
    one.hears(STX, b"A")
    assert one.waits(219) == b""
    assert one.waits(1) == NAK
    two = Alone()  # also if nothing at all comes
    two.hears(STX)
    assert two.waits(220) == NAK


def test_a_single_dle_is_refused_when_the_line_is_silent() -> None:
    one = Alone()
    one.hears(STX)
    assert one.hears(octets("41 10 42"), BLOCK_41) == b""
    assert one.waits(220) == NAK
    assert not one.partner.received


@pytest.mark.parametrize("high", [True, False])
def test_if_both_ask_low_priority_gives_way_and_asks_again(high: bool) -> None:
    one = sender(high=high)
    assert one.hears(STX) == (b"" if high else DLE)
    if high:
        assert one.hears(DLE) == BLOCK_41
        return
    assert one.hears(octets("42 10 03 51")) == DLE
    assert list(one.partner.received) == [b"B"]
    assert one.waits(0) == STX
    assert one.hears(DLE) == BLOCK_41


def test_what_goes_wrong_is_said_that_way() -> None:
    assert Alone(grant=("refused", 0)).hears(STX) == NAK
    assert Alone(grant=("unheard", 0)).hears(STX, STX) == DLE
    lost = Alone(acknowledge=("lost", 0))
    assert lost.hears(STX, BLOCK_41) == DLE
    assert list(lost.partner.received) == [b"A"]
    for trouble, said in ((("bcc", 0), "41 10 03 AD"), (("broken", 2), "41 10")):
        one = Alone(block=trouble)
        one.partner.send(b"A", 0)
        one.waits(0)
        assert one.hears(DLE) == octets(said)


# -- Telegrams ------------------------------------------------------------------------------------------------------


def test_a_read_of_a_parameter() -> None:
    head = Head.of("S-0-0237", 2, write=False)
    assert rk512.command(rk512.FETCH, 0, 1, bytes(head)) == octets(READ)


@pytest.mark.parametrize(
    ("name", "axis", "write", "last", "head"),
    [
        ("S-0-0237", 2, False, True, "00 02 02 00 00 ED"),
        ("P-0-0072", 1, True, False, "00 01 01 00 80 48"),
        ("A-0-0060", 3, True, True, "00 03 03 01 00 3C"),
        ("C-0-0013", 0, False, True, "00 02 00 02 00 0D"),
        ("P-2-0012", 4, False, True, "00 02 04 00 A0 0C"),
    ],
)
def test_heads(name: str, axis: int, write: bool, last: bool, head: str) -> None:
    made = Head.of(name, axis, write=write, last=last)
    assert bytes(made) == octets(head)
    assert Head.read(octets(head) + b"data") == made


def memory() -> ControlMemory:
    place = 2, octets("00 00 ED")
    listed = 0, octets("02 00 0D")
    return ControlMemory({place: octets("00 07"), listed: octets("00 04 00 04") + b"ABCD"}, frozenset([listed]))


@pytest.mark.parametrize(
    ("commands", "reactions"),
    [
        ([READ], [IS_7]),
        # Written, and read again.
        (["00 00 41 44 00 00 00 04 00 00 00 03 02 00 00 ED 01 F4", READ], ["00 00 00 00", "00 00 00 00 01 F4"]),
        # A list: its length words, then its elements.
        (
            ["00 00 45 44 00 00 00 02 00 00 00 02 00 02 00 0D", "FF 00 45 44"],
            ["00 00 00 00 00 04 00 04", "FF 00 00 00 41 42 43 44"],
        ),
        (
            ["00 00 41 44 63 00 00 01 00 00 A5 5A", "00 00 45 44 63 00 00 01 00 00"],
            ["00 00 00 00", "00 00 00 00 A5 5A"],
        ),
        # What there is not, and what does not fit.
        (["00 00 45 44 00 00 00 01 00 00 00 02 03 00 00 ED"], ["00 00 00 14"]),
        (["00 00 45 44 65 00 00 01 00 00"], ["00 00 00 14"]),
        (["00 00 4F 44 00 00 00 01 00 00"], ["00 00 00 16"]),
        (["00 00 45 58 00 00 00 01 00 00"], ["00 00 00 16"]),
        (["FF 00 41 44 00 00"], ["FF 00 00 36"]),
        (["FF 00 45 44"], ["FF 00 00 36"]),
        (["00 00 41 44 00 00 00 01 00 00 00 01 02 03"], ["00 00 00 34"]),
    ],
)
def test_what_a_ppc_answers(commands: list[str], reactions: list[str]) -> None:
    ppc = memory()
    assert [bytes(ppc.react(octets(command))) for command in commands] == [octets(reaction) for reaction in reactions]


def test_a_long_list_comes_in_data_blocks_the_last_number_first() -> None:
    ppc = memory()
    data = bytes(range(256)) * 20  # 5120 bytes: 3 blocks with the head
    head = Head.of("C-0-0013", 0, write=True, last=False)
    numbers = []
    for number, piece in rk512.blocks(bytes(head) + data):
        numbers.append((number, len(piece)))
        for telegram in rk512.sending(number, piece):
            assert ppc.react(telegram).error == RkError.NONE
    assert numbers == [(2, 3968), (1, 5126 - 3968)]
    assert ppc.parameters[0, octets("02 00 0D")] == data


# -- Scenarios ------------------------------------------------------------------------------------------------------


def play(name: str, how: Playing = ONCE) -> list[Played]:
    one = load(name)
    return list(one.play(one.settings, how))


def blocks(played: list[Played]) -> list[bytes]:
    """Return what is in the blocks; written without the procedure of sistap."""
    return [one.sent[:-3].replace(DLE + DLE, DLE) for one in played if len(one.sent) > 1]


def test_the_first_exchange() -> None:
    said = [(one.line, one.sent) for one in play("s5")[:8]]
    assert said == [
        (1, STX),
        (2, DLE),
        (1, octets(READ + "10 03 FE")),
        (2, DLE),
        (2, STX),
        (1, DLE),
        (2, octets(IS_7 + "10 03 14")),
        (1, DLE),
    ]


def test_what_the_s5_says() -> None:
    told = [data.hex(" ").upper() for data in blocks(play("s5"))]
    assert told[:2] == [READ, IS_7]
    assert told[8:10] == ["00 00 45 44 00 00 00 02 00 00 00 02 02 00 00 24", "00 00 00 00 10 10 10 10"]
    # 75 words: 4 bytes of lengths (96 hex), then 128 and 22 bytes.
    assert told[11] == "00 00 00 00 00 96 00 96"
    assert [len(octets(text)) for text in told[13:16:2]] == [4 + 128, 4 + 22]
    assert told[16:20] == [
        "00 00 41 44 63 00 00 02 00 00 A5 5A 12 34",
        "00 00 00 00",
        "00 00 45 44 63 00 00 02 00 00",
        "00 00 00 00 A5 5A 12 34",
    ]
    assert told[-1] == "00 00 00 14"


def test_the_cam_of_the_manual() -> None:
    """2053 words: DB 2 has 1984, in 31 telegrams; DB 1 has 69, which are 138 bytes and need two."""
    said = blocks(play("s5-cam"))
    commands, reactions = said[:-2:2], said[1:-2:2]
    assert len(commands) == 31 + 2
    assert [len(data) for data in commands] == [138, *[132] * 30, 138, 14]
    assert commands[0][:10] == octets("00 00 41 44 02 00 07 C0 00 00")
    follow_up = octets("FF 00 41 44 00 1E 00 00 00 1F 00 00 00 20 00 00 00 21")
    assert commands[1][: len(follow_up)] == follow_up
    assert commands[1][-6:] == octets("00 00 00 3D 00 00")
    assert commands[31][:14] == octets("00 00 41 44 01 00 00 45 00 00 03 DE 00 00")
    assert commands[32] == octets("FF 00 41 44 03 FE 00 00 03 FF 00 00 04 00")
    first, follows = octets("00 00 00 00"), octets("FF 00 00 00")
    assert reactions == [first, *[follows] * 30, first, follows]


# Who says what, by exchange: S5 upper case, PPC lower; s asks, d DLE, n NAK, b a block.
GOOD = "SdBd sDbD"


def test_what_goes_wrong_is_repeated() -> None:
    said = "".join(_letter(one) for one in play("s5-faults"))
    expected = [
        "SnSdBd sDbD",  # refused
        "SdBnSdBd sDbD",  # BCC of the command
        "SdBd sDbNsDbD",  # BCC of the reaction
        "SSdBd sDbD",  # STX not heard
        "SdBSdBd sDbD",  # DLE lost after the block
        "SnSdBd sDbD",  # DLE lost after STX
        "SSdBd sDbD",  # DLE late
        "SdBnSdBd sDbD",  # broken off
        "SdBd SsdBd sDbD",  # both ask
    ]
    assert said == "".join(expected).replace(" ", "")
    whole = [one for one in play("s5-faults") if not one.marks or one.marks == ["both"]]
    assert set(blocks(whole)) == {octets(READ), octets(IS_7)}


def _letter(one: Played) -> str:
    letter = {STX: "s", DLE: "d", NAK: "n"}.get(one.sent, "b")
    return letter.upper() if one.line == 1 else letter


def test_the_times_of_the_procedure() -> None:
    """Silences of 220 ms and 2 s, twice and three times; each partner is a little slower than nothing."""
    played = play("s5-faults")
    ends = [one.characters[-1].time_ns for one in played]
    silences = [(later.time_ns - end) / MS for (_, later), end in zip(pairwise(played), ends, strict=False)]
    assert len([ms for ms in silences if 2000 <= ms < 2015]) == 3  # unheard, lost after the block, late
    assert len([ms for ms in silences if 220 <= ms < 235]) == 2


def test_both_on_one_line() -> None:
    played = play("s5-shared")
    assert {one.line for one in played} == {0}
    for one, other in pairwise(played):
        assert other.time_ns > one.characters[-1].time_ns


def test_a_loop_and_a_duration() -> None:
    assert len(play("s5-shared", Playing(cycles=3))) == 3 * len(play("s5-shared"))
    assert play("s5-shared", Playing(end_ns=500 * MS))[-1].time_ns < 500 * MS


def write(folder: Path, *options: str) -> list[Record]:
    path = folder / "x.pcapng"
    assert cli.main(["bus", *options, "-w", str(path)]) == 0
    return list(records(path))


@pytest.mark.parametrize("name", [name for name in scenario.names() if name.startswith("s5")])
def test_a_file_has_handshakes_and_blocks(tmp_path: Path, name: str) -> None:
    played = play(name)
    found = write(tmp_path, name)
    lines = load(name).lines
    assert [record.type for record in found[: len(lines)]] == [Type.EVENT] * len(lines)
    found = found[len(lines) :]
    for line in lines:
        assert [record.data for record in found if record.line == line] == [
            one.sent for one in played if one.line == line
        ]
    assert {record.framing for record in found} == {Framing.PROCEDURE_3964R}
    broken = [record.data for record in found if record.type == Type.OTHER]
    assert broken == [one.sent for one in played if any("broken" in mark for mark in one.marks)]


def test_tap_faults(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    found = write(tmp_path, "s5", "--faults", "parity=0.05,break=0.02,loss=0.02", "--cycles", "3")
    assert {Flag.CHARACTER_ERROR, Flag.BREAK, Flag.LOST_BEFORE} <= {
        flag for one in found for flag in Flag if flag & one.errors
    }
    for fault in ("checksum=0.1", "pause=0.1"):
        assert cli.main(["bus", "s5", "--faults", fault, "-w", str(tmp_path / "y")]) == 2
        assert "checksum and pause are for SIS" in capfd.readouterr().err


def tapped(path: Path, *bus: str) -> list[Record]:
    """Return what a tap hears on a bus at a socket."""
    command = [sys.executable, "-m", "sistap", *bus, "--listen", "127.0.0.1:0", "--fast"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as playing:
        assert playing.stdout
        name = playing.stdout.readline().strip()
        assert cli.main(["capture", "-i", name, "--framing", "3964r", "-w", str(path), "-q"]) == 1  # the bus has ended
        playing.wait(60)
    found = [one for one in records(path) if one.type != Type.EVENT]
    return sorted(found, key=lambda one: one.time_ns)  # the tap waits half a second for the other line, not longer


def test_a_tap_hears_both_lines_also_of_a_replay(tmp_path: Path) -> None:
    heard = tapped(tmp_path / "x", "bus", "s5-faults", "--cycles", "1")
    played = play("s5-faults")
    for line in (1, 2):
        assert [one.data for one in heard if one.line == line] == [one.sent for one in played if one.line == line]
    again = tapped(tmp_path / "y", "replay", str(tmp_path / "x"))
    assert [(one.line, one.data, one.intervals, one.flags) for one in again] == [
        (one.line, one.data, one.intervals, one.flags) for one in heard
    ]


MINE = """
title = "mine"
[line]
baud = 19200
[s5]
priority = "low"
script = [{ read = "S-0-0237", axis = 2 }, { read = "S-0-0237", axis = 2 }]
[ppc]
parameter = [{ ident = "S-0-0237", axis = 2, word = 7 }]
[[fault]]
kind = "both"
which = 1
"""


def written(folder: Path, text: str) -> str:
    (folder / "mine.toml").write_text(text)
    return str(folder / "mine.toml")


def test_an_s5_of_low_priority_gives_way(tmp_path: Path) -> None:
    played = play(written(tmp_path, MINE))
    said = [one.sent.hex() if len(one.sent) == 1 else one.sent[0:4].hex() for one in played]
    # It asks with the PPC, takes the reaction, and has no reason to repeat its command.
    assert said[:9] == ["02", "10", "00004544", "10", "02", "02", "10", "00000000", "10"]
    assert len(blocks(played)) == 4


def test_a_reaction_that_comes_again_answers_no_new_command(tmp_path: Path) -> None:
    """The acknowledgment of the first reaction is lost, and the S5 gives way to its repetition."""
    fault = MINE[MINE.index("[[fault]]") :]
    again = MINE.replace(fault, '[[fault]]\nkind = "lost"\nof = "s5"\nwhich = 1\n')
    mine = again.replace(", axis = 2 }]", ", axis = 3 }]").replace(
        "word = 7 }", 'word = 7 }, { ident = "S-0-0237", axis = 3, word = 8 }'
    )
    first, second = octets(READ), octets(READ[:-11] + "03 00 00 ED")
    said = [first, octets(IS_7), octets(IS_7), second, octets("00 00 00 00 00 08")]
    assert blocks(play(written(tmp_path, mine))) == said


@pytest.mark.parametrize(
    ("old", "new", "wrong"),
    [
        ("baud", "trs_ms = 5\nbaud", "trs_ms, tza_ms and twm_ms are for SIS"),
        ('"low"', '"medium"', "[s5]: priority"),
        ("axis = 2 },", "axis = 2, words = -1 },", "[s5], step 1: words"),
        ("axis = 2 },", "axes = 2 },", "[s5], step 1: unknown key axes"),
        ("read = ", "reads = ", "[s5], step 1: a key is missing"),
        ('"S-0-0237", axis = 2, word', '"X-0-0237", axis = 2, word', "'X-0-0237' is not a parameter"),
        ("word = 7", 'data = "07"', "data has 1 bytes: use whole words"),
        ('"both"', '"noise"', "use one of refused, unheard, lost, late, bcc, broken, both"),
        ('"both"', '"late"', "[[fault]] 1: of is missing"),
        ("[ppc]", "[pcc]", "[[fault]] needs [s5] and [ppc]"),
        ("which", "station = 3\nwhich", "unknown key station"),
    ],
)
def test_what_is_wrong_in_a_file(tmp_path: Path, old: str, new: str, wrong: str) -> None:
    assert old in MINE
    with pytest.raises(ValueError, match=re.escape(wrong)):
        load(written(tmp_path, MINE.replace(old, new, 1)))


def test_the_readme_names_steps_and_faults(tmp_path: Path) -> None:
    text = (Path(scenario.__file__).parent / "README.md").read_text().partition("## Procedure 3964R")[2]
    assert set(_STEPS) | set(_KINDS) <= set(re.findall(r"`([a-z_]+)`", text))
    example = re.search(r"```toml\n(.*?)```", text, re.DOTALL)
    assert example
    assert "".join(_letter(one) for one in play(written(tmp_path, example[1]))) == "SnSdBdsDbD" + "SdBdsDbD"
