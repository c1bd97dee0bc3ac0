# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes episodes of hits: those of one kind, station and topic that come soon after one another are one."""

from __future__ import annotations

from collections.abc import Iterable

from sistap.dissected.episodes.episode import Episode, Hit
from sistap.dissected.episodes.rules import RULES

MOST = 40  # episodes of one kind, station and topic; more are joined with their neighbours
MOST_PAGES = 2000

_Key = tuple[str, str, int | None, str]


class _Page:
    """The episodes of one kind, station and topic."""

    def __init__(self, join_s: float) -> None:
        self._join_s = join_s
        self.episodes: list[Episode] = []

    def add(self, episode: Episode) -> bool:
        """Add one; tell whether it is new."""
        is_new = self._put(self.episodes, episode)
        while len(self.episodes) > MOST:
            self._join_s = max(2 * self._join_s, 1.0)
            joined: list[Episode] = []
            for one in self.episodes:
                self._put(joined, one)
            self.episodes = joined
        return is_new

    def _put(self, episodes: list[Episode], episode: Episode) -> bool:
        last = episodes[-1] if episodes else None
        if last and self._join_s and max(episode.from_s - last.to_s, last.from_s - episode.to_s) < self._join_s:
            last.join(episode)
            return False
        episodes.append(episode)
        return True


class Book:
    """All episodes, in bounded memory."""

    def __init__(self) -> None:
        """Begin with none."""
        self._pages: dict[_Key, _Page] = {}

    def add(self, hits: Iterable[Hit]) -> list[Episode]:
        """Note hits; return the episodes that begin with them."""
        return [episode for hit in hits if self._page(hit).add(episode := Episode.of(hit))]

    def _page(self, hit: Hit) -> _Page:
        key = hit.kind, hit.port, hit.station, hit.topic
        if key not in self._pages and len(self._pages) >= MOST_PAGES:
            key = hit.kind, "", None, ""
        if key not in self._pages:
            self._pages[key] = _Page(RULES[hit.kind].join_s)
        return self._pages[key]

    def episodes(self) -> list[Episode]:
        """Return all, in the order of their beginning."""
        found = [episode for page in self._pages.values() for episode in page.episodes]
        return sorted(found, key=lambda episode: episode.from_s)
