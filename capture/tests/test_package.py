# SPDX-License-Identifier: GPL-2.0-or-later
"""What `pip install` installs: every module, the profile and sis.lua; also from a source distribution.

And what the .deb has in addition to the sources.
"""

import gzip
import re
import shutil
import subprocess
import sys
from email.parser import Parser
from pathlib import Path

import pytest

import sistap
from sistap import cli

REPOSITORY = Path(__file__).resolve().parents[2]
NOT_SOURCES = shutil.ignore_patterns("__pycache__", "*.egg-info", "build", ".*")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Copy the checkout: setuptools leaves files where it builds."""
    shutil.copytree(REPOSITORY / "capture", tmp_path / "capture", ignore=NOT_SOURCES)
    (tmp_path / "lua-fallback").mkdir()
    shutil.copy(REPOSITORY / "lua-fallback/sis.lua", tmp_path / "lua-fallback")
    return tmp_path


def setup(folder: Path, *arguments: str) -> None:
    subprocess.run([sys.executable, "setup.py", "-q", *arguments], cwd=folder, check=True)


def files(folder: Path) -> set[str]:
    return {str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}


def python(capture: Path) -> set[str]:
    """Return what a package has of a checkout: both packages, and the script."""
    return {name for name in files(capture) if name.startswith(("sistap/", "sisbus/"))} | {"sistap/sis.lua"}


def test_a_package_has_everything(checkout: Path) -> None:
    setup(checkout / "capture", "build_py", "--build-lib", "../package")
    assert files(checkout / "package") == python(checkout / "capture")
    script = checkout / "package/sistap/sis.lua"
    assert script.read_bytes() == (checkout / "lua-fallback/sis.lua").read_bytes()


@pytest.mark.thorough
def test_a_source_distribution_has_everything(checkout: Path) -> None:
    setup(checkout / "capture", "sdist", "--dist-dir", "../dist")
    shutil.unpack_archive(next((checkout / "dist").iterdir()), checkout / "dist")
    unpacked = next(folder for folder in (checkout / "dist").iterdir() if folder.is_dir())
    setup(unpacked, "build_py", "--build-lib", "../../package")
    assert files(checkout / "package") == python(checkout / "capture")


def test_metadata(checkout: Path) -> None:
    """What an index shows; the licence as an SPDX expression, with its text."""
    setup(checkout / "capture", "egg_info", "--egg-base", "..")
    said = Parser().parsestr((checkout / "sistap.egg-info/PKG-INFO").read_text())
    assert (said["Name"], said["Version"]) == ("sistap", sistap.__version__)
    assert said["License-Expression"] == "GPL-2.0-or-later"
    assert said["License-File"] == "LICENSE"
    assert said["Author"]
    assert said["Description-Content-Type"] == "text/markdown"
    assert {"Environment :: Console", "Programming Language :: Python :: 3.11"} <= set(said.get_all("Classifier", []))


def test_the_licence_is_that_of_the_repository() -> None:
    assert (REPOSITORY / "capture/LICENSE").read_bytes() == (REPOSITORY / "LICENSE").read_bytes()


def test_the_readme_of_an_index_stands_alone() -> None:
    text = (REPOSITORY / "capture/package/README.index.md").read_text()
    assert not re.findall(r"\]\((?!https://)|<img|src=", text)
    named = set(re.findall(r"`(?:sistap )?(\w+)`", text)) | set(re.findall(r"^    sistap (\w+)", text, re.MULTILINE))
    assert named - {"COMMAND"} <= cli.COMMANDS.keys()
    assert cli.COMMANDS.keys() - named == {"extcap", "uninstall"}


@pytest.mark.thorough
@pytest.mark.skipif(not shutil.which("help2man"), reason="needs help2man")
def test_what_the_debian_package_adds(tmp_path: Path) -> None:
    script = REPOSITORY / "capture/package/debian/make.py"
    root = tmp_path / "root"
    subprocess.run(
        [sys.executable, script, root, "/usr/lib/extcap", "1.2-3", "Somebody <somebody@somewhere.invalid>"],
        env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(REPOSITORY / "capture"), "SOURCE_DATE_EPOCH": "0"},
        check=True,
    )
    for name in ("usr/bin/sistap", "usr/lib/extcap/sistap"):
        assert (root / name).stat().st_mode & 0o777 == 0o755
    for name, (_, text) in cli.COMMANDS.items():
        page = gzip.decompress((root / f"usr/share/man/man1/sistap-{name}.1.gz").read_bytes()).decode()
        assert f".SH NAME\nsistap-{name} \\- {text}\n.SH SYNOPSIS\n.B sistap\n\\fI\\,{name}" in page
        assert "\n.SH OPTIONS" in page
    changelog = gzip.decompress((root / "usr/share/doc/sistap/changelog.Debian.gz").read_bytes()).decode()
    assert changelog.startswith("sistap (1.2-3) unstable; urgency=medium\n")
    assert changelog.endswith("\n -- Somebody <somebody@somewhere.invalid>  Thu, 01 Jan 1970 00:00:00 -0000\n")
