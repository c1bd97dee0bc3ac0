# SPDX-License-Identifier: GPL-2.0-or-later
"""What `pip install` gets: every module, the profile and sis.lua; also out of a source distribution."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
NOT_SOURCES = shutil.ignore_patterns("__pycache__", "*.egg-info", "build", ".*")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A copy: setuptools leaves files where it builds."""
    shutil.copytree(REPOSITORY / "capture", tmp_path / "capture", ignore=NOT_SOURCES)
    (tmp_path / "lua-fallback").mkdir()
    shutil.copy(REPOSITORY / "lua-fallback/sis.lua", tmp_path / "lua-fallback")
    return tmp_path


def setup(folder: Path, *arguments: str) -> None:
    subprocess.run([sys.executable, "setup.py", "-q", *arguments], cwd=folder, check=True)


def files(folder: Path) -> set[str]:
    return {str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}


def test_a_package_has_everything(checkout: Path) -> None:
    setup(checkout / "capture", "build_py", "--build-lib", "../package")
    assert files(checkout / "package/sistap") == files(checkout / "capture/sistap") | {"sis.lua"}
    script = checkout / "package/sistap/sis.lua"
    assert script.read_bytes() == (checkout / "lua-fallback/sis.lua").read_bytes()


def test_a_source_distribution_has_everything(checkout: Path) -> None:
    setup(checkout / "capture", "sdist", "--dist-dir", "../dist")
    shutil.unpack_archive(next((checkout / "dist").iterdir()), checkout / "dist")
    unpacked = next(folder for folder in (checkout / "dist").iterdir() if folder.is_dir())
    setup(unpacked, "build_py", "--build-lib", "../../package")
    assert files(checkout / "package/sistap") == files(checkout / "capture/sistap") | {"sis.lua"}
