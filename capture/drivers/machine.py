# SPDX-License-Identifier: GPL-2.0-or-later
"""The guest: starts QEMU and controls it; runs programs in it through its agent (guest/agent.py)."""

from __future__ import annotations

import base64
import itertools
import json
import os
import queue
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

Message = dict[str, Any]

PATIENCE_S = 60  # for anything that must happen; a busy computer is slow
BOOT_S = 240
FIRST_WORD_S = 8  # under KVM a kernel prints something within this time, or never
KVM = Path("/dev/kvm")


class NoGuest(Exception):
    """The guest did not come up; the text is one line."""


class Done(NamedTuple):
    """A program of the guest that has ended."""

    code: int
    said: str


class Channel:
    """JSON lines over a socket of QEMU; answers are matched by their number."""

    def __init__(self, path: Path) -> None:
        """Connect. OSError while nobody listens there."""
        self._socket = socket.socket(socket.AF_UNIX)
        self._socket.connect(str(path))
        self._numbers = itertools.count(1)
        self._waiting: dict[int, queue.Queue[Message]] = {}
        self.greeted = threading.Event()
        threading.Thread(target=self._read, daemon=True).start()

    def ask(self, message: Message) -> tuple[int, queue.Queue[Message]]:
        """Send a command; return its number, and the queue of its answers."""
        number = next(self._numbers)
        answers = self._waiting[number] = queue.Queue()
        self._socket.sendall(json.dumps(message | {"id": number}).encode() + b"\n")
        return number, answers

    def call(self, message: Message) -> Message:
        """Send a command; return its one answer."""
        number, answers = self.ask(message)
        try:
            return answers.get(timeout=PATIENCE_S)
        except queue.Empty:
            raise AssertionError(f"no answer for {PATIENCE_S} s to {message}") from None
        finally:
            del self._waiting[number]

    def _read(self) -> None:
        with suppress(OSError), self._socket.makefile("rb") as lines:  # OSError: the guest was killed
            for line in lines:
                message = json.loads(line)
                if "QMP" in message or message.get("id") == 0:
                    self.greeted.set()
                elif message.get("id") in self._waiting:
                    self._waiting[message["id"]].put(message)


class Program:
    """A running program in the guest."""

    def __init__(self, guest: Guest, number: int, answers: queue.Queue[Message]) -> None:
        """Belong to what started it."""
        self._guest, self._number, self._answers = guest, number, answers
        self.said = ""
        self.code: int | None = None

    def until(self, words: str) -> str:
        """Wait for words in its output; return all of the output so far."""
        while words not in self.said:
            assert self.code is None, f"it ended with {self.code} before it said '{words}':\n{self.said}"
            self._take(words)
        return self.said

    def wait(self) -> Done:
        """Wait for its end."""
        while self.code is None:
            self._take("its end")
        return Done(self.code, self.said)

    def look(self) -> str:
        """Return its output so far."""
        while not self._answers.empty():
            self._take("")
        return self.said

    def lines(self) -> list[str]:
        """Return the complete lines of its output so far."""
        return self.look().rpartition("\n")[0].splitlines()

    def say(self, text: str) -> None:
        """Write a line to it."""
        self._guest.agent(do="say", to=self._number, text=text)

    def signal(self, number: signal.Signals) -> None:
        """Send it a signal."""
        self._guest.agent(do="signal", to=self._number, signal=int(number))

    def kill(self) -> None:
        """End it at once."""
        self.signal(signal.SIGKILL)
        self.wait()

    def stop(self) -> Done:
        """Stop it as Ctrl-C does."""
        self.signal(signal.SIGINT)
        return self.wait()

    def _take(self, what: str) -> None:
        try:
            message = self._answers.get(timeout=PATIENCE_S)
        except queue.Empty:
            raise AssertionError(
                f"no output for {PATIENCE_S} s while waiting for '{what}' after:\n{self.said}"
            ) from None
        self.said += message.get("said", "")
        self.code = message.get("code", self.code)


class Guest:
    """A virtual machine that runs."""

    def __init__(self, folder: Path, accelerator: str, devices: Sequence[str]) -> None:
        """Start QEMU with the kernel and the initramfs in a folder, and wait for the agent. May raise NoGuest."""
        self.folder = folder
        self._hasty = accelerator == "kvm"
        for name in ("agent", "qmp", "console", "trace"):
            (folder / name).unlink(missing_ok=True)
        command = [
            *"setpriv --pdeathsig KILL".split(),  # however this ends, no virtual machine stays
            *"qemu-system-x86_64 -nodefaults -display none -no-reboot -machine pc -m 512 -smp 1".split(),
            *"-msg timestamp=on -accel".split(),
            accelerator,
            *("-cpu", "qemu64", "-kernel", "vmlinuz", "-initrd", "guest.cpio", "-append"),
            "console=ttyS0 rdinit=/init mitigations=off 8250.nr_uarts=8 quiet earlyprintk=ttyS0 "
            "no_timer_check",  # on a busy computer the timer is late, and the kernel would panic
            *"-chardev file,id=console,path=console -device isa-serial,chardev=console,index=0".split(),
            *"-chardev socket,id=agent,path=agent,server=on,wait=off -device virtio-serial".split(),
            *"-device virtserialport,chardev=agent,name=agent -qmp unix:qmp,server=on,wait=off".split(),
            *devices,
        ]
        with (folder / "qemu.log").open("w") as log:
            self._qemu = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        try:
            self._monitor = self._connected("qmp")
            self.monitor("qmp_capabilities")
            self._agent = self._connected("agent")
            if "-incoming" not in devices:
                self._wait(self._booted)
        except BaseException:
            self.kill()
            raise

    def agent(self, **message: Any) -> Message:
        """Send the agent a command; OSError with its message if it failed."""
        answer = self._agent.call(message)
        if answer["code"]:
            raise OSError(answer["text"])
        return answer

    def monitor(self, command: str, **arguments: Any) -> Any:
        """Send QEMU a command; OSError with its message if it failed."""
        answer = self._monitor.call({"execute": command, "arguments": arguments})
        if "error" in answer:
            raise OSError(answer["error"]["desc"])
        return answer["return"]

    def start(self, *command: str, user: str = "root") -> Program:
        """Start a program; `sistap` is one."""
        return Program(self, *self._agent.ask({"do": "start", "command": command, "user": user}))

    def run(self, *command: str, user: str = "root") -> Done:
        """Run a program to its end."""
        return self.start(*command, user=user).wait()

    def read(self, path: str) -> bytes:
        """Return a file of the guest."""
        return base64.b64decode(self.agent(do="read", path=path)["data"])

    def write(self, path: str, text: str) -> None:
        """Write a file of the guest, also of sysfs."""
        self.agent(do="write", path=path, text=text)

    def find(self, pattern: str) -> list[str]:
        """List the files of the guest by a pattern."""
        found: list[str] = self.agent(do="find", pattern=pattern)["found"]
        return found

    def kill(self) -> None:
        """Cut the power."""
        self._qemu.kill()
        self._qemu.wait()

    def _connected(self, name: str) -> Channel:
        def connect() -> Channel | None:
            try:
                return Channel(self.folder / name)
            except OSError:
                return None

        return self._wait(connect)

    def _booted(self) -> Channel | None:
        return self._agent if self._agent.greeted.is_set() else None

    def _wait(self, what: Callable[[], Channel | None]) -> Channel:
        begun = time.monotonic()
        while (found := what()) is None:
            silent = self._hasty and not self._console() and time.monotonic() - begun > FIRST_WORD_S
            if self._qemu.poll() is not None or silent or time.monotonic() - begun > BOOT_S:
                log = (self.folder / "qemu.log").read_text().strip().splitlines()
                last = (log or self._console().splitlines() or ["it says nothing"])[-1]
                raise NoGuest(f"the guest did not come up: {last}")
            time.sleep(0.02)
        return found

    def _console(self) -> str:
        console = self.folder / "console"
        return console.read_text(errors="replace") if console.exists() else ""


def eventually(what: Callable[[], bool], why: Callable[[], str]) -> None:
    """Wait until a condition holds; AssertionError with the reason if it never does."""
    end = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < end, why()
        time.sleep(0.05)


def accelerator(folder: Path) -> str:
    """Return the accelerator for a guest: KVM if a kernel really boots on it, else QEMU's translator."""
    if os.access(KVM, os.R_OK | os.W_OK):
        try:
            Guest(folder, "kvm", ()).kill()
            return "kvm"
        except NoGuest:
            pass
    return "tcg,tb-size=256"
