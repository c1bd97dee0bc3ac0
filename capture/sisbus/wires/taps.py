# SPDX-License-Identifier: GPL-2.0-or-later
"""The bus at a socket: taps connect, send their line settings and get reads with times and errors
(sistap.tap.wire.protocol).

A tap that stops reading delays the bus once the buffers are full, and so loses nothing. After PATIENCE_S it is
disconnected.
"""

from __future__ import annotations

import random
import socket
import sys
from collections.abc import Callable, Sequence

from sisbus.playing.characters import TIMING, Played, SentCharacter, reads, received, uncertainty
from sisbus.wires.wire import Pace
from sistap.tap.line.clock import CLOCK, monotonic_ns
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.terminal.console import visible
from sistap.tap.wire import protocol
from sistap.tap.wire.server import Peer, Peers

PATIENCE_S = 30.0  # for a tap that does not read, or does not answer
INTRODUCTION_S = 10.0  # for a new connection to send line settings

_ROOM = 1 << 16  # bytes that may wait for a tap before the bus waits
_TICK_NS = 1_000_000_000  # longest step of simulated time that a tap is told
_LOOK_S = 1.0
_SLACK_S = 0.005  # end of a bus pause in which taps are not served


class ConnectedTap(Peer):
    """One connected tap."""

    def __init__(self, connection: socket.socket, seed: int) -> None:
        super().__init__(connection)
        self.settings: LineSettings | None = None
        self._noise = random.Random(f"{seed} tap")
        self._decoder = protocol.Decoder(protocol.FROM_LISTENER)
        self._dealt_with_ns: int | None = None  # everything before this; None: this tap does not say
        self._told_ns = 0  # nothing arrives before this, as it was told

    @property
    def full(self) -> bool:
        """Tell whether the bus must wait for it to read."""
        return self.waiting > _ROOM

    @property
    def owes_an_answer(self) -> bool:
        """Tell whether it was told a time and has not yet confirmed it."""
        return self._dealt_with_ns is not None and self._dealt_with_ns < self._told_ns

    def take(self, data: bytes) -> None:
        """Take what it sends. ValueError if it uses another protocol."""
        for message in self._decoder.feed(data):
            if isinstance(message, LineSettings):
                self.settings = message
                self.put(protocol.pack_settings(message))
            elif isinstance(message, protocol.Time):
                self._dealt_with_ns = message.time_ns

    def tell(self, wall_ns: int) -> None:
        """Tell it that nothing arrives before this time, if it asks for times."""
        if self._dealt_with_ns is not None:
            self._told_ns = wall_ns
            self.put(protocol.pack_time(wall_ns))

    def play(self, read: Sequence[SentCharacter], played: Played, wall_ns: int) -> None:
        """Send one read of what was played, heard with the tap's own settings."""
        if self.settings is None:
            return
        heard = [received(character, played.settings, self.settings, self._noise) for character in read]
        values, flags = bytes(value for value, _ in heard), bytes(flag for _, flag in heard)
        uncertainty_ns = max(uncertainty(read), played.uncertainty_ns)
        self.put(protocol.pack_read(Read(played.line, wall_ns, values, flags, uncertainty_ns)))


class Taps:
    """A listening socket and the connected taps."""

    def __init__(  # noqa: PLR0913 - the bus, and how it is heard
        self, pace: Pace, address: str, seed: int, most: int
    ) -> None:
        """Listen at HOST:PORT or at a PATH; reads have `most` characters. Raise OSError; or ValueError for an
        invalid address.
        """
        self._pace = pace
        self._seed = seed
        self._now = 0  # the time that taps know
        self._most = most
        self._peers = Peers(address, self._welcome, _say)
        self.name = self._peers.name

    @property
    def deserted(self) -> bool:
        """Tell whether the last tap has left. Then simulated time stops; real time goes on."""
        return self._pace.simulated and not self._heard

    def wait_for_listener(self) -> None:
        """Wait until a tap has sent its settings."""
        while not self._heard:
            self._attend(_LOOK_S)
        self._pace.start()

    def deliver(self, played: Played) -> list[str]:
        """Send all reads at their times."""
        line = played.settings
        self._attend(0)
        if self._pace.simulated:
            self._pass_time(played.time_ns - line.character_ns)
        for read in reads(played.characters, self._most, line.character_ns):
            time_ns = read[-1].time_ns
            if not self._pace.simulated:
                self._wait_until(time_ns)
            for tap in self._peers:
                tap.play(read, played, self._pace.wall_ns(time_ns))
            self._peers.send()
            self._wait_for(lambda tap: tap.full)
            self._now = time_ns
        return []

    def close(self) -> None:
        """End all connections."""
        self._peers.close()

    def _welcome(self, connection: socket.socket) -> ConnectedTap:
        tap = ConnectedTap(connection, self._seed)
        now_ns = self._pace.wall_ns(self._now) if self._pace.simulated else CLOCK.now_ns()
        hello = protocol.Hello(now_ns, "virtual bus", TIMING)
        tap.put(protocol.pack_hello(hello))
        return tap

    def _wait_until(self, time_ns: int) -> None:
        """Wait for a time while serving taps."""
        while (left_s := self._pace.left_s(time_ns) - _SLACK_S) > 0:
            self._attend(min(left_s, _LOOK_S))
        self._pace.wait_until(time_ns)
        self._attend(0)

    def _pass_time(self, until_ns: int) -> None:
        """Advance simulated time, together with the taps that ask for it."""
        while self._now < until_ns:
            self._now = min(self._now + _TICK_NS, until_ns)
            for tap in self._peers:
                tap.tell(self._pace.wall_ns(self._now))
            self._wait_for(lambda tap: tap.owes_an_answer)

    def _wait_for(self, behind: Callable[[ConnectedTap], bool]) -> None:
        """Wait until no tap is behind; disconnect those that stay behind."""
        end_ns = monotonic_ns() + int(PATIENCE_S * 1e9)
        while any(map(behind, self._peers)):
            left_ns = end_ns - monotonic_ns()
            if left_ns > 0:
                self._peers.attend(left_ns / 1e9)
                continue
            for tap in filter(behind, self._peers):
                self._peers.drop(tap, f"a tap has not read for {PATIENCE_S:g} s")

    @property
    def _heard(self) -> bool:
        """Tell whether any connection has turned out to be a tap."""
        return any(tap.settings for tap in self._peers)

    def _attend(self, timeout_s: float) -> None:
        """Accept and serve taps; disconnect silent connections."""
        self._peers.attend(timeout_s)
        oldest_ns = monotonic_ns() - int(INTRODUCTION_S * 1e9)
        for tap in self._peers:
            if tap.settings is None and tap.came_ns < oldest_ns:
                self._peers.drop(tap, f"it sent nothing for {INTRODUCTION_S:g} s")


def _say(text: str) -> None:
    print(f"sistap bus: {visible(text)}", file=sys.stderr)
