# SPDX-License-Identifier: GPL-2.0-or-later
"""What the wire of a virtual bus refuses: times that no capture can hold, and more connections than it serves."""

from __future__ import annotations

import socket
from contextlib import ExitStack, closing

import pytest

from sistap.tap.line.settings import Read
from sistap.tap.wire import protocol, server
from sistap.tap.wire.server import Peer, Peers

YEAR_2226_NS = 8_100_000_000_000_000_000
STRANGER = "the other end of the socket is not a sistap bus"


@pytest.mark.attack("the clock of a virtual bus is set to a year that no capture can hold", "one line says so")
@pytest.mark.parametrize(
    ("time_ns", "said"),
    [(4_000_000_000_000_000_000, "clock .* set it there$"), (YEAR_2226_NS, "set it there$"), (2**64 - 1, STRANGER)],
)
def test_a_time_that_no_capture_can_hold_is_refused(time_ns: int, said: str) -> None:
    assert protocol.Decoder().feed(protocol.pack_read(Read(0, 3_999_999_999_999_999_999, b"x", b"\0"))) != []
    with pytest.raises(ValueError, match=said):
        protocol.Decoder().feed(protocol.pack_read(Read(0, time_ns, b"x", b"\0")))


@pytest.mark.attack("more connections than `sistap bus --listen` allows (32)", "the next one is refused")
def test_no_more_than_a_limit_are_let_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "MOST", 2)
    told: list[str] = []

    def welcome(connection: socket.socket) -> Peer:
        peer = Peer(connection)
        peer.put(b"welcome")
        return peer

    with closing(Peers("127.0.0.1:0", welcome, told.append)) as peers, ExitStack() as opened:
        port = int(peers.name.rpartition(":")[2])
        some = [opened.enter_context(socket.create_connection(("127.0.0.1", port), 60)) for _ in range(5)]
        peers.attend(1)
        peers.attend(1)
        assert len(list(peers)) == 2
        assert [connection.recv(4096) != b"" for connection in some] == [True, True, False, False, False]
        some[0].close()
        peers.attend(1)
        assert len(list(peers)) == 1
    assert told == ["refused a connection: 2 are connected already"]  # once: repeated attempts are no news
