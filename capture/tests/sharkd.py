# SPDX-License-Identifier: GPL-2.0-or-later
"""Queries one capture often: sharkd dissects it once, where each start of tshark would dissect it again.

It answers as Wireshark does after it has read a whole file, like `tshark -2`.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO

from sistap.dissected.wireshark.tshark import Tshark


class SharkdError(Exception):
    """sharkd refused a request; the text is its message."""


class Sharkd:
    """Wireshark's server for programs, spoken to in JSON-RPC, a line each way. Use it in a `with`."""

    def __init__(self) -> None:
        self._program = Tshark("sharkd")
        self._errors: BinaryIO = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the rest
        self._process = self._program.start(["-"], self._errors)
        self._folder = Path(tempfile.mkdtemp(prefix="sharkd-"))
        self._folder.chmod(0o755)  # as root, Tshark runs it as nobody
        self._loaded: Path | None = None
        self._requests = 0
        self._loads = 0

    def __enter__(self) -> Sharkd:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.communicate()  # it ends with its input
        self._errors.close()
        shutil.rmtree(self._folder)
        self._program.__exit__(kind, error, trace)

    def frames(self, capture: Path, display_filter: str) -> list[int]:
        """Return the numbers of the packets that match a display filter. SharkdError if it is not a filter."""
        self._load(capture)
        # sharkd 4.0 keeps what a filter left under its text, also when another capture is loaded.
        display_filter += " " * self._loads
        return [frame["num"] for frame in self._request("frames", filter=display_filter)]

    def rows(self, capture: Path) -> list[dict[str, Any]]:
        """Return the packet list: "num", and "c" with the text of each column."""
        self._load(capture)
        return list(self._request("frames"))

    def details(self, capture: Path, number: int) -> dict[str, Any]:
        """Return the tree of a packet and its bytes, as sharkd names them."""
        self._load(capture)
        return dict(self._request("frame", frame=number, proto=True, bytes=True))

    def prefer(self, name: str, value: str) -> None:
        """Set a preference, for captures that are read from now on."""
        self._request("setconf", name=name, value=value)
        self._loaded = None

    def has_field(self, name: str) -> bool:
        """Tell whether a dissector has such a field."""
        return any(one["f"] == name for one in self._request("complete", field=name).get("field", []))

    def _load(self, capture: Path) -> None:
        if self._loaded == capture:  # it does not change in a test
            return
        copy = self._folder / f"{self._loads}.pcapng"  # the one before stays: sharkd still has it open
        shutil.copyfile(capture, copy)
        copy.chmod(0o644)
        self._request("load", file=str(copy))
        self._loaded = capture
        self._loads += 1

    def _request(self, method: str, **parameters: str | int) -> Any:
        self._requests += 1
        request = {"jsonrpc": "2.0", "id": self._requests, "method": method, "params": parameters}
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(request).encode() + b"\n")
        self._process.stdin.flush()
        answer = json.loads(self._process.stdout.readline() or "{}")
        if "result" not in answer:
            raise SharkdError(f"{method} {parameters}: {answer.get('error', 'sharkd has ended')}")
        return answer["result"]
