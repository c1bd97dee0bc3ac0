# SPDX-License-Identifier: GPL-2.0-or-later
"""Runs a command of sistap in a process of its own, and checks how it refuses.

The process is a fork of one that has imported sistap, because importing takes longer than most commands.
Windows has no fork, so there it is a new process.
"""

from __future__ import annotations

import io
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

TIMEOUT_S = 120

if sys.platform != "win32":
    _PROCESSES = multiprocessing.get_context("forkserver")
    _PROCESSES.set_forkserver_preload(
        [
            "sistap.cli",
            "sistap.commands.report.command",
            "sistap.commands.report.running",
            "sistap.commands.annotate.annotating",
            "sistap.commands.annotate.log",
        ]
    )


def run(folder: Path, *arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run `sistap` in a folder without input; check that there is no traceback."""
    return _as_text(run_with(folder, b"", *arguments, **environment))


def run_with(
    folder: Path, stdin: bytes, *arguments: str | Path, **environment: str
) -> subprocess.CompletedProcess[bytes]:
    """Run `sistap` in a folder with this standard input; check that there is no traceback."""
    words = list(map(str, arguments))
    if sys.platform == "win32":
        return _run_new(folder, stdin, words, environment)
    with tempfile.TemporaryDirectory() as place:
        files = [Path(place, name) for name in ("in", "out", "errors")]
        files[0].write_bytes(stdin)
        process = _PROCESSES.Process(target=_main, args=(folder, words, dict(os.environ) | environment, files))
        process.start()
        process.join(TIMEOUT_S)
        code = process.exitcode
        if code is None:
            process.kill()
            process.join()
            raise subprocess.TimeoutExpired(words, TIMEOUT_S)
        out, errors = (file.read_bytes() for file in files[1:])
    assert b"Traceback" not in errors
    return subprocess.CompletedProcess(words, code, out, errors)


def run_anew(folder: Path, *arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run `sistap` in a new interpreter, for effects of importing."""
    return _as_text(_run_new(folder, b"", list(map(str, arguments)), environment))


def _as_text(done: subprocess.CompletedProcess[bytes]) -> subprocess.CompletedProcess[str]:
    out, errors = (stream.decode().replace(os.linesep, "\n") for stream in (done.stdout, done.stderr))
    return subprocess.CompletedProcess(done.args, done.returncode, out, errors)


def _run_new(
    folder: Path, stdin: bytes, words: list[str], environment: dict[str, str]
) -> subprocess.CompletedProcess[bytes]:
    done = subprocess.run(
        [sys.executable, "-m", "sistap", *words],
        cwd=folder,
        env=os.environ | environment,
        input=stdin,
        capture_output=True,
        check=False,
        timeout=TIMEOUT_S,
    )
    assert b"Traceback" not in done.stderr
    return done


def _main(folder: Path, arguments: list[str], environment: dict[str, str], files: list[Path]) -> None:
    """Run sistap after restoring what a new interpreter sets up."""
    assert sys.platform != "win32"
    for descriptor, file in enumerate(files):
        with file.open("wb" if descriptor else "rb") as stream:
            os.dup2(stream.fileno(), descriptor)
    sys.stdin = io.TextIOWrapper(io.BufferedReader(io.FileIO(0, "r", closefd=False)))
    sys.stdout, sys.stderr = (
        io.TextIOWrapper(io.BufferedWriter(io.FileIO(number, "w", closefd=False))) for number in (1, 2)
    )
    os.environ.clear()
    os.environ.update(environment)
    time.tzset()
    os.chdir(folder)
    sys.argv = ["sistap", *arguments]
    from sistap import cli  # noqa: PLC0415 - it is loaded already

    sys.exit(cli.main())


def refused(done: subprocess.CompletedProcess[str], code: int, *words: str) -> None:
    """Check that it printed one line with these words, and nothing else."""
    assert done.returncode == code
    assert done.stdout == ""
    assert done.stderr.startswith("sistap: ")
    assert done.stderr.count("\n") == 1
    assert all(word in done.stderr for word in words)
