# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs under Windows: makes a named pipe as Wireshark does, starts a command on it, keeps what comes, then closes it.

python pipe.py FILE COUNT COMMAND... : writes COUNT bytes to FILE; PIPE in the command stands for the pipe's name.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys

NAME = r"\\.\pipe\sistap-check"
INBOUND, BYTES, SIZE = 0x1, 0x0, 65536


def main(file: str, count: str, *command: str) -> int:
    """Return the exit code of the command."""
    kernel = ctypes.WinDLL("kernel32")  # type: ignore[attr-defined,unused-ignore]
    kernel.CreateNamedPipeW.restype = ctypes.c_void_p
    pipe = ctypes.c_void_p(kernel.CreateNamedPipeW(NAME, INBOUND, BYTES, 1, SIZE, SIZE, 0, None))
    process = subprocess.Popen([NAME if word == "PIPE" else word for word in command])
    kernel.ConnectNamedPipe(pipe, None)
    buffer, read, received = ctypes.create_string_buffer(SIZE), ctypes.c_uint32(), b""
    while len(received) < int(count) and kernel.ReadFile(pipe, buffer, SIZE, ctypes.byref(read), None):
        received += buffer.raw[: read.value]
    kernel.CloseHandle(pipe)
    with open(file, "wb") as stream:
        stream.write(received)
    return process.wait(30)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
