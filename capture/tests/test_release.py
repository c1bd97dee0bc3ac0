# SPDX-License-Identifier: GPL-2.0-or-later
"""build/release: START-HERE.html says of each file for whom it is; the notes begin with what the product is."""

import re
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "package"))

import release  # noqa: E402 - it makes build/release

from sistap import __version__  # noqa: E402


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
    assert f"apt-get install ./{deb}. Then, not as root: wireshark -C SIS. " in page
    assert "SIS demo bus.</td><td>1.2 MB</td>" in page
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


def test_names_of_before_come_last_in_the_notes() -> None:
    first, *_, last = re.findall(r"^### (.*)", release.notes(), re.MULTILINE)
    assert (first, last) == ("Documents and library", "Names and numbers")


def test_what_was_made_is_copied_and_what_was_not_has_a_cure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where CMake and cpack, capture/bundle/build, the page's build.mjs and Python's build put what they make."""
    monkeypatch.setattr(release, "HOUSE", tmp_path)
    monkeypatch.setattr(release, "RELEASE", tmp_path / "release")
    deb = tmp_path / f"build/plugin/sistap_{__version__}+wireshark4.4_amd64.deb"
    names = f"windows/sistap-{__version__}-setup.exe", f"windows/sistap-{__version__}-windows.zip", "sis.html"
    wheel = f"dist/sistap-{__version__}-py3-none-any.whl"
    made = [deb, tmp_path / "lua-fallback/sis.lua", *(tmp_path / "build" / name for name in (*names, wheel))]
    for file in (*made, tmp_path / "release/x"):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch()
    assert release.copied()
    assert {file.name for file in release.RELEASE.iterdir()} == {"x", *(file.name for file in made)}
    deb.unlink()
    assert not release.copied()
    said = f"release: not made: sistap_{__version__}+wiresharkVERSION.deb: build/plugin/cpack.log says why\n"
    assert capsys.readouterr().err == said
