# SPDX-License-Identifier: GPL-2.0-or-later
"""The ear of a slave: characters with their times in, commands out (IF02 chapters 2.4, 10.3 and 10.5).

It knows no clock: every call says what time it is.
"""

from __future__ import annotations

from sistap.sis.telegram import MAX_LENGTH, START, STATIC_LENGTH, checksum_good

_LENGTHS = 4  # characters after which both lengths are there


class Receiver:
    """Cuts telegrams as a station does, by silence and by the lengths; how good they are is for others to judge."""

    def __init__(self) -> None:
        self._heard = bytearray()  # the telegram so far; empty: waiting for a start
        self._alternative: int | None = None  # where in it another telegram may have begun
        self._last_ns: int | None = None  # when the last character came

    def hear(self, value: int, time_ns: int, tza_ns: int) -> bytes | None:
        """Take a character; gives the telegram that it completes, or what cannot become one and is over now."""
        silent = self._last_ns is None or time_ns - self._last_ns > tza_ns
        self._last_ns = time_ns
        over = self._take() if silent and self._hopeless else None
        if self._heard:
            self._go_on(value, silent)
        elif silent:  # a start is recognised only after a silence longer than TzA
            self._heard.append(value)
        return self._take() if self._complete else over

    def silence_ends_ns(self, tza_ns: int) -> int | None:
        """Return when what cannot become a telegram is over, if no more characters come; None if nothing waits."""
        return self._last_ns + tza_ns if self._last_ns is not None and self._hopeless else None

    def silence(self, now_ns: int, tza_ns: int) -> bytes | None:
        """Return what cannot become a telegram, if it is over."""
        ends_ns = self.silence_ends_ns(tza_ns)
        return self._take() if ends_ns is not None and now_ns >= ends_ns else None

    def _go_on(self, value: int, silent: bool) -> None:
        """Take one more character; after a pause that was too long, another telegram may begin with it."""
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
        """Whether it has no start character, or two lengths that differ: then only a silence ends it."""
        heard = self._heard
        return bool(heard) and (heard[0] != START or (len(heard) >= _LENGTHS and heard[2] != heard[3]))

    def _take(self) -> bytes:
        heard, self._heard, self._alternative = bytes(self._heard), bytearray(), None
        return heard
