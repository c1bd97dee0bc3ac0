# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs the tshark that is on PATH so that it sees our plugin, also as root.

Run as root, Wireshark skips plugins and extcaps that an environment names without a word. So as root this module runs
it as nobody, in a folder of its own with copies of the plugins and captures; `python3 -m sistap.tshark ARGUMENTS` is
tshark with that difference.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Generator, Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Any, NamedTuple

NOBODY = 65534
OLDEST_WIRESHARK = (4, 0)
NO_DISSECTOR = (
    "tshark has no dissector for SIS: `sistap install` puts one where it looks, or name its folder in "
    "WIRESHARK_PLUGIN_DIR"
)
_FOLDER_VARIABLES = ("WIRESHARK_PLUGIN_DIR", "WIRESHARK_EXTCAP_DIR")

# Where installers put Wireshark without adding it to PATH.
_FOLDERS = {
    "darwin": "/Applications/Wireshark.app/Contents/MacOS",
    "win32": os.path.join(os.environ.get("PROGRAMFILES", r"C:\Program Files"), "Wireshark"),  # noqa: PTH118
}


class TsharkError(Exception):
    """tshark is missing or failed; the text is the one line to show."""


class Version(NamedTuple):
    """Which Wireshark this is."""

    text: str  # "4.0.17"
    major: int
    minor: int


def version(text: str) -> Version | None:
    """Find the version in what `--version` prints, if it is there."""
    match = re.search(r"(\d+)\.(\d+)\S*\d", text)
    return Version(match[0], int(match[1]), int(match[2])) if match else None


def unknown_fields(said: str) -> set[str]:
    """Find the fields that tshark refuses because it does not know them, in what it says."""
    return set(re.findall(r"^\s+(\S+)$", said, re.MULTILINE)) if "fields aren't valid" in said else set()


class Loaded(NamedTuple):
    """A plugin that Wireshark has loaded."""

    name: str  # "sis.so"
    version: str
    file: str


def loaded(text: str) -> list[Loaded]:
    """Find sis.so and sis.lua in what `-G plugins` prints: name, version, kind and file of each."""
    rows = [[column.strip() for column in line.split("\t")] for line in text.splitlines()]
    return [Loaded(row[0], row[1], row[-1]) for row in rows if Path(row[0]).stem == "sis" and len(row) > 1]


class Used(NamedTuple):
    """What a run of tshark has used."""

    seconds: float  # of processor time
    kilobytes: int  # of memory, at most


class Tshark:
    """A place to run tshark in; as root with a copy of the plugins that nobody can read. Use it in a `with`."""

    def __init__(self, program: str = "tshark", *, plugins: Path | None = None, drop_rights: bool = True) -> None:
        """Prepare to run `program`, tshark or a sister of it. TsharkError if it is not installed.

        It sees the plugins of a folder, or those that WIRESHARK_PLUGIN_DIR names. Root stays root without
        `drop_rights`: then folders are root's own, and personal plugins are not loaded.
        """
        path = shutil.which(program) or shutil.which(program, path=_FOLDERS.get(sys.platform, ""))
        if path is None:
            raise TsharkError(f"{program} is not on PATH; Debian and Ubuntu: apt-get install {program}")
        self._path = path
        self._environment = dict(os.environ)
        if plugins is not None:
            self._environment["WIRESHARK_PLUGIN_DIR"] = str(plugins)
        self._is_root = drop_rights and hasattr(os, "geteuid") and os.geteuid() == 0
        self._folder = Path(tempfile.mkdtemp(prefix="sistap-")) if self._is_root else None
        if self._folder is not None:
            self._prepare(self._folder)

    def _prepare(self, folder: Path) -> None:
        folder.chmod(0o755)
        home = folder / "home"
        home.mkdir()
        if sys.platform != "win32":
            os.chown(home, NOBODY, NOBODY)
        self._environment["HOME"] = str(home)
        self._environment.pop("XDG_CONFIG_HOME", None)
        for variable in _FOLDER_VARIABLES:
            source = self._environment.get(variable)
            if source and Path(source).is_dir():
                copy = folder / variable.lower()
                shutil.copytree(source, copy)
                copy.chmod(0o755)
                self._environment[variable] = str(copy)

    def __enter__(self) -> Tshark:
        """Nothing more to do."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove the folder."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)

    def _readable(self, arguments: Sequence[str]) -> list[str]:
        """Replace the capture after -r by a copy that nobody can read."""
        readable = list(arguments)
        for index, argument in enumerate(readable[:-1]):
            if argument == "-r" and self._folder is not None and readable[index + 1] != "-":
                copy = self._folder / "capture"
                _copy(Path(readable[index + 1]), copy)
                copy.chmod(0o644)
                readable[index + 1] = str(copy)
        return readable

    def _settings(self, arguments: Sequence[str]) -> dict[str, Any]:
        """Make what subprocess has to be told beside the command."""
        nobody = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if self._is_root else {}
        environment = {**self._environment, "LC_ALL": "C.UTF-8", "TZ": "UTC"}
        stdin = subprocess.DEVNULL if "-" not in arguments else None
        return {"stdin": stdin, "cwd": self._folder, "env": environment, **nobody}

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
        command = [self._path, *self._readable(arguments)]
        return subprocess.run(
            command, check=False, text=True, encoding="utf-8", errors="replace", capture_output=capture, **settings
        )

    def lines(self, arguments: Sequence[str]) -> Generator[str, None, None]:
        """Run tshark and yield its stdout line by line, as it comes. TsharkError, after the last, if it failed.

        Who does not want the rest closes the generator: that ends tshark.
        """
        command = [self._path, *self._readable(arguments)]
        with tempfile.TemporaryFile() as errors:
            with subprocess.Popen(
                command,
                stdout=subprocess.PIPE,
                stderr=errors,
                encoding="utf-8",
                errors="replace",
                **self._settings(arguments),
            ) as process:
                assert process.stdout is not None
                try:
                    for line in process.stdout:
                        yield line.rstrip("\n")
                except BaseException:  # nobody wants the rest
                    process.kill()
                    raise
            if process.returncode != 0:
                errors.seek(0)
                said = errors.read().decode(errors="replace").strip()
                raise TsharkError(said or f"{Path(self._path).name} ended with exit code {process.returncode}")

    def start(self, arguments: Sequence[str], errors: IO[bytes]) -> subprocess.Popen[bytes]:
        """Start tshark with pipes to its stdin and from its stdout; what it says on stderr goes to `errors`."""
        settings = self._settings(arguments) | {"stdin": subprocess.PIPE}
        return subprocess.Popen([self._path, *arguments], stdout=subprocess.PIPE, stderr=errors, **settings)

    def usage(self, arguments: Sequence[str]) -> Used:
        """Run tshark with its output thrown away; return what it used. TsharkError if it failed."""
        if sys.platform == "win32":
            raise TsharkError("Windows does not tell what a program has used: measure on Linux")
        command = [self._path, *self._readable(arguments)]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, **self._settings(arguments)) as process:
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            raise TsharkError(f"{Path(self._path).name} ended with exit code {process.returncode}")
        return Used(usage.ru_utime + usage.ru_stime, usage.ru_maxrss)

    def output(self, *arguments: str) -> str:
        """Run tshark and give its stdout. TsharkError with its last words if it failed."""
        done = self.run(arguments)
        if done.returncode != 0:
            words = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            raise TsharkError(f"{Path(self._path).name}: {words[-1]}")
        return done.stdout


def _copy(capture: Path, copy: Path) -> None:
    """Copy a capture. TsharkError if there is no room for it."""
    try:
        shutil.copyfile(capture, copy)
    except OSError as error:
        if error.errno != errno.ENOSPC:
            raise
        raise TsharkError(
            f"{copy.parent.parent} has no room for a copy of {capture}, which tshark needs as root: run it as an "
            "ordinary user, or name a larger folder with TMPDIR"
        ) from error


def main() -> int:
    """Be tshark."""
    try:
        with Tshark() as tshark:
            return tshark.run(sys.argv[1:], capture=False).returncode
    except (TsharkError, OSError) as error:
        print(f"sistap: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
