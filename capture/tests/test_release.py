# SPDX-License-Identifier: GPL-2.0-or-later
"""build/release: START-HERE.html says of each file for whom it is; the notes begin with what the product is."""

import re
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "package"))

import release  # noqa: E402 - it makes build/release


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """All files, each with its name as its content; of the .deb two, for two Wiresharks."""
    monkeypatch.setattr(release, "RELEASE", tmp_path)
    for file in release.FILES:
        for version in ("4.0", "4.4") if "*" in file.name else ("",):
            (tmp_path / file.name.replace("*", version)).write_bytes(b"x" * 1_250_000)
    return tmp_path


def test_the_page_has_each_file(folder: Path) -> None:
    page = release.page()
    assert sorted(re.findall(r'<a href="([^"]+)">', page)) == sorted(path.name for path in folder.iterdir())
    deb = next(folder.glob("*4.4*.deb")).name
    assert f"apt-get install ./{deb}</td><td>1.2 MB</td>" in page
    assert "Help &gt; About Wireshark &gt; Folders" in page


def test_the_page_has_no_file_that_is_missing(folder: Path) -> None:
    (folder / "sis.html").unlink()
    assert "sis.html" not in release.page()


def test_a_file_without_a_row_is_an_error(folder: Path) -> None:
    (folder / "new.zip").touch()
    with pytest.raises(ValueError, match=r"new\.zip"):
        release.page()


def test_page_and_notes_begin_with_what_it_is(folder: Path) -> None:
    what = release.product()
    assert what.startswith("SIS is the serial protocol of Rexroth and Indramat drives")
    assert 2 <= what.count(". ") + 1 <= 3
    assert not re.search(r"[`\[\]*]|bootstrap", what)  # plain words, for somebody without the sources
    assert f"<h1>Start here: SIS in Wireshark</h1>\n<p>{what}</p>" in release.page()
    assert release.notes().split("\n\n")[1] == what
