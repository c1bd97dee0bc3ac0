# SPDX-License-Identifier: GPL-2.0-or-later
"""A warning of a new compiler stops developers of the plugin, never those who only build it."""

from __future__ import annotations

import json
import os
import re
import subprocess
from pathlib import Path

import pytest

import sistap

HOUSE = Path(__file__).parent.parent
AS_ERRORS = "-DCMAKE_COMPILE_WARNING_AS_ERROR=ON"


def compilers_options(build: Path, *options: str) -> list[set[str]]:
    """Return what the compiler is told for each of its calls."""
    command = ["cmake", "-S", str(HOUSE), "-B", str(build), "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", *options]
    subprocess.run(command, check=True, capture_output=True)
    calls = json.loads((build / "compile_commands.json").read_text())
    return [set(call["command"].split()) for call in calls]


@pytest.mark.thorough
def test_plain_build(tmp_path: Path) -> None:
    calls = compilers_options(tmp_path)
    assert calls
    assert all({"-Wall", "-Wextra"} < call for call in calls)
    assert not any("-Werror" in call for call in calls)


@pytest.mark.thorough
def test_the_version_is_that_of_the_python_package(tmp_path: Path) -> None:
    said = {option for call in compilers_options(tmp_path) for option in call if "PLUGIN_VERSION" in option}
    assert said == {f'-DPLUGIN_VERSION=\\"{sistap.__version__}\\"'}
    for other in ("CMakeLists.txt", "capture/pyproject.toml"):
        assert sistap.__version__ not in (HOUSE / other).read_text()


def test_the_plugin_is_hardened() -> None:
    """Hardened as Debian's programs: calls are bound at load time, and those with a known size are checked."""
    plugin = next(Path(os.environ["WIRESHARK_PLUGIN_DIR"]).rglob("sis.so"))
    said = {option: readelf(plugin, option) for option in ("--dynamic", "--dyn-syms")}
    assert "BIND_NOW" in said["--dynamic"]
    assert re.search(r"__\w+_chk@", said["--dyn-syms"])
    assert "__stack_chk_fail@" in said["--dyn-syms"]


def test_the_plugin_does_not_know_where_it_was_built() -> None:
    """The same sources make the same bytes in every folder: also what helps a debugger names no folder."""
    plugin = next(Path(os.environ["WIRESHARK_PLUGIN_DIR"]).rglob("sis.so")).read_bytes()
    assert b"plugin/sis/packet-sis.c" in plugin  # it is there, and can be read
    assert bytes(HOUSE.resolve()) not in plugin


def readelf(file: Path, option: str) -> str:
    return subprocess.run(["readelf", "--wide", option, file], check=True, capture_output=True, text=True).stdout


@pytest.mark.thorough
def test_build_of_who_develops(tmp_path: Path) -> None:
    assert all("-Werror" in call for call in compilers_options(tmp_path, AS_ERRORS))


@pytest.mark.parametrize("script", ["bootstrap", "test-captures/wiresharks"])
def test_scripts_want_errors(script: str) -> None:
    text = (HOUSE / script).read_text().replace("\\\n", "")
    lines = [line for line in text.splitlines() if "cmake -S" in line]
    assert lines
    assert all(AS_ERRORS in line for line in lines)
