# SPDX-License-Identifier: GPL-2.0-or-later
"""What to do is said in the words of the system."""

from __future__ import annotations

import ast
import bz2
import gzip
import importlib
import lzma
import re
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path

import pytest
from portable import posix

import sistap
from sistap.cli import COMMANDS, examples
from sistap.tap.common.packages import missing
from sistap.tap.common.packed import unpack
from sistap.tap.terminal import rights
from sistap.tap.terminal.advice import advice, shell_word
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.rights import as_typed

PACKAGE = Path(sistap.__file__).parent
WORDS = re.compile("dmesg|limits.conf|apt-get|dialout|python3-|libpcap0")

# Where else such words may stand: in modules that Windows never loads, and where the programs of Linux are named.
LINUX_ALONE = {"others.py": "`sudo apt-get remove brltty`"}
LINUX_FILES = {"probe.py", "packages.py"}  # of sysfs, of a program that others get elsewhere, of Python


@pytest.mark.parametrize(
    ("pack", "command"),
    [
        (lzma.compress, "xz -dk"),
        (gzip.compress, "gunzip -k"),
        (bz2.compress, "bunzip2 -k"),
        (bytes.fromhex("04224D18").__add__, "lz4 -dk"),
        (bytes.fromhex("28B52FFD").__add__, "zstd -dk"),
    ],
)
def test_a_packed_file_is_known_by_its_first_bytes(
    tmp_path: Path, pack: Callable[[bytes], bytes], command: str
) -> None:
    path = tmp_path / "day"
    path.write_bytes(pack(b"02 C3 02 02"))
    assert unpack(path).endswith(f"`{command} {path}`")


@pytest.mark.parametrize("beginning", [b"", b"BZ", b"PK", b"02 C3 02 02", bytes.fromhex("0A0D0D0A")])
def test_what_is_not_packed(tmp_path: Path, beginning: bytes) -> None:
    path = tmp_path / "day"
    path.write_bytes(beginning)
    assert unpack(path) == unpack(tmp_path / "none") == ""


@pytest.fixture
def python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The system's own Python of a Linux, in a folder with a blank in its name."""
    monkeypatch.setattr(sys, "executable", str(tmp_path / "a b/python3"))
    monkeypatch.setattr(sys, "prefix", sys.base_prefix)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path))
    (tmp_path / "a b").mkdir()
    return tmp_path / "a b/python3"


def test_how_to_get_a_package(python: Path) -> None:
    assert missing("pyarrow") == f"pyarrow is missing for {python}: `'{python}' -P -m pip install pyarrow`"


def test_debians_python_takes_debians_packages(python: Path) -> None:
    """It has no pip, and takes nothing from it."""
    (python.parents[1] / "EXTERNALLY-MANAGED").touch()
    assert missing("pyserial").endswith(": `sudo apt-get install python3-serial`")
    said = missing("pyarrow")  # Debian has none
    assert f"`'{python}' -P -m venv --system-site-packages ~/sistap-python`" in said
    assert "`~/sistap-python/bin/pip install pyarrow`" in said
    assert f"`PYTHONPATH={shell_word(str(PACKAGE.parent))} ~/sistap-python/bin/python3 -P -m sistap`" in said


def test_the_bundle_for_windows_has_no_pip(python: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    assert missing("pyarrow").endswith(" -P -m pip install pyarrow")
    (python.parent / "python314._pth").touch()
    assert "pip install" not in missing("pyarrow")
    assert "full.zip has pyarrow" in missing("pyarrow")


def test_windows_is_told_nothing_of_linux() -> None:
    assert not WORDS.search(" ".join(advice("win32")))
    assert not re.search("sudo|/dev/|/sys/|`", " ".join(advice("win32")))
    assert not re.search("apt-get|dmesg|limits.conf|/sys/|fuser|ttyUSB", " ".join(advice("darwin")))
    assert advice("linux") != advice("win32") != advice("darwin")
    assert advice("freebsd") == advice("linux")


WITH_SUDO = (
    "`sudo usermod -aG dialout $USER`, `echo 1 | sudo tee x` or run sistap with sudo; "
    "`sistap ports`, no sudo here, `sudo a && sudo b`"
)
TYPED = {
    (False, True): WITH_SUDO,
    (False, False): "`usermod -aG dialout me` as root, `echo 1 | tee x` as root or run sistap as root; "
    "`sistap ports`, no sudo here, `a && b` as root",
    (True, True): "`usermod -aG dialout me`, `echo 1 | tee x` or run sistap as root; "
    "`sistap ports`, no sudo here, `a && b`",
}


@posix("no sudo")
@pytest.mark.parametrize(("is_root", "has_sudo"), TYPED)
def test_sudo_is_for_those_who_have_and_need_it(
    is_root: bool, has_sudo: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "sudo").touch(0o755 if has_sudo else 0o644)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("USER", "me")
    monkeypatch.setattr(rights, "is_root", lambda: is_root)
    assert as_typed(WITH_SUDO) == TYPED[is_root, has_sudo]


def test_a_message_names_no_sudo_that_is_not_here(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(rights, "needs_sudo", lambda: False)
    monkeypatch.setattr(rights, "is_root", lambda: False)
    Console().say("`sudo dmesg | tail` says why")
    assert capfd.readouterr().err == "sistap: `dmesg | tail` as root says why\n"


def texts(file: Path) -> list[str]:
    """Return all texts of a module that are shown to somebody."""
    tree = ast.parse(file.read_text("utf-8"))
    return [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]


@pytest.mark.style
def test_such_words_stand_in_the_table_alone() -> None:
    for file in PACKAGE.rglob("*.py"):
        if file.name != "advice.py" and file.name not in LINUX_FILES:
            allowed = LINUX_ALONE.get(file.name, "\0")
            assert not [text for text in texts(file) if WORDS.search(text) and allowed not in text], file


@pytest.mark.parametrize("module", ["sistap.cli", *(module for module, _ in COMMANDS.values())])
def test_examples_have_the_ports_of_windows(module: str) -> None:
    text: str = getattr(importlib.import_module(module), "EPILOG", "")
    translated = examples(text, "win32")
    assert "/dev/tty" not in translated
    assert "'" not in "".join(line for line in translated.splitlines() if line.startswith("  sistap"))
    assert examples(text, "linux") == text
    for line, other in zip(text.splitlines(), translated.splitlines(), strict=True):
        if "/dev/tty" in line and re.search(r"\S  ", line):
            assert len(line) == len(other)
            assert line.rpartition("  ")[2] == other.rpartition("  ")[2]


@pytest.mark.parametrize(
    ("text", "linux", "windows"),
    [("x.pcapng", "x.pcapng", "x.pcapng"), ("C:\\x", "'C:\\x'", "C:\\x"), ("a b", "'a b'", '"a b"')],
)
def test_a_word_to_copy(text: str, linux: str, windows: str) -> None:
    assert (shell_word(text, "linux"), shell_word(text, "win32")) == (linux, windows)
