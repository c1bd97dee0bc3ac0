# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap web`: opens the page for a browser, and hands it what a tap of this computer says."""

from __future__ import annotations

import argparse
import os
import secrets
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from html import escape
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import TracebackType
from typing import Any

from sistap.commands.serve.command import add_line, line_of, serve
from sistap.commands.serve.listeners import Listeners
from sistap.tap.common import pages
from sistap.tap.line.clock import CLOCK
from sistap.tap.line.reader import PortError
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, FAILED, USAGE, UsageError
from sistap.tap.wire import protocol

# -- The page and what a tap says. Whoever does not know the token gets nothing ---------------------------------------

LOOPBACK = "127.0.0.1"
TAP = "tap"  # beside the page
_THREADS = 32  # of the process: each connection has one
_BEGINNING, _ASKING = '<html lang="en"', "connect-src blob:"  # of the page: what is said of the tap, and its policy
_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def with_tap(page: str, name: str) -> str:
    """Return the page with the name of the tap, and a policy that lets it ask for the tap."""
    if page.count(_BEGINNING) != 1 or page.count(_ASKING) != 1:
        raise ValueError("it is not the page that this sistap knows")
    return page.replace(_BEGINNING, f'{_BEGINNING} data-tap="{escape(name)}"').replace(_ASKING, f"{_ASKING} 'self'")


class _HttpServer(ThreadingHTTPServer):
    """Holds out against other programs of this computer, which can all connect."""

    daemon_threads = True

    def verify_request(self, *_: object) -> bool:
        """Tell whether there is a thread for one more."""
        return threading.active_count() < _THREADS

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of who has gone before the end."""
        if not isinstance(sys.exc_info()[1], OSError):
            super().handle_error(request, client_address)


class Server:
    """Serves the page at an address with a token, in threads of its own. Use it in a `with`."""

    def __init__(self, page: bytes, connect: Callable[[], socket.socket]) -> None:
        """`connect` makes a connection to the tap."""
        token = secrets.token_urlsafe(24)

        class Handler(_Handler):
            answers = {
                f"/{token}/": lambda self: self.send_page(page),
                f"/{token}/{TAP}": lambda self: self.pass_on(connect),
            }

        self._server = _HttpServer((LOOPBACK, 0), Handler)
        host = f"{LOOPBACK}:{self._server.server_port}"
        Handler.host = host
        self.address = f"http://{host}/{token}/"

    def __enter__(self) -> Server:
        """Begin."""
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End."""
        self._server.shutdown()
        self._server.server_close()


class _Handler(BaseHTTPRequestHandler):
    """Answers GET alone, under the one name of this computer: another name could be a foreign page's."""

    answers: dict[str, Callable[[_Handler], None]]
    host = ""
    timeout = 60  # seconds for a browser to ask, or to take something

    def do_GET(self) -> None:
        """Answer; everything unknown is not there."""
        answer = self.answers.get(self.path) if self.headers.get("Host") == self.host else None
        if answer:
            answer(self)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def send_page(self, page: bytes) -> None:
        """Send the page."""
        self._begin("text/html; charset=utf-8", {"Content-Length": str(len(page))})
        self.wfile.write(page)

    def pass_on(self, connect: Callable[[], socket.socket]) -> None:
        """Send what the tap says until either is gone; give the tap signs of life in place of the page."""
        try:
            with connect() as tap:
                self._begin("application/octet-stream")
                while data := tap.recv(65536):
                    self.wfile.write(data)
                    tap.sendall(protocol.pack_time(CLOCK.now_ns()))
        except OSError:
            self.close_connection = True

    def _begin(self, kind: str, more: dict[str, str] | None = None) -> None:
        self.send_response(HTTPStatus.OK)
        for name, text in {"Content-Type": kind, **_HEADERS, **(more or {})}.items():
            self.send_header(name, text)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Say nothing."""


# -- The command -----------------------------------------------------------------------------------------------------

DESCRIPTION = """\
Open the page: Wireshark with the dissector, sistap and the course in one file for a browser. With -i the page also
hears a port of this computer. So it can listen in a browser that cannot read serial ports, such as Safari, and the
times are as exact as those of `sistap capture`.
"""

EPILOG = """\
Without -i the browser opens the file itself, and sistap ends. With -i, sistap hands the page to browsers of this
computer alone, at an address with a secret word, until it is stopped. It never writes to the port.

examples:
  sistap web                                  open the page
  sistap web -i /dev/ttyUSB0 --baud auto      with a port to listen to; the page finds it under Listen

exit status:
  0  done: stopped by Ctrl-C, SIGTERM, or the end of the terminal
  1  the page is not here, or the port was lost
  2  wrong usage
  3  the port cannot be opened
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    add_line(parser, is_needed=False)


def run(args: argparse.Namespace) -> int:
    """Open the page; with a port, share that until a signal comes. Return the exit code. May raise PortError."""
    console = Console()
    page = pages.found(pages.PAGE)
    if page is None:
        console.say(f"{pages.PAGE} is not here: `./bootstrap page` in the sources of sistap makes it")
        return FAILED
    if not args.port:
        print(page.as_uri(), flush=True)
        show(page.as_uri())
        return DONE
    try:
        return _with_port(args, page, console)
    except (UsageError, ValueError) as error:
        console.alarm(str(error))
        return USAGE


def _with_port(args: argparse.Namespace, page: Path, console: Console) -> int:
    options, settings = line_of(args)
    text = with_tap(page.read_text("utf-8"), args.port).encode()
    with _listeners(console) as (listeners, connect), Server(text, connect) as server:
        show(server.address)
        return serve(options, settings, listeners, console, server.address)


@contextmanager
def _listeners(console: Console) -> Iterator[tuple[Listeners, Callable[[], socket.socket]]]:
    """Listen where only this user can connect; on Windows, where there is no such place, at a free port."""
    with tempfile.TemporaryDirectory(prefix="sistap-web-") as folder:
        try:
            listeners = Listeners(f"{LOOPBACK}:0" if sys.platform == "win32" else f"{folder}/tap", [], console.say)
        except OSError as error:
            raise PortError(f"cannot share the port here: {error.strerror or error}") from error
        with closing(listeners):
            yield listeners, lambda: _connected(listeners.name.removeprefix("bus://"))


def _connected(name: str) -> socket.socket:
    if sys.platform == "win32":
        host, _, port = name.rpartition(":")
        return socket.create_connection((host, int(port)))
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    connection.connect(name)
    return connection


def show(address: str) -> None:
    """Open a browser, where there is a screen for it. Whoever has none sees the address."""
    if sys.platform in ("win32", "darwin") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(address)
