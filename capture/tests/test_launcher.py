# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap.exe: what it makes of its command line, byte for byte."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from portable import compiled

pytestmark = compiled

LAUNCHER = Path(__file__).resolve().parents[1] / "launcher"
FILTER = 'link[5]==0x10&&link[6]==16 || "a b" \\" %PATH%  ^x\\'
SIZE = 200


@pytest.fixture(scope="module")
def tail(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """Its portable half, compiled here."""
    file = tmp_path_factory.mktemp("launcher") / "tail.so"
    subprocess.run(
        ["gcc", "-std=c17", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-o", file, LAUNCHER / "tail.c"],
        check=True,
    )
    library = ctypes.CDLL(str(file))
    library.arguments.restype = ctypes.c_wchar_p
    library.arguments.argtypes = [ctypes.c_wchar_p]
    library.append_quoted.argtypes = library.append.argtypes = [ctypes.c_wchar_p, ctypes.c_size_t, ctypes.c_wchar_p]
    library.next_line.restype = ctypes.c_wchar_p
    library.next_line.argtypes = [ctypes.POINTER(ctypes.c_void_p)]
    return library


def argv(command_line: str) -> list[str]:
    """Split a command line as CommandLineToArgvW does, whose rules Microsoft documents."""
    words: list[str] = []
    word, quoted, started, backslashes = "", False, False, 0
    for character in command_line:
        if character == "\\":
            backslashes, started = backslashes + 1, True
            continue
        if character == '"':
            word += "\\" * (backslashes // 2)
            if backslashes % 2:
                word += '"'
            else:
                quoted = not quoted
            backslashes, started = 0, True
            continue
        word, backslashes = word + "\\" * backslashes, 0
        if character in " \t" and not quoted:
            if started:
                words.append(word)
            word, started = "", False
        else:
            word, started = word + character, True
    return [*words, word + "\\" * backslashes] if started else words


@pytest.mark.parametrize(
    ("command_line", "rest"),
    [
        (r"sistap.exe --extcap-interfaces", "--extcap-interfaces"),
        (r'"C:\Program Files\Wireshark\extcap\sistap.exe"  --fifo x', "--fifo x"),
        ('C:\\"Program Files"\\sistap.exe\t"a  b" ', '"a  b" '),
        (r'"C:\folder\" x', "x"),  # a backslash means nothing in the first word
        ("sistap.exe", ""),
        ("sistap.exe ", ""),
        (" x", "x"),
        ('"open', ""),
        ("", ""),
    ],
)
def test_the_first_word_is_cut_off(tail: ctypes.CDLL, command_line: str, rest: str) -> None:
    assert tail.arguments(command_line) == rest


@given(st.lists(st.text(st.characters(blacklist_characters="\0\n\r", blacklist_categories=["Cs"]), max_size=20)))
def test_python_gets_what_wireshark_passed(tail: ctypes.CDLL, words: list[str]) -> None:
    started = subprocess.list2cmdline([r"C:\Program Files\extcap\sistap.exe", *words, FILTER])
    buffer = ctypes.create_unicode_buffer(5000)
    assert tail.append_quoted(buffer, 5000, r"C:\Program Files\Python\python.exe")
    assert tail.append(buffer, 5000, " -P -X utf8 -m sistap extcap ")
    assert tail.append(buffer, 5000, tail.arguments(started))
    assert argv(buffer.value)[7:] == [*words, FILTER]
    assert argv(buffer.value)[1:7] == ["-P", "-X", "utf8", "-m", "sistap", "extcap"]


def test_a_folder_may_end_with_a_backslash(tail: ctypes.CDLL) -> None:
    buffer = ctypes.create_unicode_buffer(SIZE)
    assert tail.append_quoted(buffer, SIZE, "C:\\a b\\")
    assert buffer.value == '"C:\\a b\\\\"'
    assert argv(buffer.value + " x") == ["C:\\a b\\", "x"]


def test_what_does_not_fit_is_refused_whole(tail: ctypes.CDLL) -> None:
    buffer = ctypes.create_unicode_buffer("1234", 8)
    assert not tail.append(buffer, 8, "5678")
    assert buffer.value == "1234"
    assert tail.append(buffer, 8, "567")
    assert buffer.value == "1234567"


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_lines_of_the_settings(tail: ctypes.CDLL, ends: str) -> None:
    text = ctypes.create_unicode_buffer(f"C:\\Python 3\\python.exe{ends}D:\\Übung{ends}")
    rest = ctypes.c_void_p(ctypes.addressof(text))
    lines = [tail.next_line(ctypes.byref(rest)) for _ in range(3)]
    assert lines == ["C:\\Python 3\\python.exe", "D:\\Übung", None]


@pytest.mark.thorough
@pytest.mark.skipif(not shutil.which("x86_64-w64-mingw32-gcc"), reason="no gcc-mingw-w64-x86-64")
def test_the_programs_have_the_same_bytes_wherever_they_are_built(tmp_path: Path) -> None:
    built = []
    for place in (tmp_path / "a", tmp_path / "another/place"):
        shutil.copytree(LAUNCHER, place / "capture/launcher")
        (place / "capture/sistap").mkdir()
        shutil.copy(LAUNCHER.parent / "sistap/__init__.py", place / "capture/sistap")
        subprocess.run([place / "capture/launcher/build"], check=True)
        built.append([file.read_bytes() for file in sorted((place / "build/windows").rglob("*.exe"))])
    assert built[0] == built[1]
    assert len(built[0]) == 2
    assert all("The authors of sistap".encode("utf-16-le") in program for program in built[0])
