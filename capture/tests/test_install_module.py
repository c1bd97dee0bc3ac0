# SPDX-License-Identifier: GPL-2.0-or-later
"""Which Wireshark a plugin was built for, read from what a compiler made, whole and damaged."""

import platform
import random
import re
import subprocess
from pathlib import Path

import pytest
from portable import compiled

from sistap.commands.install.sources import ModuleError, wanted_version

SOURCE = "const int plugin_want_major = 4; const int plugin_want_minor = 9;\n"


def built(folder: Path, source: str, *options: str) -> Path:
    (folder / "plugin.c").write_text(source)
    command = ["gcc", *options, "-shared", "-nostdlib", "-o", "plugin.so", "plugin.c"]
    subprocess.run(command, cwd=folder, check=True)
    return folder / "plugin.so"


@compiled
@pytest.mark.parametrize("bits", ["-m64", "-m32"] if platform.machine() == "x86_64" else [""])
def test_version_of_a_plugin(tmp_path: Path, bits: str) -> None:
    assert wanted_version(built(tmp_path, SOURCE, *filter(None, [bits]))) == (4, 9)


@compiled
def test_stripped_of_what_is_not_needed_to_load_it(tmp_path: Path) -> None:
    assert wanted_version(built(tmp_path, SOURCE, "-s")) == (4, 9)


@pytest.mark.parametrize(
    ("content", "why"),
    [(b"", "no module"), (b"MZ\x90\0", "no module"), (b"\x7fELF", "no plugin"), (b"\x7fELF\x07\x07", "no plugin")],
)
def test_what_is_no_plugin(tmp_path: Path, content: bytes, why: str) -> None:
    file = tmp_path / "sis.so"
    file.write_bytes(content)
    with pytest.raises(ModuleError, match=f"^{re.escape(str(file))} is {why}"):
        wanted_version(file)


@compiled
def test_a_module_of_something_else(tmp_path: Path) -> None:
    with pytest.raises(ModuleError, match="no plugin of Wireshark"):
        wanted_version(built(tmp_path, "int other = 1;\n"))


@compiled
def test_damaged_ones_give_a_line_or_a_number(tmp_path: Path) -> None:
    good = built(tmp_path, SOURCE).read_bytes()
    file = tmp_path / "damaged.so"
    chance = random.Random(1)
    for length in range(0, len(good), 61):
        damaged = bytearray(good[:length] if length % 2 else good)
        for _ in range(20):
            if damaged:
                damaged[chance.randrange(min(len(damaged), 2000))] = chance.randrange(256)
        file.write_bytes(damaged)
        try:
            wanted_version(file)
        except ModuleError as error:
            assert str(file) in str(error)
