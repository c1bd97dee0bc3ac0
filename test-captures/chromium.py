# SPDX-License-Identifier: GPL-2.0-or-later
"""Drives a headless chromium: the DevTools protocol over a pair of pipes, messages ended by a zero byte."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
import time
from base64 import b64decode
from pathlib import Path
from types import TracebackType
from typing import Any

_LOOK_S = 0.05
PROGRAMS = ("chromium", "chromium-browser", "google-chrome")


class ChromiumError(Exception):
    """The page, or chromium, did not do what it was told; the text says what."""


def program() -> str | None:
    """Find chromium."""
    return next((found for name in PROGRAMS if (found := shutil.which(name))), None)


class Chromium:
    """One window at a time. Use it in a `with`."""

    def __init__(self, *options: str) -> None:
        """Start it with an empty profile."""
        path = program()
        if path is None:
            raise ChromiumError("chromium is not installed")
        self._profile = tempfile.mkdtemp(prefix="chromium-")
        ours, theirs = os.pipe(), os.pipe()
        # It reads from descriptor 3 and writes to 4; a shell puts ours there.
        command = f'exec "$@" 3<&{ours[0]} 4>&{theirs[1]}'
        arguments = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]
        arguments += ["--remote-debugging-pipe", f"--user-data-dir={self._profile}", *options]
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the rest
        self._process = subprocess.Popen(
            ["bash", "-c", command, "chromium", path, *arguments],
            pass_fds=(ours[0], theirs[1]),
            stdin=subprocess.DEVNULL,
            stdout=self._errors,
            stderr=self._errors,
        )
        os.close(ours[0])
        os.close(theirs[1])
        self._to, self._from = os.fdopen(ours[1], "wb"), os.fdopen(theirs[0], "rb")
        self._unread = b""
        self._number = 0
        self._loads = 0
        self._session: str | None = None
        self._context: str | None = None
        self.requests: list[str] = []  # addresses that the page has asked for
        self.complaints: list[str] = []  # errors of the page's script, and what its policy refused

    def __enter__(self) -> Chromium:
        """Open the first window."""
        self.renew()
        return self

    def renew(self) -> None:
        """Begin again with a new window that remembers nothing."""
        if self._context:
            self.call("Target.disposeBrowserContext", browserContextId=self._context)
        self.complaints.clear()
        self.requests.clear()
        self._context = self.call("Target.createBrowserContext")["browserContextId"]
        target = self.call("Target.createTarget", url="about:blank", browserContextId=self._context)["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End it; remove its profile."""
        self._process.kill()
        self._process.wait()
        for stream in (self._to, self._from, self._errors):
            stream.close()
        shutil.rmtree(self._profile, ignore_errors=True)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Do something, wait until it is done, and return what comes of it."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session and not method.startswith("Target."):
            message["sessionId"] = self._session
        self._to.write(json.dumps(message).encode() + b"\0")
        self._to.flush()
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                break
        if "error" in answer:
            raise ChromiumError(f"{method}: {answer['error']['message']}")
        return dict(answer["result"])

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._unread:
            more = os.read(self._from.fileno(), 1 << 20)
            if not more:
                self._errors.seek(0)
                raise ChromiumError(f"chromium has ended: {self._errors.read().decode(errors='replace')[-500:]}")
            self._unread += more
        text, _, self._unread = self._unread.partition(b"\0")
        message: dict[str, Any] = json.loads(text)
        self._loads += message.get("method") == "Page.loadEventFired"
        if message.get("method") == "Network.requestWillBeSent":
            self.requests.append(message["params"]["request"]["url"])
        if message.get("method") == "Runtime.exceptionThrown":
            self.complaints.append(str(message["params"]["exceptionDetails"]))
        if message.get("method") == "Log.entryAdded" and message["params"]["entry"]["level"] == "error":
            self.complaints.append(message["params"]["entry"]["text"])
        return message

    def open(self, address: str) -> None:
        """Open a page, and wait until its script has run."""
        before = self._loads
        answer = self.call("Page.navigate", url=address)
        while self._loads == before and "loaderId" in answer:  # there is none if only the fragment is new
            self._next()

    def run(self, expression: str) -> Any:
        """Return the value of an expression of JavaScript."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise ChromiumError(f"{expression[:200]}: {found['exceptionDetails']}")
        return found["result"].get("value")

    def until(self, expression: str, timeout_s: float = 60) -> None:
        """Wait until an expression of JavaScript is true."""
        end = time.monotonic() + timeout_s
        while not self.run(f"Boolean({expression})"):
            if time.monotonic() > end:
                raise ChromiumError(f"{expression} is not true after {timeout_s:g} s; {self.complaints}")
            time.sleep(_LOOK_S)

    def before(self, script: str) -> None:
        """Run a script in each page before its own."""
        self.call("Page.addScriptToEvaluateOnNewDocument", source=script)

    def choose(self, selector: str, *files: Path) -> None:
        """Choose files in a field for files."""
        root = self.call("DOM.getDocument")["root"]["nodeId"]
        node = self.call("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.call("DOM.setFileInputFiles", nodeId=node, files=[str(file) for file in files])

    def click(self, words: str) -> None:
        """Click a button, or the field of a label, with these words."""
        found = f"find((one) => one.textContent.trim() === {json.dumps(words)})"
        self.run(
            f"(([one]) => (one.control ?? one).click())([[...document.querySelectorAll('button, label')].{found}])"
        )

    def size(self, width: int, height: int, *, dark: bool = False) -> None:
        """Give the window a size, and light or dark colours."""
        self.call("Emulation.setFocusEmulationEnabled", enabled=True)
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])

    def picture(self, path: Path) -> None:
        """Save what is seen as a PNG."""
        path.write_bytes(b64decode(self.call("Page.captureScreenshot")["data"]))

    def type(self, text: str) -> None:
        """Type into what has the focus."""
        self.call("Input.insertText", text=text)

    def press(self, key: str, code: int, text: str = "") -> None:
        """Press a key and let it go."""
        down = {"type": "keyDown", "key": key, "windowsVirtualKeyCode": code, "text": text}
        self.call("Input.dispatchKeyEvent", **down)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)
