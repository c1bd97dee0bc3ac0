# SPDX-License-Identifier: GPL-2.0-or-later
"""Time stamps: forms, zones, dates that are said once, midnight."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime

import pytest
from portable import BERLIN, posix, zone

from sistap.commands.annotate.stamps import TimestampParser


@pytest.fixture(autouse=True)
def _berlin(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    yield from zone(monkeypatch, BERLIN)


def read(clock: TimestampParser, text: str) -> str:
    """Return the first stamp of a text in UTC."""
    ns = clock.find(text)[0].stamp.time_ns
    return datetime.fromtimestamp(ns // 10**9, UTC).strftime("%Y-%m-%d %H:%M:%S") + f".{ns % 10**9:09d}"


@pytest.mark.parametrize(
    ("text", "utc"),
    [
        ("2013-03-14 08:21:14", "2013-03-14 07:21:14.000000000"),
        pytest.param(
            "2013-07-14T08:21:14.5", "2013-07-14 06:21:14.500000000", marks=posix("no rules of summer time in TZ")
        ),
        ("2013/03/14_08:21:14,541", "2013-03-14 07:21:14.541000000"),
        ("2013-03-14 08:21:14.038749996+01:00", "2013-03-14 07:21:14.038749996"),
        ("2013-03-14 08:21:14.038749996-0130", "2013-03-14 09:51:14.038749996"),
        ("2013-03-14T08:21:14Z", "2013-03-14 08:21:14.000000000"),
        ("14.03.2013 08:21:14.541", "2013-03-14 07:21:14.541000000"),
        ("14.3.13 8:21:14", "2013-03-14 07:21:14.000000000"),
        ("3/14/2013 8:21:14.541 PM", "2013-03-14 19:21:14.541000000"),
        ("3/14/2013 12:00:01 AM", "2013-03-13 23:00:01.000000000"),
        ("3/14/2013 12:00:01 p.m.", "2013-03-14 11:00:01.000000000"),
        ("3/14/2013 4:30:30 PM.34364", "2013-03-14 15:30:30.343640000"),
        ("14/3/2013 8:21:14", "2013-03-14 07:21:14.000000000"),  # there is no 14th month
        ("14 Mar 2013 08:21:14:541", "2013-03-14 07:21:14.541000000"),
        ("(1363245674.541001)", "2013-03-14 07:21:14.541001000"),
        ("   12.345678 TX", "1970-01-01 00:00:12.345678000"),
        ("[08:21:14.541]", "1970-01-02 07:21:14.541000000"),
        ("2013-03-14:08:21:14.541000: write", "2013-03-14 07:21:14.541000000"),
        ("[08:21 14.541000]> 02", "1970-01-02 07:21:14.541000000"),
        ("[08:21:14.541,001] <dbg> x", "1970-01-02 07:21:14.541001000"),
        ("12,345678;TxD;02", "1970-01-01 00:00:12.345678000"),
        ('{"ts": 1363245674541, "dir": "tx"}', "2013-03-14 07:21:14.541000000"),
        ('sis data="026c" 1363245674541001002', "2013-03-14 07:21:14.541001002"),
    ],
)
def test_forms(text: str, utc: str) -> None:
    assert read(TimestampParser(), text) == utc


@pytest.mark.parametrize(
    ("text", "resolution_ns"),
    [
        ("08:21:14", 10**9),
        ("08:21:14.5", 10**8),
        ("08:21:14.541", 10**6),
        ("08:21:14.038749996", 1),
        ("1.250 x", 10**6),
    ],
)
def test_steps(text: str, resolution_ns: int) -> None:
    assert TimestampParser().find(text)[0].stamp.resolution_ns == resolution_ns


@pytest.mark.parametrize(
    "text",
    [
        *("24:00:00", "08:60:00", "13:00:00 PM", "2013-02-30 08:00:00", "02:05:05:02:03:10", "62:D9:00:00"),
        *("11:00 02 56", "1363249274541001", "1.2.3", "12.5", ""),
    ],
)
def test_what_is_no_time(text: str) -> None:
    assert TimestampParser().find(text) == []


def test_bytes_behind_a_comma_are_no_fraction() -> None:
    [stamped] = TimestampParser().find("08:21:14,02,E1,05")
    assert (stamped.start, stamped.end) == (0, 8)


def test_a_date_holds_on_and_midnight_is_the_next_day() -> None:
    clock = TimestampParser()
    assert read(clock, "2013-12-31 23:59:59.9") == "2013-12-31 22:59:59.900000000"
    assert read(clock, "00:00:00.1") == "2013-12-31 23:00:00.100000000"
    assert read(clock, "00:00:00.0") == "2013-12-31 23:00:00.000000000"  # a little back is not a day


def test_a_date_in_the_heading() -> None:
    clock = TimestampParser()
    assert clock.find_date("Log of 14.03.2013") is not None
    assert read(clock, "08:21:14") == "2013-03-14 07:21:14.000000000"
    assert TimestampParser().find_date("version 1.2.3.4, 99.99.2013") is None
