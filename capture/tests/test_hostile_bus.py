# SPDX-License-Identifier: GPL-2.0-or-later
"""Virtual buses that say what no `sistap bus` says, or too fast, too slowly or too often; too many listeners."""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, suppress
from pathlib import Path

import pytest
from attacks import ROOT
from portable import signals

from sistap.tap.line.reader import PortError
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.wire import connection, protocol, server
from sistap.tap.wire.protocol import Hello
from sistap.tap.wire.server import Peer, Peers

pytestmark = pytest.mark.tap

PATIENCE_S = 60
START_NS = 1_700_000_000_000_000_000
LATEST_NS = (1 << 64) - 1


def hello(text: str = "adapter") -> bytes:
    return protocol.pack_hello(Hello(START_NS, text, "timing"))


SETTINGS = protocol.pack_settings(LineSettings(9600))
BEGIN = hello() + SETTINGS
TIMES = protocol.pack_time(START_NS) * 7000
ODD = "\x1b[31m\u202e\n\r\0" + "A" * 60_000


def read(time_ns: int, data: bytes = b"\x02\xf0\x05\x05", line: int = 0) -> bytes:
    return protocol.pack_read(Read(line, time_ns, data, bytes(len(data)), 0))


TOLD = 60  # times that something is said before the capture is stopped
MOST_TEXT = 30_000  # bytes on stderr, and in a file, of all that it says without a character

# What is said once, then again and again as fast as it is taken.
SAID: dict[str, tuple[bytes, bytes]] = {
    "times without an end": (BEGIN, TIMES),
    "characters without an end": (BEGIN, read(START_NS, bytes(range(256)) * 255)),
    "settings without an end": (BEGIN, b"".join(struct.pack(">cIBBB", b"S", rate, 8, 1, 2) for rate in range(500))),
    "introductions without an end": (BEGIN, BEGIN * 100),
    "times that jump": (BEGIN, b"".join(read(at) for at in (0, 1, START_NS, 3 * 10**18, 5, START_NS))),
    "times after 2095": (BEGIN, read(LATEST_NS)),
    "256 lines": (BEGIN, b"".join(read(START_NS, line=line) for line in range(256))),
    "impossible rates": (hello() + struct.pack(">cIBBB", b"S", 0, 8, 1, 2), read(START_NS) + SETTINGS),
    "names that control a terminal": (hello(ODD) + SETTINGS, read(START_NS)),
    "garbage": (BEGIN, os.urandom(4096)),
    "a connection that ends at once": (BEGIN, b""),
}


class Hostile:
    """A bus that never reads."""

    def __init__(self, first: bytes, then: bytes) -> None:
        self._first, self._then = first, then
        self.says_characters = then[:1] == read(0)[:1]
        self.connections = 0
        self.is_heard = threading.Event()
        self._socket = socket.create_server(("127.0.0.1", 0))
        self.port = f"bus://127.0.0.1:{self._socket.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self._socket.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                taken = self._socket.accept()[0]
                self.connections += 1
                threading.Thread(target=self._speak, args=(taken,), daemon=True).start()

    def _speak(self, taken: socket.socket) -> None:
        with suppress(OSError), taken:
            taken.sendall(self._first)
            for number in range(1_000_000 if self._then else 0):
                taken.sendall(self._then)
                if number == TOLD:
                    self.is_heard.set()
        self.is_heard.set()


@pytest.fixture(params=SAID)
def hostile(request: pytest.FixtureRequest) -> Iterator[Hostile]:
    bus = Hostile(*SAID[request.param])
    yield bus
    bus.close()


ATTACK = pytest.mark.attack(
    "a virtual bus floods, jumps in time, lies or hangs up",
    "the capture can be stopped; no traceback, few messages",
)


@signals
@pytest.mark.thorough
@ATTACK
def test_a_capture_of_it_can_be_stopped(hostile: Hostile, tmp_path: Path) -> None:
    with (tmp_path / "errors").open("wb") as errors:
        capture = subprocess.Popen(
            [sys.executable, "-m", "sistap", "capture", "-i", hostile.port, "-w", str(tmp_path / "x.pcapng")],
            cwd=ROOT / "capture",
            stderr=errors,
        )
        assert hostile.is_heard.wait(PATIENCE_S)
        capture.send_signal(signal.SIGTERM)
        try:
            assert capture.wait(PATIENCE_S) in (0, 1, 3)
        finally:
            capture.kill()
    said = (tmp_path / "errors").read_bytes()
    assert b"Traceback" not in said
    assert len(said) < MOST_TEXT
    if not hostile.says_characters:
        assert sum(file.stat().st_size for file in tmp_path.glob("*.pcapng")) < MOST_TEXT
    assert hostile.connections < 20


@pytest.mark.attack("a virtual bus that introduces itself letter by letter", "given up after five seconds")
def test_a_slow_introduction(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "TIMEOUT_S", 0.2)
    ended = threading.Event()

    def drip(bus: socket.socket) -> None:
        with suppress(OSError):
            for letter in hello(ODD):
                bus.sendall(bytes([letter]))
                if ended.wait(0.05):
                    return

    server = socket.create_server(("127.0.0.1", 0))
    thread = threading.Thread(target=lambda: drip(server.accept()[0]), daemon=True)
    thread.start()
    with pytest.raises(PortError, match="no answer|timed out|answer"):
        connection.connect(f"bus://127.0.0.1:{server.getsockname()[1]}")
    assert thread.is_alive()  # it had more to say
    ended.set()
    server.close()


def test_texts_of_the_other_end_are_short() -> None:
    (found,) = protocol.Decoder().feed(hello("\n".join([ODD] * 3)))
    assert isinstance(found, Hello)
    assert len(found.adapter) <= 6000 and len(found.timing) <= 6000


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
