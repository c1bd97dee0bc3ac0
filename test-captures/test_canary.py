# SPDX-License-Identifier: GPL-2.0-or-later
"""What later Wiresharks change under us. `wiresharks` runs this with each version; a failure says what is to be done.

Colouring rules: the development version reads coloring_rules.jsonc. Where our file is no longer read, test_colours in
test_profile.py fails.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from sistap.commands.extcap import toolbar
from sistap.tap.terminal.programs import of_wireshark

HOUSE = Path(__file__).parent.parent
SIGNATURES = ("const int, const int", "const unsigned, const unsigned")  # offset and length: to 4.6, and later
PROBE = """\
#include <stdbool.h>
#include <epan/packet.h>
static tvbuff_t *(*const length)(tvbuff_t *, {}) = tvb_new_subset_length;
int main(void) {{ return length == 0; }}
"""


def compiles(source: str) -> bool:
    flags = subprocess.run(["pkg-config", "--cflags", "wireshark"], check=True, capture_output=True, text=True).stdout
    command = ["cc", "-x", "c", "-fsyntax-only", "-Werror", *shlex.split(flags), "-"]
    return subprocess.run(command, input=source, text=True, capture_output=True, check=False).returncode == 0


@pytest.mark.skipif(not shutil.which("pkg-config"), reason="needs pkg-config")
def test_the_length_of_a_subset_has_a_known_type() -> None:
    """Another type needs a look at each call; -1 for the rest is no longer possible where it is unsigned."""
    assert [compiles(PROBE.format(signature)) for signature in SIGNATURES].count(True) == 1


def test_no_length_of_a_subset_is_negative() -> None:
    sources = "".join(path.read_text() for path in sorted((HOUSE / "plugin").rglob("*.c")))
    calls = re.findall(r"tvb_new_subset_length(?:_caplen)?\(((?:[^()]|\([^()]*\))*)\)", sources)
    assert len(calls) >= 10
    assert not [call for call in calls if re.search(r",\s*-\s*\d", call)]


def test_wireshark_opens_the_pipes_of_a_toolbar() -> None:
    """On Windows their end is the only sign that a capture is to stop: without controls a capture is killed."""
    path = of_wireshark("wireshark")
    if not path:
        pytest.skip("from 4.4 on, only Wireshark itself has a toolbar, and it is not installed")
    assert b"extcap-control" in Path(path).read_bytes()
    assert any(line.startswith("control {number=") for line in toolbar.controls())
