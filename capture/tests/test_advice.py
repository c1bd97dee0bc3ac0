# SPDX-License-Identifier: GPL-2.0-or-later
"""What to do is said in the words of the system."""

from __future__ import annotations

import ast
import bz2
import gzip
import importlib
import lzma
import re
from collections.abc import Callable
from pathlib import Path

import pytest

import sistap
from sistap.cli import COMMANDS
from sistap.terminal.advice import advice, examples, shell_word, unpack

PACKAGE = Path(sistap.__file__).parent
WORDS = re.compile("dmesg|limits.conf|apt-get|dialout|python3-|libpcap0")

# Where else such words may stand: in modules that Windows never loads, and where the programs of Linux are named.
LINUX_ALONE = {"doctor.py": "`sudo apt-get remove brltty`"}
LINUX_FILES = {"analyser.py"}  # of what is found in sysfs, and of a program that other systems get elsewhere


@pytest.mark.parametrize(
    ("pack", "command"), [(lzma.compress, "xz -dk"), (gzip.compress, "gunzip -k"), (bz2.compress, "bunzip2 -k")]
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


def test_windows_is_told_nothing_of_linux() -> None:
    assert not WORDS.search(" ".join(advice("win32")))
    assert not re.search("sudo|/dev/|/sys/|`", " ".join(advice("win32")))
    assert not re.search("apt-get|dmesg|limits.conf|/sys/|fuser|ttyUSB", " ".join(advice("darwin")))
    assert advice("linux") != advice("win32") != advice("darwin")
    assert advice("freebsd") == advice("linux")


def texts(file: Path) -> list[str]:
    """Return all texts of a module that are shown to somebody."""
    tree = ast.parse(file.read_text("utf-8"))
    return [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]


@pytest.mark.parametrize("file", sorted(PACKAGE.rglob("*.py")), ids=lambda file: str(file.relative_to(PACKAGE)))
def test_such_words_stand_in_the_table_alone(file: Path) -> None:
    if file.name != "advice.py" and file.name not in LINUX_FILES:
        allowed = LINUX_ALONE.get(file.name, "\0")
        assert not [text for text in texts(file) if WORDS.search(text) and allowed not in text]


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
