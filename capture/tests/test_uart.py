# SPDX-License-Identifier: GPL-2.0-or-later
"""Samples of a line become characters; the sent characters are rendered bit by bit (sampled_wire.py)."""

from __future__ import annotations

from fractions import Fraction

import pytest
from sampled_wire import NS, Sent, sampled

from sistap.tap.analyser.finding import Trace, find
from sistap.tap.analyser.uart import Edges, Sampled, Uart
from sistap.tap.line.settings import Flag, LineSettings

RATE = 1_000_000
BAD, BREAK, GOOD = Flag.CHARACTER_ERROR, Flag.BREAK, Flag(0)


def text(samples: bytes) -> bytes:
    return samples.translate(bytes(b"01"[value & 1] for value in range(256)))


def heard(samples: bytes, settings: LineSettings, step: int = 1 << 30) -> list[Sampled]:
    uart, edges = Uart(RATE, settings), Edges()
    written = text(samples)
    return [
        one
        for at in range(0, len(written), step)
        for one in uart.feed(edges.feed(written[at : at + step]), min(at + step, len(written)))
    ]


def spaced(values: bytes, settings: LineSettings, pause_bits: int = 0, **what: object) -> list[Sent]:
    """Characters one after the other, from 1 ms on."""
    bit_ns = Fraction(NS, settings.baud)
    step_ns = settings.character_ns + pause_bits * bit_ns
    to_stop_ns = bit_ns * (1 + settings.data_bits + (settings.parity != "N") + Fraction(1, 2))
    return [
        Sent(1_000_000 + number * step_ns + to_stop_ns, value, settings, **what)  # type: ignore[arg-type]
        for number, value in enumerate(values)
    ]


ALL = bytes(range(256))


@pytest.mark.parametrize("text_", ["8E1", "8N1", "8O1", "8N2", "8M1", "8S1", "7E1", "5N1.5"])
@pytest.mark.parametrize("baud", [9600, 38400, 50000])
def test_every_value_in_every_format_at_its_time(baud: int, text_: str) -> None:
    settings = LineSettings.parse(baud, text_)
    sent = spaced(bytes(range(2**settings.data_bits)), settings)
    found = heard(sampled([sent], RATE, int(sent[-1].time_ns) + 2_000_000), settings)
    stop_ns = Uart(RATE, settings).stop_ns
    assert [(one.value, one.flag) for one in found] == [(one.value, GOOD) for one in sent]
    # A sample is late by less than its own time: 1 us.
    assert all(-1 <= one.start * 1000 + stop_ns - was.time_ns <= 1001 for one, was in zip(found, sent, strict=True))


@pytest.mark.parametrize("step", [1, 7, 1000])
def test_it_does_not_matter_how_samples_come(step: int) -> None:
    settings = LineSettings(38400)
    sent = spaced(ALL[:40], settings)
    samples = sampled([sent], RATE, int(sent[-1].time_ns) + 2_000_000)
    assert heard(samples, settings, step) == heard(samples, settings)


def test_errors_are_at_their_character() -> None:
    settings = LineSettings(9600)
    good = spaced(b"abcdef", settings, pause_bits=3)
    sent = [
        good[0],
        good[1]._replace(flag=BAD),
        good[2]._replace(flag=BAD, without_stop=True),
        good[3]._replace(flag=BREAK),
        *good[4:],
    ]
    found = heard(sampled([sent], RATE, 10_000_000), settings)
    assert [(one.value, one.flag) for one in found] == [
        (ord("a"), GOOD),
        (ord("b"), BAD),
        (ord("c"), BAD),
        (0, BREAK),
        (ord("e"), GOOD),
        (ord("f"), GOOD),
    ]


def test_a_break_is_one_however_long() -> None:
    settings = LineSettings(9600)
    samples = bytes([1]) * 1000 + bytes(200_000) + bytes([1]) * 1000
    assert [(one.start, one.value, one.flag) for one in heard(samples, settings)] == [(1000, 0, BREAK)]


def test_a_glitch_is_no_character_and_spoils_none() -> None:
    settings = LineSettings(9600)
    sent = spaced(b"ab", settings, pause_bits=20)
    glitches = [(Fraction(500_000), 40), (sent[0].time_ns + 400_000, 3)]
    found = heard(sampled([sent], RATE, 6_000_000, glitches), settings)
    assert [one.value for one in found] == list(b"ab")


def test_it_begins_in_mid_character() -> None:
    settings = LineSettings(9600)
    sent = spaced(b"\0\0a", settings, pause_bits=15)
    samples = sampled([sent], RATE, 8_000_000)[1500:]
    assert [one.value for one in heard(samples, settings)] == [0, ord("a")]


def test_other_settings_hold_from_the_next_character_on() -> None:
    slow, fast = LineSettings(9600), LineSettings(38400, parity="N")
    first = spaced(b"ab", slow)
    second = [one._replace(time_ns=one.time_ns + 5_000_000) for one in spaced(b"cd", fast)]
    samples = text(sampled([first + second], RATE, 8_000_000))
    uart, edges = Uart(RATE, slow), Edges()
    found = list(uart.feed(edges.feed(samples[:5_000]), edges.now))
    uart.set(fast)
    found += uart.feed(edges.feed(samples[5_000:]), edges.now)
    assert bytes(one.value for one in found) == b"abcd"
    assert edges.now == len(samples)


def line(samples: bytes) -> Trace:
    edges = Edges()
    return Trace(edges.feed(text(samples)), is_high=False, end=edges.now)


@pytest.mark.parametrize("samples", [b"", b"1" * 1000, b"0" * 1000, b"1" * 10 + b"0" + b"1" * 10, b"10" * 999])
def test_without_characters_there_are_no_settings(samples: bytes) -> None:
    assert find(line(samples), RATE) is None
