# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap web`: opens the page; with a port, only who knows the address gets page and tap, on this computer alone."""

from __future__ import annotations

import http.client
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import tty
import webbrowser
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from portable import terminals

from sistap import cli
from sistap.commands.web import command
from sistap.commands.web.command import Server, with_tap
from sistap.commands.web.listen import Listening
from sistap.tap.common import pages

PAGE = '<!DOCTYPE html><html lang="en"><meta content="default-src \'none\'; connect-src blob:; img-src data:">'
TELEGRAM = bytes.fromhex("02 D9 00 00 00 12 10 03")
TIMEOUT_S = 60
RESET = struct.pack("ii", 1, 0)  # SO_LINGER: a connection that is closed at once


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "sis.html"
    path.write_text(PAGE)
    return path


def test_without_a_port_it_names_the_page(
    page: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    shown: list[str] = []
    monkeypatch.setattr(pages, "FOLDERS", (page.with_name("none"), page.parent))
    monkeypatch.setattr(webbrowser, "open", shown.append)
    monkeypatch.setenv("DISPLAY", ":0")
    assert cli.main(["web"]) == 0
    assert shown == [page.as_uri()]
    assert capfd.readouterr().out == f"{page.as_uri()}\n"


def test_without_the_page_it_says_how_to_make_it(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(pages, "FOLDERS", ())
    assert cli.main(["web"]) == 1
    assert "`./bootstrap page`" in capfd.readouterr().err


def test_the_page_may_ask_for_the_tap_and_nothing_else() -> None:
    text = with_tap(PAGE, '"><script>')
    assert 'data-tap="&quot;&gt;&lt;script&gt;"' in text
    assert "connect-src blob: 'self'; img-src data:" in text
    with pytest.raises(ValueError, match="not the page"):
        with_tap("<html>", "x")


@pytest.fixture
def served(page: Path) -> Iterator[tuple[str, int]]:
    """Serve the page with a pseudo terminal; give the address, and where its line is written."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    code = (
        "import sys; from pathlib import Path; from sistap import cli; from sistap.tap.common import pages;"
        "pages.FOLDERS = (Path(sys.argv[1]).parent,); sys.exit(cli.main(['web', '-q', '-i', sys.argv[2]]))"
    )
    environment = {
        **os.environ,
        "PYTHONPATH": str(Path(command.__file__).parents[3]),
        "DISPLAY": "",
        "WAYLAND_DISPLAY": "",
    }
    words = [sys.executable, "-c", code, str(page), os.ttyname(theirs)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout
        yield process.stdout.readline().strip(), ours
        process.send_signal(signal.SIGTERM)
        assert process.wait(TIMEOUT_S) == 0
    os.close(ours)
    os.close(theirs)


def asked(address: str, path: str, **headers: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=TIMEOUT_S)
    connection.request("GET", path, headers=headers)
    return connection.getresponse()


@terminals
@pytest.mark.attack("a foreign page, or program, asks `sistap web`", "404 without its secret word and its own name")
def test_who_does_not_know_the_word_gets_nothing(served: tuple[str, int]) -> None:
    address, _ = served
    url = urlsplit(address)
    assert url.hostname == "127.0.0.1"
    assert len(url.path) > 30
    assert asked(address, url.path).status == 200
    for path in ("/", "/tap", "/x/", url.path[:-1], f"{url.path}../tap"):
        assert asked(address, path).status == 404
    for path in (url.path, f"{url.path}tap"):
        assert asked(address, path, Host=f"evil.example:{url.port}").status == 404


def connected(server: Server) -> socket.socket:
    host, port = urlsplit(server.address).netloc.split(":")
    return socket.create_connection((host, int(port)))


HALVES = {"asks nothing": b"", "asks half": b"GET", "asks for nothing here": b"GET /x HTTP/1.1\r\n\r\n"}


@pytest.mark.attack("a program hangs up on `sistap web`, or connects and never asks", "no word of it; at most 32 wait")
@pytest.mark.parametrize("words", [*HALVES.values(), None], ids=[*HALVES, "takes a part of the page"])
def test_who_hangs_up(words: bytes | None, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    ended = threading.Semaphore(0)
    with Server(b"x" * (1 << 24), pytest.fail) as server:

        def close(request: socket.socket) -> None:
            request.close()
            ended.release()

        monkeypatch.setattr(server._server, "close_request", close)
        url = urlsplit(server.address)
        for _ in range(4):
            with connected(server) as connection:
                if words is None:
                    connection.sendall(f"GET {url.path} HTTP/1.1\r\nHost: {url.netloc}\r\n\r\n".encode())
                    connection.recv(1)
                else:
                    connection.sendall(words)
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
            assert ended.acquire(timeout=TIMEOUT_S)
    assert capfd.readouterr().err == ""


@pytest.mark.attack("a program hangs up on `sistap web`, or connects and never asks", "no word of it; at most 32 wait")
def test_who_never_asks() -> None:
    assert command._Handler.timeout <= TIMEOUT_S
    with Server(b"", pytest.fail) as server, ExitStack() as stack:
        for _ in range(40):
            waiting = stack.enter_context(connected(server))
            waiting.settimeout(TIMEOUT_S)
        assert waiting.recv(1) == b""
        assert threading.active_count() <= 32


@terminals
def test_the_page_hears_the_tap(served: tuple[str, int]) -> None:
    address, line = served
    with closing(asked(address, f"{urlsplit(address).path}tap")) as answer:
        listening = Listening(f'{{"tap": {list(answer.read1())}, "system": "a browser"}}')
        capture = b""
        os.write(line, TELEGRAM)
        while TELEGRAM not in capture:
            capture += listening.step(f'[{{"line": 0, "data": {list(answer.read1())}}}]')
    assert "1 telegram" in listening.said
    listening.step('[{"line": 0, "gone": "the tap has ended"}]')
    assert listening.is_over


def test_what_is_no_tap_is_refused() -> None:
    with pytest.raises(ValueError, match="not a sistap bus or tap"):
        Listening('{"tap": [1, 2, 3], "system": "a browser"}')
