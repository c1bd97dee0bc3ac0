# SPDX-License-Identifier: GPL-2.0-or-later
"""The toolbar that Wireshark shows for a capture: what it has, and the messages that go both ways.

A message is 'T', a length in 3 bytes, the number of the control, a command, and the rest of that length. Each way has a
pipe and a thread of its own: neither a person nor a busy Wireshark holds the capture up.
"""

from __future__ import annotations

import os
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import BinaryIO

from sistap.capture.remote import Marker, Rate
from sistap.capture.scan import AUTO
from sistap.extcap.sentences import sentence
from sistap.line.settings import LineSettings
from sistap.records.counters import Counters
from sistap.records.record import LARGEST_RATE
from sistap.sis.rates import RATES
from sistap.terminal.console import Console
from sistap.terminal.stop import Stopped
from sistap.terminal.visible import visible

PATIENCE_S = 5  # for Wireshark to open its ends of the pipes
FAREWELL_S = 0.5  # for it to take the last messages

_HEADER = struct.Struct(">cBHBB")
_LENGTH_SIZE = 3
_COUNTED = 2  # bytes of the header that belong to the length: control and command
_LONGEST = 0xFFFF  # bytes of a text for Wireshark; it shows one line
_SYNC = b"T"

# Commands, and the controls by their numbers.
_INITIALIZED, _SET, _ADD, _STATUS_BAR = 0, 1, 2, 6
_RATE, _MARKER, _COUNTERS, _LOG = range(4)


def controls() -> list[str]:
    """Describe the toolbar."""
    return [
        sentence("control", number=_RATE, type="selector", display="Rate", tooltip="Read on at this rate"),
        *(sentence("value", control=_RATE, value=rate, display=f"{rate} Bd") for rate in RATES),
        sentence("value", control=_RATE, value=AUTO, display="Look for it"),
        sentence(
            "control",
            number=_MARKER,
            type="string",
            display="Marker",
            tooltip="Enter puts this text into the capture, as an event at this moment",
        ),
        # A button shows text as it is meant to be read; in a field that cannot be edited it is gray on gray.
        sentence(
            "control",
            number=_COUNTERS,
            type="button",
            display="Counters",
            tooltip="Telegrams since the start; click to have all counters in the log",
        ),
        sentence("control", number=_LOG, type="button", role="logger", display="Log", tooltip="What sistap says"),
    ]


class Toolbar:
    """Tells how a capture goes, and takes what is asked for; without pipes (tshark) it only tells what went wrong.

    Use it in a `with`. What is printed on standard error, Wireshark shows in a window when the capture ends.
    """

    shows_progress = False  # show() does

    def __init__(self, control_in: str | None, control_out: str | None) -> None:
        self._console = Console()
        self._requests: SimpleQueue[Marker | Rate] = SimpleQueue()
        self._messages: SimpleQueue[bytes | None] = SimpleQueue()  # None: it was the last
        self._attached = threading.Event()  # Wireshark has opened its end, or there is no pipe
        self._left: Callable[[], None] = lambda: None
        self._counters: Counters | None = None  # those shown last
        self._rate = ""  # that the toolbar shows; empty: not known
        self._listener = threading.Thread(target=self._listen, args=(control_in,), daemon=True)
        self._speaker = threading.Thread(target=self._speak, args=(control_out,), daemon=True)

    def __enter__(self) -> Toolbar:
        self._listener.start()
        self._speaker.start()
        self._send(_LOG, _SET)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let Wireshark have everything. It would hang in opening a pipe whose other end had come and gone."""
        if kind is not Stopped:
            self._attached.wait(PATIENCE_S)
        self._messages.put(None)
        self._speaker.join(FAREWELL_S)

    def when_left(self, stop: Callable[[], None]) -> None:
        """Set what to do when Wireshark closes the toolbar's pipe: on Windows it ends a capture with no other sign."""
        self._left = stop

    def say(self, text: str) -> None:
        """Show a line in the log and, for a while, in the status bar."""
        text = visible(text)
        self._send(_LOG, _ADD, f"{time.strftime('%H:%M:%S')}  {text}\n")
        self._send(_LOG, _STATUS_BAR, f"sistap: {text}")

    def alarm(self, text: str) -> None:
        """Show a line in the log and, when the capture has ended, in a window."""
        self.say(text)
        self._console.say(text)

    def progress(self, text: str) -> None:
        """Do nothing: show() does."""

    def requests(self) -> Iterator[Marker | Rate]:
        """Yield what was asked for since this was last called."""
        with suppress(Empty):
            while True:
                yield self._requests.get_nowait()

    def show(self, counters: Counters, settings: LineSettings) -> None:
        """Show the counters and the rate."""
        self._counters = counters
        damaged = f", {counters.damaged} damaged" if counters.damaged else ""
        faulty = f", {counters.faulty_characters} line errors" if counters.faulty_characters else ""
        self._send(_COUNTERS, _SET, f"{counters.telegrams} telegrams{damaged}{faulty}")
        rate = str(settings.baud)
        if rate != self._rate:
            self._rate = rate
            self._send(_RATE, _ADD, f"{rate}\0{rate} Bd")  # the selector may not have it
            self._send(_RATE, _SET, rate)

    def _send(self, control: int, command: int, text: str = "") -> None:
        payload = text.encode(errors="backslashreplace")[:_LONGEST]
        length = len(payload) + _COUNTED
        self._messages.put(_HEADER.pack(_SYNC, length >> 16, length & 0xFFFF, control, command) + payload)

    def _speak(self, path: str | None) -> None:
        """Write what is sent; when Wireshark has closed the pipe, nobody wants the rest."""
        with suppress(OSError), open(path or os.devnull, "wb") as pipe:
            while (message := self._messages.get()) is not None:
                pipe.write(message)
                pipe.flush()

    def _listen(self, path: str | None) -> None:
        """Take what Wireshark says, until it closes the pipe."""
        if not path:
            self._attached.set()
            return
        with suppress(OSError), open(path, "rb") as pipe:
            self._attached.set()
            begun = False  # before, it repeats what was set in the toolbar for the last capture
            for control, command, text in _received(pipe):
                begun = begun or command == _INITIALIZED
                if begun and command == _SET:
                    self._take(control, text)
        self._left()

    def _take(self, control: int, text: str) -> None:
        if control == _RATE and (text == AUTO or _is_rate(text)):
            self._rate = ""
            self._requests.put(Rate(None if text == AUTO else int(text)))
        elif control == _MARKER and text.strip():
            self._requests.put(Marker(text))
            self._send(_MARKER, _SET)
        elif control == _COUNTERS and self._counters:
            self.say(str(self._counters))


def _received(pipe: BinaryIO) -> Iterator[tuple[int, int, str]]:
    """Yield control, command and text of each message, until the pipe ends; pass over what is no message."""
    while sync := pipe.read(1):
        if sync != _SYNC:
            continue
        length = int.from_bytes(pipe.read(_LENGTH_SIZE), "big")
        message = pipe.read(length)
        if len(message) == length >= _COUNTED:
            yield message[0], message[1], message[_COUNTED:].decode(errors="backslashreplace")


def _is_rate(text: str) -> bool:
    return len(text) <= len(str(LARGEST_RATE)) and text.isdecimal() and 0 < int(text) <= LARGEST_RATE
