# SPDX-License-Identifier: GPL-2.0-or-later
"""Lets Windows programs under wine run this system's Wireshark programs: proxy.c asks, this module runs them.

It converts Windows paths to paths of this system on the way in. In the output of `-G` it converts them back.
"""

from __future__ import annotations

import os
import re
import socketserver
import struct
import subprocess
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path, PureWindowsPath
from typing import IO

OUT, ERR, CODE = 1, 2, 3  # as in proxy.c
_LENGTH = struct.Struct("<I")

# Those environment variables that matter to Wireshark.
_PASSED_ON = re.compile("(WIRESHARK_|XDG_|LC_)|(HOME|TZ)$")
_DRIVE = re.compile(r"(?:^|(?<=[:=]))([A-Za-z]:)[\\/]")  # also after lua_script: and NAME=


class Proxy(socketserver.ThreadingTCPServer):
    """Serves one Windows until it is closed. Use it in a `with`."""

    daemon_threads = True

    def __init__(self, prefix: Path, environment: dict[str, str]) -> None:
        """Take the folder of the Windows, and variables that apply unless a program sets them."""
        super().__init__(("127.0.0.1", 0), _Asked)
        self._drives = prefix / "dosdevices"
        inherited = {name: value for name, value in os.environ.items() if not name.startswith("WIRESHARK_")}
        self._environment = inherited | environment
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def port(self) -> int:
        """Return the port where it listens."""
        return int(self.server_address[1])

    def start(self, cwd: str, variables: list[str], words: list[str]) -> subprocess.Popen[bytes]:
        """Start the program that a Windows program asks for."""
        named = (variable.partition("=")[::2] for variable in variables if _PASSED_ON.match(variable.partition("=")[0]))
        own = {name: self._here(value) for name, value in named if value}  # to Windows an empty variable does not exist
        return subprocess.Popen(
            [*_NO_ROOT, PureWindowsPath(words[0]).stem, *map(self._here, words[1:])],
            cwd=self._here(cwd),
            env=self._environment | own,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    def _here(self, text: str) -> str:
        """Convert the Windows path in a word, if it has one, to a path of this system."""
        drive = _DRIVE.search(text)
        if not drive:
            return text
        root = (self._drives / drive[1].lower()).resolve()
        return text[: drive.start()] + str(root / text[drive.end() :].replace("\\", "/"))


# As root Wireshark loads no plugin that the environment names. So root runs it under another user name with the same
# rights.
_NO_ROOT = ["unshare", "--user", "--map-user=1000", "--map-group=1000"] if os.geteuid() == 0 else []


class _Asked(socketserver.StreamRequestHandler):
    """One running program, from its request to its exit code."""

    server: Proxy

    def handle(self) -> None:
        """Run it; the requester may end first."""
        cwd, *rest = self._piece().decode().split("\0")[:-1]
        end = rest.index("")
        words = rest[end + 1 :]
        self._lock = threading.Lock()
        with self.server.start(cwd, rest[:end], words) as process:
            assert process.stdin
            answering = threading.Thread(target=self._answer, args=(process, "-G" in words))
            answering.start()
            with suppress(ConnectionError):
                while piece := self._piece():
                    self._feed(process.stdin, piece)
                self._feed(process.stdin, b"")
                self.rfile.read(1)  # nothing comes: the other side has ended
            process.kill()
            answering.join()

    def _piece(self) -> bytes:
        length = self.rfile.read(_LENGTH.size)
        return self.rfile.read(*_LENGTH.unpack(length)) if len(length) == _LENGTH.size else b""

    @staticmethod
    def _feed(stdin: IO[bytes], piece: bytes) -> None:
        """Write a piece to the program, an empty one closes; a program need not read all of it."""
        with suppress(BrokenPipeError):
            if piece:
                stdin.write(piece)
                stdin.flush()
            else:
                stdin.close()

    def _answer(self, process: subprocess.Popen[bytes], lists_files: bool) -> None:
        """Return both streams live, then the exit code."""
        assert process.stdout
        assert process.stderr
        errors = threading.Thread(target=self._send_all, args=(ERR, _pieces(process.stderr)))
        errors.start()
        self._send_all(OUT, [of_windows(process.stdout.read())] if lists_files else _pieces(process.stdout))
        errors.join()
        self._send(CODE, _LENGTH.pack(process.wait() & 0xFFFFFFFF))

    def _send_all(self, kind: int, pieces: Iterator[bytes] | list[bytes]) -> None:
        for piece in pieces:
            self._send(kind, piece)

    def _send(self, kind: int, data: bytes) -> None:
        with suppress(OSError), self._lock:  # the requester may have ended
            self.wfile.write(bytes([kind]) + _LENGTH.pack(len(data)) + data)


def _pieces(stream: IO[bytes]) -> Iterator[bytes]:
    while piece := os.read(stream.fileno(), 65536):
        yield piece


def of_windows(text: bytes) -> bytes:
    """Convert paths at the ends of lines of `-G folders` and `-G plugins` to Windows paths."""
    return re.sub(rb"(?m)(?<=\t)/\S.*$", lambda path: b"Z:" + path[0].replace(b"/", b"\\"), text)
