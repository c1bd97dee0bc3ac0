# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap web`: opens the page."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from sistap import cli
from sistap.tap.common import pages


@pytest.fixture
def page(tmp_path: Path) -> Path:
    path = tmp_path / "sis.html"
    path.touch()
    return path


def test_it_opens_the_page(page: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    shown: list[str] = []
    monkeypatch.setattr(pages, "FOLDERS", (page.with_name("none"), page.parent))
    monkeypatch.setattr(webbrowser, "open", shown.append)
    monkeypatch.setenv("DISPLAY", ":0")
    assert cli.main(["web"]) == 0
    assert shown == [page.as_uri()]
    assert capfd.readouterr().out == f"{page.as_uri()}\n"


def test_without_the_page_it_says_how_to_make_it(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(pages, "FOLDERS", ())
    assert cli.main(["web"]) == 1
    assert "`./bootstrap page`" in capfd.readouterr().err
