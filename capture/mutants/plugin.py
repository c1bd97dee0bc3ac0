# SPDX-License-Identifier: GPL-2.0-or-later
"""The plugin of a copy, built anew for each mutant in C."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class Plugin:
    """A copy of the plugin's sources, and what is built of them."""

    def __init__(self, folder: Path) -> None:
        """Copy the sources; nothing is built yet."""
        self._folder = folder
        self._module = Path()  # where it is for tshark, which may run as nobody
        shutil.copytree(ROOT / "plugin", folder / "plugin")
        shutil.copy(ROOT / "CMakeLists.txt", folder)
        folder.chmod(0o755)

    def build(self) -> bool:
        """Build it; tell whether it could be built."""
        if not self._module.name:
            self._run("cmake", "-S", ".", "-B", "build", "-DCMAKE_BUILD_TYPE=RelWithDebInfo")
            version = self._run("pkg-config", "--modversion", "wireshark").split(".")
            self._module = self._folder / "wireshark" / ".".join(version[:2]) / "epan" / "sis.so"
            self._module.parent.mkdir(parents=True)
        try:
            self._run("cmake", "--build", "build")
        except subprocess.CalledProcessError:
            return False
        shutil.copy(self._folder / "build" / "plugin" / "sis.so", self._module)
        return True

    @property
    def environment(self) -> Mapping[str, str]:
        """Return the variable by which tshark finds it."""
        return {"WIRESHARK_PLUGIN_DIR": str(self._folder / "wireshark")}

    def _run(self, *command: str) -> str:
        done = subprocess.run(command, cwd=self._folder, capture_output=True, text=True, check=True)
        return done.stdout.strip()
