# SPDX-License-Identifier: GPL-2.0-or-later
"""tshark with the C plugin that was built, and with sis.lua instead; the page in node and as a file.

Tests of the page are skipped where its packages are not downloaded.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
PAGE = HERE / "page"
NPM = HERE.parent / "build" / "npm"
sys.path[:0] = [str(HERE), str(HERE.parent / "test-captures"), str(HERE.parent / "capture")]
sys.path[len(sys.path) :] = [str(HERE.parent / "capture" / "tests"), str(HERE.parent / "plugin" / "protocol")]

from chromium import Chromium, program  # noqa: E402
from parity import SCRIPT  # noqa: E402
from sistap.dissected.wireshark.tshark import Tshark  # noqa: E402


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of the page."""
    for item in items:
        if PAGE in item.path.parents:
            item.add_marker("page")


@pytest.fixture(scope="session")
def plugin() -> Iterator[Tshark]:
    """Run tshark with the C plugin that was built."""
    with Tshark() as tshark:
        plugins = tshark.output("-G", "plugins")
        assert "sis.so" in plugins, "tshark does not load sis.so; ./bootstrap test sets WIRESHARK_PLUGIN_DIR"
        assert "sis.lua" not in plugins, "a sis.lua is installed; these tests bring their own"
        yield tshark


@pytest.fixture(scope="session")
def script(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tshark]:
    """Run tshark with sis.lua, and without the C plugin."""
    folder = tmp_path_factory.mktemp("script")
    shutil.copy(SCRIPT, folder)
    with Tshark(plugins=folder) as tshark:
        plugins = tshark.output("-G", "plugins")
        assert "sis.lua" in plugins, "tshark does not load sis.lua; was it built without Lua?"
        assert "sis.so" not in plugins, "sis.so is installed; sis.lua would leave everything to it"
        yield tshark


@pytest.fixture(scope="session")
def npm() -> Path:
    """Return the folder of packages."""
    lock, stamp = PAGE / "package-lock.json", NPM / "stamp"
    if shutil.which("node") is None or not stamp.exists() or stamp.read_text() != lock.read_text():
        pytest.skip("the packages of the page are not there: ./bootstrap page downloads them from npm")
    return NPM


@pytest.fixture(scope="session")
def node(npm: Path) -> Callable[..., Any]:
    """Run a script of page/test with arguments; return the JSON that it prints."""

    def run(script: str, *arguments: str | Path) -> Any:
        command = ["node", str(PAGE / "test" / script), *map(str, arguments)]
        done = subprocess.run(command, env={**os.environ, "NPM": str(npm)}, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[-3000:]
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def page(npm: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the page; return its one file."""
    folder = tmp_path_factory.mktemp("page")
    subprocess.run(["node", str(PAGE / "build.mjs"), str(npm), str(folder)], check=True)
    return folder / "sis.html"


@pytest.fixture(scope="module")
def browser() -> Iterator[Chromium]:
    """Start chromium."""
    if program() is None:
        pytest.skip("needs chromium (Debian: chromium)")
    with Chromium() as browser:
        yield browser


@pytest.fixture
def window(browser: Chromium) -> Iterator[Chromium]:
    """Open a window that remembers nothing; no page in it may complain."""
    browser.renew()
    browser.size(1280, 860)
    yield browser
    assert browser.complaints == []


@pytest.fixture
def chromium(window: Chromium, page: Path) -> Chromium:
    """Open the page."""
    window.open(page.as_uri())
    window.until("document.documentElement.dataset.ready")
    return window
