# SPDX-License-Identifier: GPL-2.0-or-later
"""Hits become episodes: joined, bounded, and found by a display filter."""

from __future__ import annotations

from typing import Any

import pytest

from sistap.dissected.episodes.book import MOST, MOST_PAGES, Book
from sistap.dissected.episodes.episode import PACKETS, Episode, Hit
from sistap.dissected.episodes.rules import RULES


def hit(second: float, kind: str = "late", **more: Any) -> Hit:
    return Hit(kind, int(second) + 1, second, second, 3)._replace(**more)


def test_hits_soon_after_one_another_are_one_episode_of_the_worst() -> None:
    book = Book()
    assert len(book.add(hit(second, worst=second) for second in (0, 25, 50, 500))) == 2
    first, last = book.episodes()
    assert (first.count, first.from_s, first.to_s, first.hit.worst) == (3, 0, 50, 50)
    assert (last.count, last.packets, last.filter) == (1, [501], "frame.number in {501}")


@pytest.mark.parametrize(
    ("kinds", "apart_s", "count"),
    [
        ("silent fault warning", 4, 1),
        ("silent fault warning", 6, 2),
        ("damaged line_error repeated unanswered interval cycle busy step unreadable", 25, 1),
        ("damaged line_error repeated unanswered interval cycle busy step unreadable", 35, 2),
        ("system_error warning_bit beyond apart again lost", 50, 1),
        ("system_error warning_bit beyond apart again lost", 70, 2),
        ("late error", 250, 1),
        ("late error", 350, 2),
        ("write master early", 500, 1),
        ("write master early", 700, 2),
        ("foreign rhythm never conflict unexpected against", 80_000, 1),  # all day
        ("bus_silent gap off boot stopped vanished restart homing stuck changed chatter slower drift", 1, 2),  # states
        ("exchanged other limit_write phase rate limits recipe clock estop blip adapter", 1, 2),
    ],
)
def test_hits_of_a_kind_are_one_for_so_long(kinds: str, apart_s: float, count: int) -> None:
    for kind in kinds.split():
        assert len(Book().add((hit(0, kind), hit(apart_s, kind)))) == count, kind


def test_the_memory_of_a_month_of_hits_is_bounded() -> None:
    book = Book()
    book.add(hit(100.0 * number, "bus_silent") for number in range(30_000))
    episodes = book.episodes()
    assert len(episodes) <= MOST
    assert sum(episode.count for episode in episodes) == 30_000
    assert all(len(episode.packets) <= PACKETS for episode in episodes)
    assert (episodes[0].from_s, episodes[-1].to_s) == (0, 2_999_900)


def test_many_hits_are_joined_with_their_nearest() -> None:
    """Thirty times two, a second apart: still thirty, each with its time."""
    book = Book()
    book.add(hit(3600.0 * number + second, "bus_silent") for number in range(30) for second in (0, 1))
    assert [(one.from_s, one.count) for one in book.episodes()] == [(3600.0 * number, 2) for number in range(30)]


def test_hits_with_more_topics_than_are_remembered_are_counted() -> None:
    book = Book()
    book.add(hit(float(number), "never", topic=str(number)) for number in range(MOST_PAGES + 9))
    assert [one.count for one in book.episodes()[-2:]] == [1, 9]


def test_an_episode_goes_on_soon_after_its_end() -> None:
    for begins_s, count in ((104.0, 1), (106.0, 2), (-4.0, 1), (-9.0, 2)):  # a clock may be set back
        book = Book()
        book.add([hit(0, "silent", to_s=100.0), hit(begins_s, "silent", to_s=begins_s + 3)])
        assert len(book.episodes()) == count


def test_episodes_are_in_the_order_of_their_beginning() -> None:
    book = Book()
    book.add([hit(7), hit(3, "silent"), hit(5, "damaged")])
    assert [one.from_s for one in book.episodes()] == [3, 5, 7]


def test_the_filter_of_a_silence_finds_all_of_it() -> None:
    silent = Episode.of(Hit("silent", 7, 100.0, 190.0, 4))
    assert (
        silent.filter
        == f"frame.time_epoch >= 99.999998 && frame.time_epoch <= 190.000002 && ({RULES['silent'].filter})"
    )
    assert Episode.of(Hit("silent", 7, 100.0, 100.5, 4)).filter == "frame.number in {7}"
    assert Episode.of(Hit("bus_silent", 7, 100.0, 190.0)).filter == "frame.number in {7}"  # no packet is in it


def test_what_is_joined_counts_all_of_both() -> None:
    first, second = (Episode.of(hit(second)) for second in (0, 100))
    first.count, second.count, second.outcome = 4, 5, "not heard again"
    first.join(second)
    assert (first.count, first.outcome) == (9, "not heard again")
