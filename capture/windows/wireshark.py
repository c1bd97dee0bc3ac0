# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs under Windows: an extcap as Wireshark runs it, with a pipe for the capture and two for the toolbar.

python wireshark.py FILE FIRST LAUNCHER INTERFACE ... keeps the capture in FILE and asks for a marker as the toolbar
does. When the capture has the marker and the toolbar counts telegrams, it closes the pipe named FIRST ("data" or
"toolbar"), then the other. It prints the messages to the toolbar, one in each line: control, command and text. Its exit
code is that of the extcap.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import threading
from collections.abc import Iterator

MARKER = "seen by Wireshark"
# As Wireshark makes its pipes: both ways, bytes, one instance. But a single thread uses each, so none is overlapped.
DUPLEX, BYTES, SIZE = 0x3, 0x0, 65536
PATIENCE_S = 60

_INITIALIZED, _SET = 0, 1  # commands of the toolbar
_MARKER, _COUNTERS, _ANY = 1, 2, 255  # its controls


class Pipe:
    """A named pipe, and this program its server."""

    def __init__(self, name: str) -> None:
        """Make it."""
        self.name = rf"\\.\pipe\wireshark_{name}"
        self._kernel = ctypes.WinDLL("kernel32")  # type: ignore[attr-defined,unused-ignore]
        self._kernel.CreateNamedPipeW.restype = ctypes.c_void_p
        self._handle = ctypes.c_void_p(
            self._kernel.CreateNamedPipeW(self.name, DUPLEX, BYTES, 1, SIZE, SIZE, 300, None)
        )
        self._count = ctypes.c_uint32()

    def connect(self) -> None:
        """Wait for the extcap to open it."""
        self._kernel.ConnectNamedPipe(self._handle, None)

    def read(self) -> bytes:
        """Return what comes next; empty if the extcap has closed it."""
        buffer = ctypes.create_string_buffer(SIZE)
        if not self._kernel.ReadFile(self._handle, buffer, SIZE, ctypes.byref(self._count), None):
            return b""
        return buffer.raw[: self._count.value]

    def write(self, data: bytes) -> None:
        """Send data."""
        self._kernel.WriteFile(self._handle, data, len(data), ctypes.byref(self._count), None)

    def close(self) -> None:
        """Close the pipe, whatever the extcap does."""
        self._kernel.DisconnectNamedPipe(self._handle)
        self._kernel.CloseHandle(self._handle)


def message(control: int, command: int, text: str = "") -> bytes:
    """Return a message of the toolbar."""
    return b"T" + (len(text) + 2).to_bytes(3, "big") + bytes([control, command]) + text.encode()


def messages(data: bytes) -> Iterator[tuple[int, int, str]]:
    """Split the data into messages."""
    while data:
        end = 4 + int.from_bytes(data[1:4], "big")
        yield data[4], data[5], data[6:end].decode()
        data = data[end:]


def counts(heard: list[bytes]) -> bool:
    """Tell whether the toolbar counts telegrams, and more than 0."""
    shown = [text for control, _, text in messages(b"".join(heard)) if control == _COUNTERS]
    return bool(shown) and not shown[-1].startswith("0 ")


def main(file: str, first: str, launcher: str, interface: str, *more: str) -> int:
    """Run one capture; return its exit code."""
    data, told, asks = (Pipe(f"{name}_{interface}") for name in ("data", "in", "out"))
    asked = ["--capture", "--extcap-interface", interface, "--fifo", data.name, *more]
    asked += ["--extcap-control-out", told.name, "--extcap-control-in", asks.name]
    process = subprocess.Popen([launcher, *asked])
    heard: list[bytes] = []
    listening = threading.Thread(target=_listen, args=(told, heard), daemon=True)
    listening.start()
    asks.connect()
    asks.write(message(_ANY, _INITIALIZED) + message(_MARKER, _SET, MARKER))
    data.connect()
    with open(file, "wb") as stream:
        received = b""
        while (MARKER.encode() not in received or not counts(heard)) and (piece := data.read()):
            stream.write(piece)
            received += piece
    order = [data, asks]
    for pipe in order if first == "data" else order[::-1]:
        pipe.close()
        if first == "toolbar" and pipe is asks:
            _drain(data)
    code = process.wait(PATIENCE_S)
    listening.join(PATIENCE_S)
    for control, command, text in messages(b"".join(heard)):
        print(control, command, text.strip())
    return code


def _listen(pipe: Pipe, heard: list[bytes]) -> None:
    pipe.connect()
    while piece := pipe.read():
        heard.append(piece)


def _drain(pipe: Pipe) -> None:
    """Read what still comes, as dumpcap does, until the extcap closes the pipe."""
    while pipe.read():
        pass


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
