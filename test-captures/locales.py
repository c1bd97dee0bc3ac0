# SPDX-License-Identifier: GPL-2.0-or-later
"""Provides a locale with a decimal comma for tshark, whether or not the computer has one."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sistap.dissected.wireshark.tshark import Tshark

NAME = "de_DE.UTF-8"
# The rest of the language, above all how it is sorted, would take localedef a second. C has it as well.
NUMBERS = 'LC_NUMERIC\ncopy "de_DE"\nEND LC_NUMERIC\n'
REST = Path("/usr/lib/locale/C.utf8")


@contextmanager
def german() -> Iterator[dict[str, str]]:
    """Return the environment in which a program speaks German; valid within the context."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)  # tshark may run as nobody
        (folder / "numbers").write_text(NUMBERS)
        command = ["localedef", "-c", "-i", str(folder / "numbers"), "-f", "UTF-8", str(folder / "made")]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        assert (folder / "made/LC_NUMERIC").exists(), f"apt-get install locales; localedef says: {done.stderr}"
        shutil.copytree(REST, folder / NAME)
        shutil.copy(folder / "made/LC_NUMERIC", folder / NAME)
        yield {"LC_ALL": NAME, "LOCPATH": name}


def said(tshark: Tshark, environment: dict[str, str], *arguments: str) -> str:
    """Run tshark in an environment and return its stdout."""
    done = tshark.run(arguments, extra_environment=environment)
    assert done.returncode == 0, done.stderr
    return done.stdout
