# SPDX-License-Identifier: GPL-2.0-or-later
"""Several subservices in one telegram of service 0x03: both layouts, what is refused, and when they become valid."""

from __future__ import annotations

import pytest
from test_stations import ask, drive, octets

NOBODY_SAID = (9600, None, None, None)  # rate, TrS, TzA, Tmas


def test_the_address_once_before_all_of_them() -> None:
    slave = drive()
    # TrS 50 ms and TzA 5 ms. Checksums by hand: the command's other bytes add up to 63, those of the reaction to 36.
    assert slave.react(octets("02 9D 07 07 00 03 10 03 03 01 32 00 02 05 00"), 0) == octets(
        "02 CA 04 04 10 03 10 03 00 03 01 02"
    )
    assert ask(slave, 0x03, "03 03 F4 01 07 02") == "00 03 03 07"
    assert slave.initialization.timing(0) == NOBODY_SAID
    assert ask(slave, 0x03, "03 FF") == "00 03 FF"
    assert slave.initialization.timing(0) == (38400, 50, 5, 500)


def test_the_address_before_each_of_them() -> None:
    slave = drive()
    assert ask(slave, 0x03, "03 01 32 00 03 02 05 00 03 03 F4 01") == "00 03 01 03 02 03 03"
    assert ask(slave, 0x03, "03 07 02") == "00 03 07"  # one alone is the same in both layouts
    assert slave.initialization.timing(0) == NOBODY_SAID
    assert ask(slave, 0x03, "03 FF") == "00 03 FF"
    assert slave.initialization.timing(0) == (38400, 50, 5, 500)


@pytest.mark.parametrize(
    ("body", "answer"),
    [("03 01 32 00 07 08 FF", "00 03 01 07 FF"), ("03 07 08 03 01 32 00 03 FF", "00 03 07 03 01 03 FF")],
)
def test_accept_may_be_the_last_of_them(body: str, answer: str) -> None:
    slave = drive()
    assert ask(slave, 0x03, body) == answer
    assert slave.initialization.timing(0) == (115200, 50, None, None)


def test_all_of_them_by_broadcast() -> None:
    slave = drive()
    assert ask(slave, 0x03, "00 01 32 00 02 05 00 FF", receiver=255) == "none"
    assert slave.initialization.timing(0) == (9600, 50, 5, None)


@pytest.mark.parametrize(
    ("body", "answer"),
    [
        # "03" is another address or the subservice Tmas: TrS and then 115200 Bd, or TrS and then Tmas 2055 ms
        ("03 01 32 00 03 07 08", "F1 03 01"),
        ("03 01 32 00 06 C8 01", "FB 03 01"),  # a multicast group: how long its data are nobody says
        ("03 01 32 00 02 05", "FA 03 01"),
        ("03 01 32 00 03", "FA 03 01"),
        ("03 07 02 03 06", "FB 03 07"),  # that with the addresses goes further, to subservice 06
        ("03 01 32 00 04 02 05 00", "FB 03 01"),  # the address of another
        ("03 06 01", "FB 03 06"),
        ("03 01 32", "FA 03 01"),
        ("03", "FA 03"),
    ],
)
def test_what_no_layout_or_each_of_them_could_mean_is_refused(body: str, answer: str) -> None:
    slave = drive()
    assert ask(slave, 0x03, body) == answer
    assert ask(slave, 0x03, "03 FF") == "00 03 FF"
    assert slave.initialization.timing(0) == NOBODY_SAID


@pytest.mark.parametrize("body", ["03 01 32 00 07 03 02 05 00", "03 01 32 00 03 07 03 03 02 05 00"])
def test_the_reaction_names_the_subservice_that_failed(body: str) -> None:
    slave = drive()
    assert ask(slave, 0x03, body) == "01 03 07 00"  # two rates ORed
    assert ask(slave, 0x03, "03 FF") == "00 03 FF"
    assert slave.initialization.timing(0) == (9600, 50, None, None)  # what was before it was done, and no more
