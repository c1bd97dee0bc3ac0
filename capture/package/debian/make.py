#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Makes the parts of the .deb that the sources lack: manual pages, changelogs, completion, and the launchers.

usage: make.py ROOT EXTCAP VERSION MAINTAINER; capture/ must be on PYTHONPATH, and help2man (Debian) on PATH.
"""

from __future__ import annotations

import argparse
import gzip
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from email.utils import formatdate
from pathlib import Path

import sistap
from sistap import cli
from sistap.commands.install import completion, shell

HOUSE = Path(__file__).resolve().parents[3]
INTERPRETER, PRIVATE = "/usr/bin/python3", Path("/usr/share/sistap")
NOW = int(os.environ.get("SOURCE_DATE_EPOCH", time.time()))

CHANGELOG = """\
sistap ({version}) unstable; urgency=medium

  * Package of sistap {upstream}. What has changed in it is in changelog.gz.

 -- {maintainer}  {date}
"""


def main() -> int:
    """Write the files below ROOT; return the exit code."""
    root, extcap, version, maintainer = sys.argv[1:]
    if not shutil.which("help2man"):
        print("the .deb needs help2man for its manual pages: apt-get install help2man", file=sys.stderr)
        return 1
    shutil.rmtree(root, ignore_errors=True)
    for name, content in _files(extcap.lstrip("/"), version, maintainer):
        file = Path(root, name)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
        file.chmod(0o755 if content.startswith(b"#!") else 0o644)
    return 0


def _files(extcap: str, version: str, maintainer: str) -> Iterator[tuple[str, bytes]]:
    whole = cli.parser()
    yield "usr/bin/sistap", shell.command(INTERPRETER, PRIVATE, False).encode()
    yield f"{extcap}/sistap", shell.launcher(INTERPRETER, PRIVATE, False).encode()
    yield "usr/share/bash-completion/completions/sistap", completion.bash(whole).encode()
    yield "usr/share/zsh/vendor-completions/_sistap", completion.zsh(whole).encode()
    entry = CHANGELOG.format(
        version=version, upstream=sistap.__version__, maintainer=maintainer, date=formatdate(NOW, localtime=False)
    )
    yield "usr/share/doc/sistap/changelog.Debian.gz", _packed(entry.encode())
    yield "usr/share/doc/sistap/changelog.gz", _packed((HOUSE / "CHANGELOG.md").read_bytes())
    os.environ["COLUMNS"] = "1000"  # keep argparse from breaking lines: the reader of manual pages does that
    commands = next(action for action in whole._actions if isinstance(action, argparse._SubParsersAction)).choices
    pages = {"sistap": ("a passive tap for the SIS serial protocol of Rexroth and Indramat drives", whole)}
    pages |= {f"sistap-{name}": (cli.COMMANDS[name][1], command) for name, command in commands.items()}
    for name, (text, parser) in pages.items():
        others = pages.keys() - {name} if parser is whole else {"sistap"}
        yield f"usr/share/man/man1/{name}.1.gz", _packed(_page(name, text, parser.format_help(), others))


def _page(name: str, text: str, said: str, others: set[str]) -> bytes:
    """Return a manual page made from the output of --help."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder, name)  # help2man takes the name from the program that it runs
        Path(folder, "help").write_text(_as_help2man_reads(said))
        Path(folder, "more").write_text(f"[see also]\n{_see_also(others)}\n")
        program.write_text(f'#!/bin/sh\ncat "{folder}/help"\n')
        program.chmod(0o755)
        command = ["help2man", "--no-info", "--name", text, "--include", f"{folder}/more", "--version-string"]
        environment = {**os.environ, "SOURCE_DATE_EPOCH": str(NOW), "LC_ALL": "C.UTF-8"}
        return subprocess.run(
            [*command, sistap.__version__, str(program)], check=True, stdout=subprocess.PIPE, env=environment
        ).stdout


def _see_also(others: set[str]) -> str:
    return ",\n".join(f".BR {name} (1)" for name in sorted(others))


def _as_help2man_reads(said: str) -> str:
    """Convert argparse's headings to those that help2man knows."""
    said = re.sub(r"^usage: ", "Usage: ", said)
    said = said.replace("positional arguments:\n  COMMAND\n", "commands:\n").replace(
        "positional arguments:", "arguments:"
    )
    said = re.sub(r"^(\w[\w ,]*):$", lambda heading: f"*{heading[1].capitalize()}*", said, flags=re.MULTILINE)
    return re.sub(r"^    (\w+)\n +", r"    \1  ", said, flags=re.MULTILINE)  # a long command has a line of its own


def _packed(content: bytes) -> bytes:
    return gzip.compress(content, 9, mtime=0)


if __name__ == "__main__":
    sys.exit(main())
