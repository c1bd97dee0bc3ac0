# SPDX-License-Identifier: GPL-2.0-or-later
"""Completion in a real bash and a real zsh: every command, every option, and the words that can be listed."""

from __future__ import annotations

import argparse
import os
import pty
import re
import select
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from sistap import cli
from sistap.commands.install import completion

COMMANDS = next(action for action in cli.parser()._actions if isinstance(action, argparse._SubParsersAction)).choices

needs_zsh = pytest.mark.skipif(not shutil.which("zsh"), reason="needs zsh")

# What bash is asked: the words of a line, the last one not finished, one line each.
ASK_BASH = """\
. "$1"
while IFS= read -r line; do
    COMP_WORDS=($line)
    [ "${line% }" = "$line" ] || COMP_WORDS+=('')
    COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
    COMPREPLY=()
    _sistap
    echo "${COMPREPLY[@]}"
done
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("bash") / "sistap"
    file.write_text(completion.bash(cli.parser()))
    return file


def bash(script: Path, *lines: str) -> list[set[str]]:
    """Return what bash offers at the end of each line."""
    arguments = ["bash", "--norc", "-c", ASK_BASH, "bash", str(script)]
    typed = "".join(f"{line}\n" for line in lines)
    done = subprocess.run(arguments, input=typed, capture_output=True, text=True, check=True, cwd=script.parent)
    assert done.stderr == ""
    return [set(line.split()) for line in done.stdout.splitlines()]


def test_bash_knows_every_command_and_every_option(script: Path) -> None:
    (commands,) = bash(script, "sistap ")
    assert commands == {*cli.COMMANDS, "-h", "--help", "--version"}
    offered = bash(script, *(f"sistap {name} -" for name in COMMANDS))
    assert offered == [in_help(name) for name in COMMANDS]


def in_help(name: str) -> set[str]:
    """Return the options that the help names: at the beginning of its lines."""
    found = re.findall(r"^  (-\w|--[\w-]+)(?:, (--[\w-]+))?", COMMANDS[name].format_help(), re.MULTILINE)
    return {option for pair in found for option in pair if option}


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("sistap cap", {"capture"}),
        ("sistap capture --framing ", {"sis", "3964r", "ascii"}),
        ("sistap capture --baud = a", {"auto"}),
        ("sistap capture --baud =", {"auto"}),
        ("sistap report --format s", {"svg"}),
        ("sistap bus lat", {"late-reaction"}),
        ("sistap capture -w ", set()),  # then bash has names of files
        ("sistap replay ", set()),
        ("sistap nonsense ", set()),
    ],
)
def test_bash_offers(script: Path, typed: str, offered: set[str]) -> None:
    assert bash(script, typed) == [offered]


def test_scenarios_are_those_of_bus(script: Path, capfd: pytest.CaptureFixture[str]) -> None:
    cli.main(["bus", "--list"])
    assert bash(script, "sistap bus ") == [{line.split()[0] for line in capfd.readouterr().out.splitlines()}]


def zsh(folder: Path, *lines: str) -> list[str]:
    """Return what a zsh at a terminal makes of each line after Tab."""
    (folder / "_sistap").write_text(completion.zsh(cli.parser()))
    (folder / "a-file.pcapng").touch()
    setup = (
        f"fpath=({folder} $fpath); autoload -Uz compinit; compinit -D -u; PS1=; "
        'unsetopt prompt_sp; setopt no_list_ambiguous; sistap() { print -r -- "said:$*:" }; print ready\n'
    )
    process, terminal = pty.fork()
    if process == 0:
        os.chdir(folder)
        os.execvpe("zsh", ["zsh", "-f", "-i"], {"PATH": os.environ["PATH"], "TERM": "dumb", "HOME": str(folder)})
    try:
        os.write(terminal, setup.encode())
        _until(terminal, "\nready")
        results = []
        for line in lines:
            os.write(terminal, f"{line}\t\n".encode())
            said = _until(terminal, ":\r\n")
            results.append(re.findall("said:(.*):", said)[-1].strip())
        return results
    finally:
        os.close(terminal)
        os.waitpid(process, 0)


def _until(terminal: int, wanted: str) -> str:
    said = ""
    end = time.monotonic() + 60
    while wanted not in said:
        assert select.select([terminal], [], [], end - time.monotonic())[0], said
        said += os.read(terminal, 4096).decode(errors="replace")
    return said


@needs_zsh
def test_zsh_completes(tmp_path: Path) -> None:
    wanted = {
        "sistap cap": "capture",
        "sistap capture --fol": "capture --follow-baud",
        "sistap capture --framing 39": "capture --framing 3964r",
        "sistap bus lat": "bus late-reaction",
        "sistap report --format=sv": "report --format=svg",
        "sistap replay a-f": "replay a-file.pcapng",
        "sistap uninst": "uninstall",
    }
    assert zsh(tmp_path, *wanted) == list(wanted.values())


@needs_zsh
def test_zsh_reads_it_without_a_complaint(tmp_path: Path) -> None:
    (tmp_path / "_sistap").write_text(completion.zsh(cli.parser()))
    done = subprocess.run(["zsh", "-f", "-n", tmp_path / "_sistap"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
