# SPDX-License-Identifier: GPL-2.0-or-later
"""The guest's side of ../machine.py: starts programs, returns their output, and transfers files.

Commands and answers are lines of JSON through a virtio-serial port. sistap runs as a fork of this process, which has
imported it: importing takes seconds on an emulated processor.
"""

from __future__ import annotations

import base64
import importlib
import json
import os
import selectors
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

PORT = "/dev/virtio-ports/agent"
USERS = {"root": (0, []), "tap": (1000, [20]), "outsider": (1001, [])}  # number, groups: dialout has the serial ports
OURS = ("adapter", "gadget", "opened", "port", "terminal", "uart", "usbmon")  # modules beside this with a main()
LOADED = (
    "sistap.cli sistap.tap.capture.command sistap.tap.capture.running sistap.commands.doctor "
    "sistap.commands.extcap.command sistap.commands.extcap.started sistap.tap.line.ports sistap.commands.selftest "
    "serial.tools.list_ports"
).split()

Message = dict[str, Any]


class Agent:
    """Executes the commands of the host one after the other; programs run in parallel."""

    def __init__(self, port: int) -> None:
        """Serve at a descriptor."""
        self._port = port
        self._rest = b""
        self._selector = selectors.DefaultSelector()
        self._selector.register(port, selectors.EVENT_READ)
        # keyed by the number of the command: process, its output, its input
        self._programs: dict[int, tuple[int, int, int]] = {}
        self._tell({"id": 0})

    def serve(self) -> NoReturn:
        """Serve endlessly."""
        while True:
            for key, _ in self._selector.select(0.02):
                if key.fd == self._port:
                    self._take()
                else:
                    self._pass_on(key.data, key.fd)
            self._reap()

    def _take(self) -> None:
        data = os.read(self._port, 1 << 16)
        if not data:  # the other end is not connected
            time.sleep(0.02)
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            message = json.loads(line)
            do: Callable[[Message], Message | None] = getattr(self, "do_" + message["do"])
            try:
                answer = do(message)
            except (OSError, KeyError) as error:  # KeyError: a program that has ended
                answer = {"code": 1, "text": repr(error)}
            if answer is not None:
                self._tell({"id": message["id"]} | answer)

    def do_start(self, message: Message) -> None:
        """Start a program as a user."""
        output, theirs = os.pipe()
        their_input, to_it = os.pipe()
        process = os.fork()
        if not process:
            os.setsid()
            for descriptor, number in ((their_input, 0), (theirs, 1), (theirs, 2)):
                os.dup2(descriptor, number)
            os.closerange(3, 1000)
            _become(message["command"], *USERS[message["user"]])
        os.close(theirs)
        os.close(their_input)
        os.set_blocking(output, False)
        self._programs[message["id"]] = process, output, to_it
        self._selector.register(output, selectors.EVENT_READ, message["id"])

    def do_say(self, message: Message) -> Message:
        """Write a line to a program."""
        os.write(self._programs[message["to"]][2], message["text"].encode() + b"\n")
        return {"code": 0}

    def do_signal(self, message: Message) -> Message:
        """Send a signal to a program."""
        if message["to"] in self._programs:
            os.kill(self._programs[message["to"]][0], message["signal"])
        return {"code": 0}

    def do_read(self, message: Message) -> Message:
        """Return a file."""
        return {"code": 0, "data": base64.b64encode(Path(message["path"]).read_bytes()).decode()}

    def do_write(self, message: Message) -> Message:
        """Write a file, also of sysfs."""
        Path(message["path"]).write_text(message["text"])
        return {"code": 0}

    def do_find(self, message: Message) -> Message:
        """Return the files that match a pattern."""
        return {"code": 0, "found": sorted(map(str, Path("/").glob(message["pattern"].lstrip("/"))))}

    def do_clock(self, _: Message) -> Message:
        """Return the time of the guest, in ns."""
        return {"code": 0, "ns": time.time_ns()}

    def _pass_on(self, number: int, output: int) -> None:
        with suppress(BlockingIOError):
            while data := os.read(output, 1 << 14):
                self._tell({"id": number, "said": data.decode(errors="replace")})

    def _reap(self) -> None:
        with suppress(ChildProcessError):
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                for number, (process, output, to_it) in list(self._programs.items()):
                    if process == ended[0]:
                        self._pass_on(number, output)
                        self._selector.unregister(output)
                        os.close(output)
                        os.close(to_it)
                        del self._programs[number]
                        self._tell({"id": number, "code": os.waitstatus_to_exitcode(ended[1])})

    def _tell(self, message: Message) -> None:
        data = json.dumps(message).encode() + b"\n"
        while data:
            data = data[os.write(self._port, data) :]


def _become(command: list[str], user: int, groups: list[int]) -> NoReturn:
    """Turn this fork into a program of a user."""
    code = 1
    try:
        os.setgroups(groups)
        os.setgid(user)
        os.setuid(user)
        home = {0: "/root", 1000: "/home/tap", 1001: "/home/outsider"}[user]
        os.environ["HOME"] = home
        os.chdir(home)
        sys.stdin = os.fdopen(0)
        sys.stdout, sys.stderr = (os.fdopen(number, "w", buffering=1) for number in (1, 2))
        sys.argv = command
        code = _run(command)
        sys.stdout.flush()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    except BaseException:  # noqa: B036 - a fork must not go on as the agent
        traceback.print_exc(file=sys.stderr)
    finally:
        os._exit(code)


def _run(command: list[str]) -> int:
    name, *arguments = command
    if name == "sistap":
        from sistap.__main__ import main

        return main()
    if name in OURS:
        code: int = importlib.import_module(name).main(*arguments)
        return code
    return os.execvp(name, command)


if __name__ == "__main__":
    for module in LOADED:
        importlib.import_module(module)
    Agent(os.open(PORT, os.O_RDWR)).serve()
