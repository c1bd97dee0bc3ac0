# SPDX-License-Identifier: GPL-2.0-or-later
"""The receiver of a slave: characters with their times in, commands out (IF02 chapters 2.4, 10.3 and 10.5).

It has no clock: every call passes the time.
"""

from __future__ import annotations

from sistap.tap.sis.telegram import MAX_LENGTH, START, STATIC_LENGTH, checksum_good

_LENGTHS = 4  # characters up to both lengths


class Receiver:
    """Cuts telegrams as a station does, by silence and by the lengths, without checking them."""

    def __init__(self) -> None:
        self._heard = bytearray()  # the telegram so far; empty: waiting for a start
        self._alternative: int | None = None  # where another telegram may have begun in it
        self._last_ns: int | None = None  # when the last character came

    def hear(self, value: int, time_ns: int, tza_ns: int) -> bytes | None:
        """Take a character; return the telegram that it completes, or characters that cannot become one and have
        ended.
        """
        silent = self._last_ns is None or time_ns - self._last_ns > tza_ns
        self._last_ns = time_ns
        over = self._take() if silent and self._hopeless else None
        if self._heard:
            self._go_on(value, silent)
        elif silent:  # a start is recognised only after a silence longer than TzA
            self._heard.append(value)
        return self._take() if self._complete else over

    def silence_ends_ns(self, tza_ns: int) -> int | None:
        """Return when characters that cannot become a telegram end in silence; None if nothing waits."""
        return self._last_ns + tza_ns if self._last_ns is not None and self._hopeless else None

    def silence(self, now_ns: int, tza_ns: int) -> bytes | None:
        """Return characters that cannot become a telegram, if they have ended."""
        ends_ns = self.silence_ends_ns(tza_ns)
        return self._take() if ends_ns is not None and now_ns >= ends_ns else None

    def _go_on(self, value: int, silent: bool) -> None:
        """Take one more character; after too long a pause, another telegram may begin with it."""
        if silent and value == START:
            self._alternative = len(self._heard)
        if len(self._heard) < MAX_LENGTH:
            self._heard.append(value)
        if self._alternative is None:
            return
        begin = self._heard[self._alternative :]
        if len(begin) == _LENGTHS:
            self._alternative = None
            if begin[2] == begin[3]:
                self._heard = begin
        elif self._complete and not checksum_good(self._heard):
            self._heard, self._alternative = begin, None

    @property
    def _complete(self) -> bool:
        heard = self._heard
        return len(heard) >= STATIC_LENGTH and len(heard) == STATIC_LENGTH + heard[3] and not self._hopeless

    @property
    def _hopeless(self) -> bool:
        """Tell whether it lacks a start character or its lengths differ: then only silence ends it."""
        heard = self._heard
        return bool(heard) and (heard[0] != START or (len(heard) >= _LENGTHS and heard[2] != heard[3]))

    def _take(self) -> bytes:
        heard, self._heard, self._alternative = bytes(self._heard), bytearray(), None
        return heard
