# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap help` opens the handbook, or says how to get it."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from sistap import cli
from sistap.tap.common import pages


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(pages, "FOLDERS", (tmp_path / "nowhere", tmp_path))
    return tmp_path


def test_it_opens_the_first_page(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shown: list[str] = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(webbrowser, "open", shown.append)
    first = folder / "docs" / "index.html"
    first.parent.mkdir()
    first.touch()
    assert cli.main(["help"]) == 0
    assert shown == [first.as_uri()] == capsys.readouterr().out.splitlines()


@pytest.mark.usefixtures("folder")
def test_without_a_handbook(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["help"]) == 1
    assert "`./bootstrap docs`" in capfd.readouterr().err
