# SPDX-License-Identifier: GPL-2.0-or-later
"""The command line as a whole."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest
from portable import sockets

from sistap import cli
from sistap.tap.terminal.exits import DONE, FAILED, USAGE

pytestmark = pytest.mark.tap


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the parsers that are made."""
    names: list[str] = []

    class Parser(cli._Parser):
        def __init__(self, prog: str, **settings: object) -> None:
            names.append(prog)
            super().__init__(prog, **settings)  # type: ignore[arg-type]

    monkeypatch.setattr(cli, "_Parser", Parser)
    return names


def test_a_command_makes_no_parsers_of_others(made: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Each takes half a millisecond, at every start."""
    with pytest.raises(SystemExit):
        cli.main(["capture", "--help"])
    assert made == ["sistap", "sistap capture"]
    assert capsys.readouterr().out.startswith("usage: sistap capture ")


@pytest.mark.parametrize(
    ("arguments", "code"), [([], USAGE), (["--help"], DONE), (["--help", "capture"], DONE), (["no-such"], USAGE)]
)
def test_without_a_command_all_are_named(arguments: list[str], code: int, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        assert cli.main(arguments) == code
    except SystemExit as error:
        assert error.code == code
    said = "".join(capsys.readouterr())
    assert all(name in said for name in cli.COMMANDS)


@pytest.mark.attack("/dev/null is missing", "a line says so, with the cure")
@pytest.mark.parametrize("command", ["report", "log", "capture", "install", "doctor", "import", "--version"])
def test_a_missing_null_device(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str], command: str
) -> None:
    with monkeypatch.context() as missing:
        missing.setattr(os, "devnull", str(tmp_path / "null"))
        assert cli.main([command]) == FAILED
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert err.startswith(f"sistap: {tmp_path / 'null'} cannot be opened (No such file or directory): ")


@sockets
def test_something_else_is_in_its_place(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)  # the name of a socket must be short
    with socket.socket(socket.AF_UNIX) as other, monkeypatch.context() as missing:
        other.bind("null")
        missing.setattr(os, "devnull", "null")
        assert cli.main(["report"]) == FAILED
    assert capfd.readouterr().err.startswith("sistap: null cannot be opened (No such device or address): ")
