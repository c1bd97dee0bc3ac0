# SPDX-License-Identifier: GPL-2.0-or-later
"""debian-source says what it lacks, and leaves one version of what it has fetched."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from portable import posix

HOUSE = Path(__file__).parents[2]
APT = {
    "exit 0": "apt-get knows no mirror of Debian",
    "[ $1 = indextargets ] && echo http://debian.invalid/debian": "apt-get install wget",
}


def bash(script: Path, *arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [shutil.which("bash") or "bash", *map(str, (script, *arguments))]
    return subprocess.run(command, capture_output=True, text=True, env=os.environ | environment, check=False)


def with_apt(apt: str, folder: Path, path: str) -> subprocess.CompletedProcess[str]:
    """Ask debian-source for Wireshark, with this apt-get before the programs of a path."""
    (folder / "apt-get").write_text(f"#!/bin/sh\n{apt}\n")
    (folder / "apt-get").chmod(0o755)
    return bash(HOUSE / "plugin/debian-source", folder, "trixie", "wireshark", PATH=f"{folder}:{path}")


@posix("no bash")
@pytest.mark.parametrize("apt", APT)
def test_debian_source_says_what_it_lacks(apt: str, tmp_path: Path) -> None:
    for name in ("grep", "head", "mkdir", "rm"):
        (tmp_path / name).symlink_to(str(shutil.which(name)))
    done = with_apt(apt, tmp_path, "")
    assert (done.returncode, done.stderr) == (77, f"debian-source: not run: {APT[apt]}\n")


@posix("no bash")
def test_debian_source_leaves_no_other_version(tmp_path: Path) -> None:
    old = tmp_path / "wireshark_1.0.orig.tar.xz"
    old.touch()
    assert with_apt("echo http://debian.invalid/debian", tmp_path, os.environ["PATH"]).returncode == 0
    assert not old.exists()
