# SPDX-License-Identifier: GPL-2.0-or-later
"""What Windows does not have: said in one line, or not asked for."""

from __future__ import annotations

import os
import re
import socket
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from sistap import cli
from sistap.line import ports
from sistap.line.reader import PortError, open_reader
from sistap.line.settings import LineSettings


class Status(NamedTuple):
    """As much of a file's status as Windows has."""

    st_mode: int = 0o100666


@pytest.fixture(autouse=True)
def windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """As much of it as these tests need."""
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.delattr(socket, "AF_UNIX")
    monkeypatch.delattr(os, "major")


def test_a_port_is_no_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "stat", lambda *_, **__: Status())
    assert not ports.is_own_terminal("COM5")
    assert not ports.adapter("COM5").pseudo_terminal


NO_SOCKETS = "Windows has no sockets that are files: .* HOST:PORT"


def test_a_bus_is_not_looked_for_at_a_path() -> None:
    with pytest.raises(PortError, match=NO_SOCKETS):
        open_reader("bus:///run/bus", LineSettings())


def test_a_bus_does_not_listen_at_a_path(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["bus", "--listen", "./bus"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert re.fullmatch(f"sistap bus: --listen .*{NO_SOCKETS} .*\n", err)
