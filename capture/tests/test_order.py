# SPDX-License-Identifier: GPL-2.0-or-later
"""Records of two lines: in order of their first characters, and none waits long."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sistap.tap.line.settings import LineSettings
from sistap.tap.records.assembler import HOLD_NS, Order
from sistap.tap.records.record import Record, Type

pytestmark = pytest.mark.tap

MS = 1_000_000


def record(time_ns: int, line: int = 1) -> Record:
    return Record(time_ns, Type.FRAME, line, LineSettings(), b"x", [0], b"\0")


def test_a_record_waits_for_a_telegram_that_began_before_it() -> None:
    order = Order()
    order.add([record(20, line=2)], 0)
    assert list(order.due([10, None], 0)) == []
    assert not order.empty
    order.add([record(10, line=1)], 5 * MS)
    assert [r.time_ns for r in order.due([None, 30], 5 * MS)] == [10, 20]
    assert order.empty


def test_nothing_waits_where_nothing_is_unfinished() -> None:
    order = Order()
    order.add([record(20)], 0)
    assert [r.time_ns for r in order.due([None, None], 0)] == [20]


def test_no_longer_than_half_a_second_and_only_what_waited_so_long() -> None:
    assert HOLD_NS == 500 * MS
    order = Order()
    order.add([record(20)], 0)
    order.add([record(30)], 400 * MS)
    assert list(order.due([10], 499 * MS)) == []
    assert [r.time_ns for r in order.due([10], 500 * MS)] == [20]
    assert [r.time_ns for r in order.due([10], 900 * MS)] == [30]


def test_from_the_first_moment_on_only_the_unfinished_counts() -> None:
    order = Order()
    order.add([record(1)], 0)
    assert list(order.due([0], 0)) == []


def test_records_of_one_time_stay_as_they_came() -> None:
    order = Order()
    order.add([record(20, line) for line in (2, 1, 2)], 0)
    assert [r.line for r in order.due([], 0)] == [2, 1, 2]


@given(st.lists(st.tuples(st.integers(0, 50), st.integers(0, 50)), max_size=60))
def test_all_come_out_once_and_in_order(telegrams: list[tuple[int, int]]) -> None:
    """Each begins and lasts; it becomes a record when it ends."""
    order = Order()
    out: list[int] = []
    begins = sorted((begin, begin + lasts) for begin, lasts in telegrams)
    for now in sorted({end for _, end in begins}):
        order.add([record(begin) for begin, end in begins if end == now], now)
        unfinished = min((begin for begin, end in begins if begin <= now < end), default=None)
        out += [r.time_ns for r in order.due([unfinished], now)]
    assert out == [begin for begin, _ in begins]
