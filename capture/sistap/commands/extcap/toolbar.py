# SPDX-License-Identifier: GPL-2.0-or-later
"""The toolbar that Wireshark shows for a capture: its controls, and the messages in both directions.

A message is 'T', a length in 3 bytes, the number of the control, a command, and the rest of that length. Each direction
has a pipe and a thread of its own: neither the user nor a busy Wireshark delays the capture.
"""

from __future__ import annotations

import os
import stat
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from queue import Full, Queue
from types import TracebackType
from typing import BinaryIO

from sistap.commands.extcap.interfaces import sentence
from sistap.tap.capture.rate import AUTO
from sistap.tap.capture.session import Capture
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import LARGEST_RATE
from sistap.tap.sis.rates import RATES
from sistap.tap.terminal.console import Console, visible
from sistap.tap.terminal.rights import as_typed
from sistap.tap.terminal.stop import Stop

PATIENCE_S = 5  # time for Wireshark to open its ends of the pipes
FAREWELL_S = 0.5  # time for Wireshark to take the last messages

_HEADER = struct.Struct(">cBHBB")
_LENGTH_SIZE = 3
_COUNTED = 2  # bytes of the header that count in the length: control and command
_LONGEST = 0xFFFF  # bytes of a text for Wireshark; it shows one line
_SYNC = b"T"
_MOST = 1000  # messages and requests that wait, so that they stay few whatever Wireshark does

# Commands, and the numbers of the controls.
_INITIALIZED, _SET, _ADD, _STATUS_BAR = 0, 1, 2, 6
_RATE, _MARKER, _COUNTERS, _LOG = range(4)


def controls() -> list[str]:
    """Describe the toolbar."""
    return [
        sentence("control", number=_RATE, type="selector", display="Rate", tooltip="Continue at this rate"),
        *(sentence("value", control=_RATE, value=rate, display=f"{rate} Bd") for rate in RATES),
        sentence("value", control=_RATE, value=AUTO, display="Look for it"),
        sentence(
            "control",
            number=_MARKER,
            type="string",
            display="Marker",
            tooltip="Press Enter to add this text to the capture, as an event at this moment",
        ),
        # A button shows its text clearly; a field that cannot be edited is gray on gray.
        sentence(
            "control",
            number=_COUNTERS,
            type="button",
            display="Counters",
            tooltip="Telegrams since the start; click to write all counters to the log",
        ),
        sentence("control", number=_LOG, type="button", role="logger", display="Log", tooltip="Messages of sistap"),
    ]


class Toolbar:
    """Shows how a capture goes, and takes requests. Without pipes (tshark) it only reports errors.

    Use it in a `with`. Wireshark shows the standard error output in a window when the capture ends.
    """

    def __init__(self, control_in: str | None, control_out: str | None) -> None:
        self._console = Console()
        self._requests: Queue[Callable[[Capture], None]] = Queue(_MOST)
        self._messages: Queue[bytes | None] = Queue(_MOST)  # None: the end
        self._attached = threading.Event()  # Wireshark has opened its end, or there is no pipe
        self._closed = threading.Event()  # Wireshark has closed it again
        self._left: Callable[[], None] = lambda: None
        self._counters: Counters | None = None  # the counters shown last
        self._next_s = 0.0  # time of the next look at them
        self._rate = ""  # the rate shown; empty: unknown
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
        """Let Wireshark receive everything. It would hang while opening a pipe whose other end is gone."""
        if not Stop.current().asked:
            self._attached.wait(PATIENCE_S)
        self._put(None)
        self._speaker.join(FAREWELL_S)

    def when_left(self, stop: Callable[[], None]) -> None:
        """Set what to do when Wireshark closes the toolbar's pipe: on Windows this is the only sign of the end."""
        self._left = stop
        if self._closed.is_set():
            stop()

    def say(self, text: str) -> None:
        """Show a line in the log and, for a while, in the status bar."""
        text = visible(as_typed(text))
        self._send(_LOG, _ADD, f"{time.strftime('%H:%M:%S')}  {text}\n")
        self._send(_LOG, _STATUS_BAR, f"sistap: {text}")

    def alarm(self, text: str) -> None:
        """Show a line in the log and, when the capture has ended, in a window."""
        self.say(text)
        self._console.say(text)

    def progress(self, text: str) -> None:
        """Do nothing: attend() does."""

    def attend(self, capture: Capture) -> None:
        """Do what the user has asked for; show the counters and the rate every second."""
        for _ in range(self._requests.qsize()):  # what comes meanwhile has its turn later, like the characters
            self._requests.get()(capture)
        now_s = time.monotonic()
        if now_s >= self._next_s and capture.settings:
            self._next_s = now_s + 1
            self._show(capture.counters, capture.settings.baud)

    def _show(self, counters: Counters, baud: int) -> None:
        self._counters = counters
        damaged = f", {counters.damaged} damaged" if counters.damaged else ""
        faulty = f", {counters.faulty_characters} line errors" if counters.faulty_characters else ""
        self._send(_COUNTERS, _SET, f"{counters.telegrams} telegrams{damaged}{faulty}")
        rate = str(baud)
        if rate != self._rate:
            self._rate = rate
            self._send(_RATE, _ADD, f"{rate}\0{rate} Bd")  # the selector may not have it
            self._send(_RATE, _SET, rate)

    def _send(self, control: int, command: int, text: str = "") -> None:
        payload = text.encode(errors="backslashreplace")[:_LONGEST]
        length = len(payload) + _COUNTED
        self._put(_HEADER.pack(_SYNC, length >> 16, length & 0xFFFF, control, command) + payload)

    def _put(self, message: bytes | None) -> None:
        """Let it be written, unless Wireshark has not read for long."""
        with suppress(Full):
            self._messages.put_nowait(message)

    def _speak(self, path: str | None) -> None:
        """Write what is sent; stop when Wireshark has closed the pipe."""
        with suppress(OSError), open(path or os.devnull, "wb", opener=_existing) as pipe:
            while (message := self._messages.get()) is not None:
                pipe.write(message)
                pipe.flush()

    def _listen(self, path: str | None) -> None:
        """Take what Wireshark sends, if there is a pipe."""
        if path:
            with suppress(OSError), open(path, "rb") as pipe:
                self._attached.set()
                self._heed(pipe)
        self._attached.set()  # or nobody can: there is no pipe

    def _heed(self, pipe: BinaryIO) -> None:
        """Take what Wireshark sends, until it closes the pipe."""
        begun = False  # until then it repeats the toolbar settings of the last capture
        with suppress(OSError):
            for control, command, text in _received(pipe):
                begun = begun or command == _INITIALIZED
                if begun and command == _SET:
                    self._take(control, text)
        self._closed.set()
        self._left()

    def _take(self, control: int, text: str) -> None:
        if control == _RATE and (text == AUTO or _is_rate(text)):
            self._rate = ""
            baud = None if text == AUTO else int(text)
            self._requests.put(lambda capture: capture.set_rate(baud))
        elif control == _MARKER and text.strip():
            self._requests.put(lambda capture: capture.mark(text))
            self._send(_MARKER, _SET)
        elif control == _COUNTERS and self._counters:
            self.say(str(self._counters))


def _existing(path: str, flags: int) -> int:
    """Open what is there, for open(): no file is to begin, or to be overwritten. OSError if it is one."""
    descriptor = os.open(path, flags & ~(os.O_CREAT | os.O_TRUNC))
    if stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise FileExistsError(path)
    return descriptor


def _received(pipe: BinaryIO) -> Iterator[tuple[int, int, str]]:
    """Yield control, command and text of each message until the pipe ends; skip anything else."""
    while sync := pipe.read(1):
        if sync != _SYNC:
            continue
        length = int.from_bytes(pipe.read(_LENGTH_SIZE), "big")
        message = pipe.read(length)
        if len(message) == length >= _COUNTED:
            yield message[0], message[1], message[_COUNTED:].decode(errors="backslashreplace")


def _is_rate(text: str) -> bool:
    return len(text) <= len(str(LARGEST_RATE)) and text.isdecimal() and 0 < int(text) <= LARGEST_RATE
