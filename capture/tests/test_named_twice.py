# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture that is named twice would count twice. Each command that takes several says so, and does nothing."""

from __future__ import annotations

import gzip
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from portable import links
from report_capture import ANSWER, READ, Sent, records
from test_through_files import write

from sistap import cli
from sistap.dissected.captures import twice as of_twice

COMMANDS = [
    *(["report", "--format", "text", "-"], ["parameters", "-"]),
    *(["compare", "--bad", "none", "--good", "-"], ["tables", "-o", "tables", "-"]),
]


def same_name(capture: Path) -> Path:
    return capture


def other_path(capture: Path) -> Path:
    return capture.parent / ".." / capture.parent.name / capture.name


def link(capture: Path) -> Path:
    other = capture.with_name("link.pcapng")
    other.symlink_to(capture)
    return other


def copy(capture: Path) -> Path:
    return Path(shutil.copyfile(capture, capture.with_name("copy.pcapng")))


def packed(capture: Path) -> Path:
    other = capture.with_name("packed.pcapng.gz")
    other.write_bytes(gzip.compress(capture.read_bytes()))
    return other


def earlier(capture: Path) -> Path:
    """Return a copy that was made while the capture grew."""
    return write(capture.with_name("earlier.pcapng"), records([Sent(READ), Sent(ANSWER)] * 5))


def foreign(capture: Path) -> Path:
    """Return a copy of a capture in another format."""
    capture.write_bytes(b"\xd4\xc3\xb2\xa1" + bytes(16) + b"\xfc\0\0\0" + bytes(40))
    return copy(capture)


LINK = pytest.param(link, marks=links)
KINDS = [same_name, other_path, LINK, copy, packed, earlier, foreign]


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
@pytest.mark.parametrize("other", KINDS)
def test_it_is_refused(
    command: list[str], other: Callable[[Path], Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    capture = write(tmp_path / "a.pcapng", records([Sent(READ), Sent(ANSWER)] * 10))
    again = other(capture)
    assert cli.main([*(str(capture) if word == "-" else word for word in command), str(again)]) == 2
    said = " ".join(capfd.readouterr().err.split())
    assert again.name in said
    assert "name it once" in said


@pytest.mark.parametrize("other", [same_name, LINK, earlier])
def test_what_is_on_both_sides_is_told(
    other: Callable[[Path], Path], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    capture = write(tmp_path / "a.pcapng", records([Sent(READ), Sent(ANSWER)] * 10))
    again = other(capture)
    assert cli.main(["compare", str(capture), str(again)]) == 0
    said = " ".join(capfd.readouterr().err.split())
    assert again.name in said
    assert "what is on both sides cannot differ" in said


def test_a_good_capture_may_be_in_the_folder_that_is_reported(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    good = write(tmp_path / "a.pcapng", records([Sent(READ), Sent(ANSWER)] * 10))
    write(tmp_path / "b.pcapng", records([Sent(READ), Sent(READ)] * 10))
    assert cli.main(["report", "--format", "text", str(tmp_path), "--baseline", str(good)]) == 0
    said = " ".join(capfd.readouterr().err.split())
    assert f"{good} is named twice: all that is in it is taken for usual" in said


def test_a_capture_that_is_deleted_meanwhile_is_no_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A ring does that."""
    one = write(tmp_path / "a.pcapng", records([Sent(READ), Sent(ANSWER)] * 10))
    other = copy(one)

    def is_same(capture: Path, _: Path) -> bool:
        capture.unlink()
        return False

    monkeypatch.setattr(of_twice, "_is_same", is_same)
    assert of_twice.twice([one, other]) == ""


def test_a_file_of_a_folder_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    capture = write(tmp_path / "a.pcapng", records([Sent(READ), Sent(ANSWER)] * 10))
    assert cli.main(["report", "--format", "text", str(tmp_path), str(capture)]) == 2
    assert f"{capture} is named twice: name it once" in " ".join(capfd.readouterr().err.split())


def test_captures_that_only_begin_alike_are_read(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Two runs of a simulated bus begin at the same time."""
    one = write(tmp_path / "a.pcapng", records([Sent(READ), Sent(ANSWER)] * 10))
    other = write(tmp_path / "b.pcapng", records([Sent(READ), Sent(ANSWER)] * 9 + [Sent(READ), Sent(READ)]))
    assert cli.main(["compare", str(one), str(other)]) == 0
    assert "cannot differ" not in capfd.readouterr().err
