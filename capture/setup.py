# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts sis.lua into the package, for `sistap install`; everything else is in pyproject.toml.

Not a symbolic link: on Windows git makes a text file of it, and Wireshark would load that.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).resolve().parent
# In a checkout, and in a source distribution.
LUA = next(file for file in (HERE.parent / "lua-fallback/sis.lua", HERE / "sistap/sis.lua") if file.is_file())


class BuildWithLua(build_py):
    """Puts it beside the modules of a package; an editable package finds it in the checkout."""

    def run(self) -> None:
        """Build, then copy."""
        super().run()
        if not self.editable_mode:
            shutil.copy(LUA, Path(self.build_lib) / "sistap")


class SourcesWithLua(sdist):
    """Puts it into a source distribution, at the place it has in a package."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        """Make the tree, then copy."""
        super().make_release_tree(base_dir, files)
        shutil.copy(LUA, Path(base_dir) / "sistap")


setup(cmdclass={"build_py": BuildWithLua, "sdist": SourcesWithLua})
