# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs the tshark on PATH so that it sees our plugin, also as root.

Run as root, Wireshark silently skips plugins and extcaps that the environment names. So as root this module runs tshark
as nobody, in a temporary folder with copies of the plugins and captures. `python3 -m sistap.dissected.wireshark
ARGUMENTS` does the same for any arguments. Only root and nobody may enter that folder: a capture may be a secret.
"""

from __future__ import annotations

import errno
import itertools
import os
import re
import shutil
import stat
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import IO, Any, NamedTuple

from sistap.dissected.wireshark.trouble import TsharkError as TsharkError  # noqa: PLC0414 - for whoever runs it
from sistap.tap.common import pages, temporary
from sistap.tap.common.complaints import Complaints
from sistap.tap.terminal import programs
from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.state import ROOT, only_root_writes
from sistap.tap.terminal.stop import held

# What the folder of each variable holds; None: programs of any name.
HOLDS: dict[str, tuple[str, ...] | None] = {"WIRESHARK_PLUGIN_DIR": (".so", ".lua"), "WIRESHARK_EXTCAP_DIR": None}
# -- Copies of plugins and extcaps for a tshark that root runs as nobody -----------------------------------------------

# The environment of `sudo -E` is that of its caller. It may name a folder with links to secrets, devices without an end
# and pipes without a reader. So only regular files are copied, of folders that nobody but root can change.

_CHECKOUT = Path(__file__).resolve().parents[4]


def is_roots_alone(path: Path) -> bool:
    """Tell whether only root could have put a file at this path, checked from / downwards."""
    for step in reversed((path, *path.parents)):
        found = step.lstat()
        is_shared = step != path and found.st_mode & stat.S_ISVTX  # like /tmp: everybody adds, only owners remove
        if stat.S_ISLNK(found.st_mode) or not (only_root_writes(found) or (is_shared and found.st_uid in (0, ROOT))):
            return False
    return True


def is_trusted(folder: Path) -> bool:
    """Tell whether only root could have filled a folder, or whoever could have changed this program as well."""
    return is_roots_alone(folder) or (folder.is_relative_to(_CHECKOUT) and not is_roots_alone(_CHECKOUT))


def copy(source: Path, target: Path, suffixes: tuple[str, ...] | None) -> None:
    """Copy the regular files of a folder and its subfolders; follow no link, wait for no pipe. May raise OSError."""
    if sys.platform == "win32":
        return  # there is no root
    is_strict = is_roots_alone(source)
    for folder, folders, names, descriptor in os.fwalk(source):
        if is_strict and not only_root_writes(os.fstat(descriptor)):
            folders.clear()
            continue
        made = target / Path(folder).relative_to(source)
        made.mkdir()
        for name in names:
            if suffixes is None or name.endswith(suffixes):
                _copy_file(name, descriptor, made / name, is_strict=is_strict)


def _copy_file(name: str, folder: int, target: Path, *, is_strict: bool) -> None:
    try:
        descriptor = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK, dir_fd=folder)
    except OSError:  # a link, or a socket
        return
    with open(descriptor, "rb") as file:
        about = os.fstat(descriptor)
        if stat.S_ISREG(about.st_mode) and (only_root_writes(about) or not is_strict):
            with target.open("xb") as made:
                shutil.copyfileobj(file, made)
            target.chmod(stat.S_IMODE(about.st_mode) & 0o777)


# -- tshark ----------------------------------------------------------------------------------------------------------

NOBODY = 65534
OLDEST_WIRESHARK = (4, 0)
_PIECE = 1 << 20  # bytes copied at once
ANSWER_S = 30.0  # for a question about itself: a slow disk needs some seconds for all plugins
ANSWER_BYTES = 4_000_000  # of the answer: all plugins take some 50 kB


def environment(program: str) -> dict[str, str]:
    """Return the environment of a program of Wireshark. A portable one has its own settings, as its starter says."""
    folder = Path(program).parent
    own = dict(os.environ)
    if folder.match(str(programs.PORTABLE)) and (data := folder.parents[1] / "Data").is_dir():
        own.setdefault("WIRESHARK_APPDATA", str(data))
    return own


class Version(NamedTuple):
    """The version of a Wireshark."""

    text: str  # "4.0.17"
    major: int
    minor: int


def version(text: str) -> Version | None:
    """Return the version in the output of `--version`, if it is there."""
    match = re.search(r"(\d+)\.(\d+)\S*\d", text)
    return Version(match[0], int(match[1]), int(match[2])) if match else None


class Loaded(NamedTuple):
    """A plugin that Wireshark has loaded."""

    name: str  # "sis.so"
    version: str
    file: str


def loaded(text: str) -> list[Loaded]:
    """Return sis.so and sis.lua from the output of `-G plugins`: name, version, kind and file of each."""
    rows = [[column.strip() for column in line.split("\t")] for line in text.splitlines()]
    return [Loaded(row[0], row[1], row[-1]) for row in rows if Path(row[0]).stem == "sis" and len(row) > 1]


def found(name: str) -> str:
    """Return the path of a program of Wireshark. May raise TsharkError."""
    if path := programs.of_wireshark(name):
        return path
    if advice().no_wireshark and not programs.of_wireshark("wireshark"):
        page = pages.found(pages.PAGE)
        instead = f"; without it, {page} explains logs and captures in a browser" if page else ""
        raise TsharkError(f"no Wireshark was found: {advice().no_wireshark}{instead}")
    cure = advice().wireshark if name == "wireshark" else advice().tshark
    raise TsharkError(f"{name} is not on PATH; {cure}")


class Used(NamedTuple):
    """The resources that a run of tshark has used."""

    seconds: float  # of processor time
    kilobytes: int  # largest memory


class Tshark:
    """A place to run tshark in; as root with copies of the plugins in a closed folder. Use it in a `with`.

    Its end kills what still runs and removes the copies.
    """

    def __init__(self, program: str = "tshark", *, plugins: Path | None = None, drop_rights: bool = True) -> None:
        """Prepare to run `program`, tshark or a related one. TsharkError if it is not installed.

        It sees the plugins of a folder, or those that WIRESHARK_PLUGIN_DIR names. Without `drop_rights` root stays
        root: then it uses root's own folders, and personal plugins are not loaded.
        """
        self._path = found(program)
        self._environment = environment(self._path)
        if plugins is not None:
            self._environment["WIRESHARK_PLUGIN_DIR"] = str(plugins)
        self._children: list[subprocess.Popen[Any]] = []
        self._own: _OwnFolder | None = None
        with held():
            if drop_rights and sys.platform != "win32" and os.geteuid() == 0:
                self._own = _OwnFolder()
            # Also at the end of the program, if a signal comes between the `with` and its end.
            self._end = weakref.finalize(self, _end, self._children, self._own)
        if self._own:
            try:
                self._own.prepare(self._environment)
            except OSError as error:
                self._end()
                raise TsharkError(
                    f"{self._own.path.parent} has no room for a copy of the plugins ({error.strerror}), which tshark "
                    "needs as root: run it as an ordinary user, or name a larger folder with TMPDIR"
                ) from error

    def __enter__(self) -> Tshark:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End what still runs; remove the folder."""
        with held():
            self._end()

    @contextmanager
    def _command(self, arguments: Sequence[str]) -> Iterator[list[str]]:
        """Return the command; as root, a closed copy replaces the capture after -r while this runs."""
        readable = list(arguments)
        copy = ""
        for index, argument in enumerate(arguments[:-1]):
            if argument == "-r" and self._own and arguments[index + 1] != "-":
                copy = readable[index + 1] = self._own.copy(Path(arguments[index + 1]))
        try:
            yield [self._path, *readable]
        finally:
            if self._own and copy:
                self._own.remove(copy)

    def _settings(self, arguments: Sequence[str]) -> dict[str, Any]:
        """Return the other arguments for subprocess."""
        nobody = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if self._own else {}
        environment = {**self._environment, "LC_ALL": "C.UTF-8", "TZ": "UTC"}
        stdin = subprocess.DEVNULL if "-" not in arguments else None
        return {"stdin": stdin, "cwd": self._own and self._own.path, "env": environment, **nobody}

    def _start(self, command: Sequence[str], **settings: Any) -> subprocess.Popen[Any]:
        """Start a program that `__exit__` ends if it still runs then."""
        self._children[:] = [child for child in self._children if child.returncode is None]
        with held():
            self._children.append(subprocess.Popen(command, **settings))
        return self._children[-1]

    @contextmanager
    def _running(
        self, command: Sequence[str], *, gently: bool = False, **settings: Any
    ) -> Iterator[subprocess.Popen[Any]]:
        """Run a program and wait for its end. If the caller stops early, kill it, or `gently` ask it to end.

        TsharkError if it cannot be started.
        """
        try:
            started = self._start(command, **settings)
        except OSError as error:
            raise TsharkError(f"cannot start {command[0]}: {error.strerror}") from error
        with started as process:
            try:
                yield process
            except BaseException:
                (process.terminate if gently else process.kill)()
                raise

    def run(
        self,
        arguments: Sequence[str],
        *,
        capture: bool = True,
        extra_environment: dict[str, str] | None = None,
        stdin: IO[bytes] | None = None,
    ) -> subprocess.CompletedProcess[str]:
        """Run tshark to its end; `capture` keeps stdout and stderr as text, else they pass through."""
        settings = self._settings(arguments)
        settings["env"] |= extra_environment or {}
        if stdin is not None:
            settings["stdin"] = stdin
        if capture:
            settings |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        with (
            self._command(arguments) as command,
            self._running(command, gently=not capture, encoding="utf-8", errors="replace", **settings) as process,
        ):
            out, err = process.communicate()
        return subprocess.CompletedProcess(command, process.returncode, out, err)

    def lines(self, arguments: Sequence[str]) -> Generator[str, None, None]:
        """Run tshark and yield its stdout line by line. TsharkError after the last line if it failed.

        Closing the generator ends tshark.
        """
        yield from (line.rstrip("\n") for line in self._printed(arguments, iter, encoding="utf-8", errors="replace"))

    def pieces(self, arguments: Sequence[str]) -> Generator[bytes, None, None]:
        """Yield its stdout as it comes, in the same way."""
        yield from self._printed(arguments, lambda stdout: iter(partial(stdout.read1, _PIECE), b""))

    def _printed(
        self, arguments: Sequence[str], read: Callable[[Any], Iterator[Any]], **settings: Any
    ) -> Generator[Any, None, None]:
        with self._command(arguments) as command, Complaints() as complaints:
            settings |= self._settings(arguments) | {"stdout": subprocess.PIPE, "stderr": complaints.stream}
            with self._running(command, **settings) as process:
                complaints.stream.close()
                yield from read(process.stdout)
            if process.returncode != 0:
                raise TsharkError(
                    complaints.text() or f"{Path(self._path).name} ended with exit code {process.returncode}"
                )

    def start(self, arguments: Sequence[str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
        """Start tshark with pipes to its stdin and from its stdout; its stderr goes to `errors`.

        It ends when its stdin does. Until then it dissects what a stop still sends.
        """
        settings = self._settings(arguments) | {
            "stdin": subprocess.PIPE,
            "start_new_session": True,  # Ctrl-C is for sistap alone
        }
        return self._start([self._path, *arguments], stdout=subprocess.PIPE, stderr=errors, **settings)

    def usage(self, arguments: Sequence[str]) -> Used:
        """Run tshark and discard its output; return what it used. TsharkError if it failed."""
        if sys.platform == "win32":
            raise TsharkError("Windows does not tell what a program has used: measure on Linux")
        with (
            self._command(arguments) as command,
            self._running(command, stdout=subprocess.DEVNULL, **self._settings(arguments)) as process,
        ):
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            raise TsharkError(f"{Path(self._path).name} ended with exit code {process.returncode}")
        return Used(usage.ru_utime + usage.ru_stime, usage.ru_maxrss)

    def output(self, *arguments: str) -> str:
        """Run tshark and return its stdout. TsharkError with its last message if it failed."""
        return _good(self.run(arguments))

    def answer(self, *arguments: str) -> str:
        """Do the same for a question about itself, with the limits of `ask`."""
        return _good(self.ask(*arguments))

    def ask(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Ask tshark about itself, as with -G folders. TsharkError if it answers too late, or too much."""
        settings = self._settings(arguments) | {"stdout": subprocess.PIPE, "bufsize": 0}
        command = [self._path, *arguments]
        with Complaints() as complaints:
            with self._running(command, stderr=complaints.stream, **settings) as process:
                complaints.stream.close()
                if trouble := _read_limited(process, answer := bytearray()):
                    cure = "reinstall Wireshark, or take another by `sistap install --wireshark FOLDER`"
                    raise TsharkError(f"{self._path} {' '.join(arguments)} {trouble}: {cure}")
            said = complaints.text()
        return subprocess.CompletedProcess(command, process.returncode, answer.decode(errors="replace"), said)


def _good(done: subprocess.CompletedProcess[str]) -> str:
    if done.returncode != 0:
        words = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise TsharkError(f"{Path(done.args[0]).name}: {words[-1]}")
    return done.stdout


def _read_limited(process: subprocess.Popen[bytes], answer: bytearray) -> str:
    """Read stdout to its end, in a thread, as Windows cannot wait for a pipe; return what is wrong, if anything."""
    stdout, end = process.stdout, time.monotonic() + ANSWER_S

    def read() -> None:
        with suppress(OSError, ValueError):  # closed, as nobody waits any more
            while stdout and len(answer) <= ANSWER_BYTES and (piece := stdout.read(_PIECE)):
                answer.extend(piece)

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    reader.join(ANSWER_S)
    if len(answer) > ANSWER_BYTES:
        return f"answers more than {ANSWER_BYTES:,} bytes"
    with suppress(subprocess.TimeoutExpired):
        if not reader.is_alive():
            process.wait(max(end - time.monotonic(), 0))
            return ""
    return f"does not end within {ANSWER_S:g} s"


class _OwnFolder:
    """A folder for the user nobody, with the plugins and copies of captures. Only root and nobody may enter it.

    It belongs to nobody. So root writes into it through its descriptor, and creates only new files: a link put there by
    another process of nobody leads nowhere.
    """

    def __init__(self) -> None:
        self._folder = temporary.Folder(NOBODY)
        self.path, self._descriptor = self._folder.path, self._folder.descriptor
        self._numbers = itertools.count(1)

    def prepare(self, environment: dict[str, str]) -> None:
        """Fill it, point the environment to its contents, then give it to nobody."""
        home = self.path / "home"
        home.mkdir()
        environment["HOME"] = str(home)
        environment.pop("XDG_CONFIG_HOME", None)
        for variable, suffixes in HOLDS.items():
            source = Path(environment.get(variable) or os.devnull).resolve()
            if not source.is_dir():
                continue
            if not is_trusted(source):
                del environment[variable]
                Console().say(
                    f"{variable} is ignored, because others than root can write to {source}: run this as an ordinary "
                    "user, or name a folder of root's"
                )
                continue
            environment[variable] = str(self.path / variable.lower())
            copy(source, Path(environment[variable]), suffixes)
        for path in (*self.path.rglob("*"), self.path):
            shutil.chown(path, NOBODY, NOBODY)

    def copy(self, capture: Path) -> str:
        """Copy a capture; return the name of the copy. TsharkError if there is no room for it."""
        with capture.open("rb") as source:
            name, descriptor = self._new_file()
            try:
                with open(descriptor, "wb") as copy:
                    if sys.platform != "win32":  # Windows has no root
                        os.fchown(descriptor, NOBODY, NOBODY)
                    shutil.copyfileobj(source, copy, _PIECE)
            except OSError as error:
                self.remove(name)
                if error.errno != errno.ENOSPC:
                    raise
                raise TsharkError(
                    f"{self.path.parent} has no room for a copy of {capture}, which tshark needs as root: run it as "
                    "an ordinary user, or name a larger folder with TMPDIR"
                ) from error
        return str(self.path / name)

    def _new_file(self) -> tuple[str, int]:
        """Make a file for root alone; return its name and a descriptor for writing."""
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW
        while True:
            name = f"capture-{next(self._numbers)}"
            with suppress(FileExistsError):
                return name, os.open(name, flags, 0o600, dir_fd=self._descriptor)

    def remove(self, copy: str) -> None:
        """Remove a copy."""
        with suppress(OSError):
            os.unlink(Path(copy).name, dir_fd=self._descriptor)  # noqa: PTH108 - pathlib has no descriptors

    def close(self) -> None:
        """Remove the folder."""
        self._folder.close()


def _end(children: Sequence[subprocess.Popen[Any]], folder: _OwnFolder | None) -> None:
    for child in children:
        child.kill()
        child.wait()
    if folder:
        folder.close()


if sys.platform == "emscripten":  # a browser, where no process can run
    from sistap.dissected.wireshark.wiregasm import Tshark  # type: ignore[assignment]
