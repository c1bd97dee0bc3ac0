# SPDX-License-Identifier: GPL-2.0-or-later
"""Data of a file are forgotten with the file."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from make import HERE
from parity import SCRIPT
from sistap.dissected.captures.reading import packets
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng

SESSIONS = 8
BYTES_ANYHOW = 4096  # size of tables that Lua keeps allocated

# Prints the memory of Lua each time Wireshark forgets a file. Its name begins with z, so it is the last script.
PROBE = """
local probe = Proto("probe", "Memory of Lua")
function probe.init()
    collectgarbage()
    io.stderr:write(string.format("memory %d\\n", collectgarbage("count") * 1024))
end
"""


def repeated(name: str, folder: Path) -> tuple[Path, int]:
    """Make a capture that repeats the packets of another; return it, and the number of the other's packets."""
    originals = [packet.data for packet in packets(HERE / f"{name}.pcapng")]
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, name)
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(interface)]
    blocks += [
        pcapng.enhanced_packet(0, number * 50_000_000, data)
        for session in range(SESSIONS)
        for number, data in enumerate(originals)
    ]
    capture = folder / f"{name}.pcapng"
    capture.write_bytes(b"".join(blocks))
    return capture, len(originals)


def sessions(tshark: Tshark, name: str, folder: Path) -> tuple[list[list[str]], list[int]]:
    """Return the packet list of every session, and the bytes that Lua has at the beginning of each."""
    capture, count = repeated(name, folder)
    with capture.open("rb") as stdin:
        done = tshark.run(["-i", "-", "-M", str(count), "-T", "fields", "-e", "_ws.col.Info"], stdin=stdin)
    assert done.returncode == 0, done.stderr
    lines = [line for line in done.stdout.splitlines() if line != "resetting session."]
    assert len(lines) == SESSIONS * count
    lists = [lines[first : first + count] for first in range(0, len(lines), count)]
    return lists, [int(size) for size in re.findall(r"^memory (\d+)$", done.stderr, re.MULTILINE)]


@pytest.mark.thorough
@pytest.mark.parametrize(
    "name",
    [
        "exchanges",
        *(pytest.param(name, marks=pytest.mark.thorough) for name in ("timing-limits", "sequences", "parameters")),
    ],
)
def test_nothing_is_left(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "plugins"
    folder.mkdir()
    shutil.copy(SCRIPT, folder)
    (folder / "z.lua").write_text(PROBE)
    with Tshark(plugins=folder) as tshark:
        lists, sizes = sessions(tshark, name, tmp_path)
    assert all(session == lists[0] for session in lists)
    half = len(sizes) // 2
    assert half >= SESSIONS // 2
    assert max(sizes[half:]) < max(sizes[:half]) + BYTES_ANYHOW, sizes
