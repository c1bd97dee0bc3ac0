# SPDX-License-Identifier: GPL-2.0-or-later
"""Hints: the right one, once, and none if all is well."""

from __future__ import annotations

import random

import pytest
from specification import TELEGRAMS

from sistap.tap.capture.hints import Hints
from sistap.tap.capture.rate import Scan
from sistap.tap.line import others
from sistap.tap.line.others import Others
from sistap.tap.line.settings import Flag, LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.framer import SisFramer
from sistap.tap.records.record import Framing

pytestmark = pytest.mark.tap

E81 = LineSettings(9600)
N81 = LineSettings(9600, parity="N")


def seen(data: bytes, flag: int = 0) -> Counters:
    counters = Counters()
    read = Read(0, 0, data, bytes([flag]) * len(data))
    counters.add_read(read)
    framer = SisFramer(0, E81)
    for record in framer.feed(read) + framer.flush():
        counters.add_record(record)
    return counters


def hints(
    counters: Counters, settings: LineSettings = E81, elapsed_s: float = 1, framing: Framing = Framing.SIS
) -> list[str]:
    return list(Hints(settings, framing).look(counters, elapsed_s))


def test_nothing_received() -> None:
    assert hints(seen(b""), elapsed_s=4.9) == []
    (hint,) = hints(seen(b""), elapsed_s=5)
    assert "nothing received for 5 s" in hint and "--baud" not in hint
    assert hint.index("master") < hint.index("port") < hint.index("wire")  # none of them is certain


def test_silence_after_the_first_character_is_no_trouble() -> None:
    assert hints(seen(TELEGRAMS["6-24"]), elapsed_s=60) == []


@pytest.mark.parametrize("settings", [E81, N81])
def test_only_breaks_or_framing_errors(settings: LineSettings) -> None:
    counters = seen(b"x" * 20, Flag.CHARACTER_ERROR)
    counters.add_read(Read(0, 0, b"\0", bytes([Flag.BREAK])))
    (hint,) = hints(counters, settings)
    assert "+ and -" in hint and "--baud auto" in hint


def test_every_character_a_parity_error() -> None:
    assert hints(seen(b"x" * 19, Flag.CHARACTER_ERROR)) == []
    (hint,) = hints(seen(b"x" * 20, Flag.CHARACTER_ERROR))
    assert "--format 8N1" in hint
    (hint,) = hints(seen(b"x" * 20, Flag.CHARACTER_ERROR), N81)
    assert "--format 8E1" in hint
    one_good = seen(b"x" * 20, Flag.CHARACTER_ERROR)
    one_good.add_read(Read(0, 0, b"x", b"\0"))
    assert hints(one_good) == []


def test_good_telegrams_are_not_swapped_wires() -> None:
    counters = seen(TELEGRAMS["6-24"] * 2, Flag.CHARACTER_ERROR)
    counters.add_read(Read(0, 0, b"\0", bytes([Flag.BREAK])))  # somebody is plugged in
    (hint,) = hints(counters, N81)
    assert "--format 8E1" in hint


def test_plenty_of_characters_and_no_telegram() -> None:
    assert hints(seen(b"x" * 499)) == []
    (hint,) = hints(seen(b"x" * 500))
    assert "no valid telegram" in hint and "--baud auto" in hint
    assert hints(seen(b"x" * 500 + TELEGRAMS["6-24"])) == []
    assert hints(seen(b"x" * 500), framing=Framing.SILENCE) == []


@pytest.mark.parametrize("line", [b"BCD:21\r", b"E3:>", b"S-0-0051,7,R\r\n", b"P-0-4006.1.2,7,w,>\r\n"])
def test_the_ascii_protocol(line: bytes) -> None:
    """Also between telegrams, in a rate that is searched, and before 500 characters have come."""
    (hint,) = hints(seen(TELEGRAMS["6-24"] + line))
    assert "--framing ascii" in hint
    assert hints(seen(line + b"x" * 500)) == [hint]
    scan = Scan()
    assert list(Hints(E81, Framing.SIS).look(seen(line), 1, scan)) == [hint]


@pytest.mark.parametrize("data", [b"BCD:2", b"E1234:>", b"S-0-0051", b"S-0-0051,8,R", b"E21", TELEGRAMS["6-24"] * 90])
def test_what_is_not_the_ascii_protocol(data: bytes) -> None:
    assert not any("ascii" in hint for hint in hints(seen(data)))


def test_damage_that_no_line_error_explains() -> None:
    """An adapter that reports errors would have: parity finds most damage."""
    good = TELEGRAMS["6-24"]
    damaged = good[:-1] + bytes([good[-1] ^ 1])
    counters = seen(damaged * 5)
    assert counters.damaged == 5
    assert hints(counters) == []
    (hint,) = Hints(E81, Framing.SIS, errors_reported=True).look(counters, 1)
    assert hint.startswith("5 damaged telegrams, and not one line error")
    counters.add_read(Read(0, 0, b"x", bytes([Flag.UNLOCATED_ERROR])))
    assert list(Hints(E81, Framing.SIS, errors_reported=True).look(counters, 1)) == []


def test_while_the_settings_are_searched_no_others_are_recommended() -> None:
    scan = Scan()
    assert list(Hints(E81, Framing.SIS).look(seen(b"x" * 600), 60, scan)) == []
    (hint,) = Hints(E81, Framing.SIS).look(seen(b""), 5, scan)
    assert "nothing received for 5 s" in hint and "the search goes on" in hint and "--baud" not in hint
    scan.in_vain = True
    (hint,) = Hints(E81, Framing.SIS).look(seen(b"x" * 600), 60, scan)
    assert "no valid telegram at any rate from 9600 to 115200 Bd" in hint and "the search goes on" in hint
    odd = seen(TELEGRAMS["6-24"] * 60, Flag.CHARACTER_ERROR)  # 8O1 read as 8E1: right characters, wrong parity
    (hint,) = Hints(E81, Framing.SIS).look(odd, 60, scan)
    assert "none without line errors" in hint and "--format 8O1" in hint


def test_each_is_given_once() -> None:
    giver = Hints(E81, Framing.SIS)
    assert len(list(giver.look(seen(b""), 5))) == 1
    assert list(giver.look(seen(b""), 6)) == []
    assert len(list(giver.look(seen(b"x" * 500), 7))) == 1


# -- Another program at the port ---------------------------------------------------------------------------------------

PORT = "/dev/ttyUSB0"
CAT = Others("cat (pid 4711, user nobody), end it with `kill 4711`")
HIDDEN = Others("", f"run `sistap doctor -i {PORT}` as root")


class Looks:
    """How often other programs were looked for."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, found: Others) -> None:
        self.count, self.found = 0, found
        monkeypatch.setattr(others, "look", self._look)

    def _look(self, port: str) -> Others:
        assert port == PORT
        self.count += 1
        return self.found


class Bus:
    """A bus whose telegrams reach the tap without some characters, or with some that are others."""

    def __init__(self) -> None:
        self.counters, self._framer, self._random = Counters(), SisFramer(0, E81), random.Random(1)
        self.hints = Hints(E81, Framing.SIS, port=PORT)
        self.said = list(self.hints.look(self.counters, 1))

    def send(
        self,
        count: int,
        *,
        lost: float = 0,
        damaged: float = 0,
        flag: int = 0,
        between: bytes = b"",
        searching: Scan | None = None,
    ) -> list[str]:
        """Send telegrams of the specification, with characters between them; return the hints."""
        for _ in range(count):
            sent = [one for one in self._random.choice(list(TELEGRAMS.values())) if self._random.random() >= lost]
            data = bytes(one ^ 8 if self._random.random() < damaged else one for one in sent) + between
            read = Read(0, 0, data, bytes([flag]) * len(data))
            self.counters.add_read(read)
            for record in self._framer.feed(read):
                self.counters.add_record(record)
        return list(self.hints.look(self.counters, 2, searching))


@pytest.mark.parametrize("lost", [0.02, 0.05, 0.1, 0.2])
def test_pieces_of_telegrams_without_a_line_error_are_read_by_another_program(
    monkeypatch: pytest.MonkeyPatch, lost: float
) -> None:
    looks, bus = Looks(monkeypatch, CAT), Bus()
    assert bus.send(100) == [] and looks.count == 0
    assert bus.send(150, lost=lost) == [f"another program may read {PORT}: {CAT.known}"]
    assert bus.send(100, lost=lost) == [] and looks.count == 1


def test_if_other_programs_are_hidden_the_hint_says_how_to_find_them(monkeypatch: pytest.MonkeyPatch) -> None:
    Looks(monkeypatch, HIDDEN)
    assert Bus().send(100, lost=0.1) == [f"another program may read {PORT}: run `sistap doctor -i {PORT}` as root"]


def test_if_nobody_else_has_the_port_pieces_are_no_hint(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = Looks(monkeypatch, Others())
    assert Bus().send(100, lost=0.1) == [] and looks.count == 1


def test_noise_line_errors_and_single_pieces_are_not_another_program(monkeypatch: pytest.MonkeyPatch) -> None:
    looks = Looks(monkeypatch, CAT)
    assert Bus().send(200, damaged=0.05) == []
    noisy = Bus()
    noisy.send(1)
    noisy.send(1, flag=Flag.CHARACTER_ERROR)
    assert noisy.send(100, lost=0.1) == []
    assert Bus().send(2000, lost=0.001) == []  # 11 characters each: 1 % of the telegrams
    turning = Bus()
    assert [turning.send(1, between=b"\0") for _ in range(50)] == [[]] * 50  # as where a line changes direction
    assert looks.count == 0


def test_a_program_that_comes_late_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    looks, bus = Looks(monkeypatch, CAT), Bus()
    assert bus.send(5000) == [] and looks.count == 0
    assert len(bus.send(60, lost=0.1)) == 1 == looks.count


def test_silence_and_a_few_characters_are_looked_into(monkeypatch: pytest.MonkeyPatch) -> None:
    """`cat` leaves 1 of 1,600 characters. Where programs are hidden, a silent bus is the better guess."""
    looks = Looks(monkeypatch, CAT)
    for data in (b"", bytes.fromhex("6C 00 00")):
        giver, counters = Hints(E81, Framing.SIS, port=PORT), seen(data)
        assert list(giver.look(counters, 4.9)) == []
        assert next(giver.look(counters, 5)) == f"another program may read {PORT}: {CAT.known}"
    looks.found = HIDDEN
    for data in (b"", bytes.fromhex("6C 00 00")):
        assert not any("program" in hint for hint in Hints(E81, Framing.SIS, port=PORT).look(seen(data), 5))


def test_at_the_end_it_is_looked_for_once_more(monkeypatch: pytest.MonkeyPatch) -> None:
    looks, bus = Looks(monkeypatch, CAT), Bus()
    assert bus.hints.sharing(bus.counters, 2, anew=True) == ""
    bus.send(100, lost=0.1)
    assert "cat" in bus.hints.sharing(bus.counters, 3, anew=True)
    looks.found = Others()
    assert bus.hints.sharing(bus.counters, 3, anew=True) == ""


def test_while_the_rate_is_searched_pieces_are_no_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    looks, bus = Looks(monkeypatch, CAT), Bus()
    assert bus.send(100, lost=0.1, searching=Scan()) == [] and looks.count == 0
    assert bus.send(100) == [] and looks.count == 0
