# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts sis.lua into the package, for `sistap install`; all else is in pyproject.toml.

Not a symbolic link: on Windows git makes a text file of one, and Wireshark would load that.
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
    """A package has it beside the modules; an editable one finds it in the checkout."""

    def run(self) -> None:
        """Build, then copy."""
        super().run()
        if not self.editable_mode:
            shutil.copy(LUA, Path(self.build_lib) / "sistap")


class SourcesWithLua(sdist):
    """A source distribution has it where a package has it."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        """Make the tree, then copy."""
        super().make_release_tree(base_dir, files)
        shutil.copy(LUA, Path(base_dir) / "sistap")


setup(cmdclass={"build_py": BuildWithLua, "sdist": SourcesWithLua})
