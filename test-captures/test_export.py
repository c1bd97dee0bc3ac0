# SPDX-License-Identifier: GPL-2.0-or-later
"""Export Objects: long parameters and memory images, as files."""

from __future__ import annotations

import tempfile
from pathlib import Path

from make import Scenario
from sistap.tshark import Tshark

# Program flash: two pieces in a row, one elsewhere, one again with other data; Read flash; a list read in two pieces.
SCENARIO = """
command 16>3 02 03 96 00 00 01 00 04 "ABCD"
reaction 16>3 02 00 03 96
command 16>3 02 03 96 04 00 01 00 04 "EFGH"
reaction 16>3 02 00 03 96
command 16>3 02 03 96 00 00 02 00 04 "far"
reaction 16>3 02 00 03 96
command 16>3 02 03 96 02 00 01 00 04 "cd"
reaction 16>3 02 00 03 96
command 16>3 02 03 92 00 00 03 00 05
reaction 16>3 02 00 03 92 "hello"
command 16>3 10 3C 03 00 11 00
reaction 16>3 10 00 38 03 01 00
command 16>3 10 3C 03 00 11 00
reaction 16>3 10 00 3C 03 02 00
command 16>3 10 3C 03 00 12 00
reaction 16>3 10 00 3C 03 03 00
"""


def test_objects(tshark: Tshark, tmp_path: Path) -> None:
    scenario, capture = tmp_path / "objects.txt", tmp_path / "objects.pcapng"
    scenario.write_text(SCENARIO)
    capture.write_bytes(Scenario(scenario).capture())
    with tempfile.TemporaryDirectory() as name:  # tshark may run as nobody, whom pytest's folders are closed to
        folder = Path(name)
        folder.chmod(0o777)
        tshark.output("-q", "-r", str(capture), "--export-objects", f"sis,{folder}")
        objects = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert objects == {
        "0x00010000 to 0x00010007, memory written, station 3.bin": b"ABcdEFGH",
        "0x00020000 to 0x00020002, memory written, station 3.bin": b"far",
        "0x00030000 to 0x00030004, memory read, station 3.bin": b"hello",
        "S-0-0017 of device 3 at station 3, packet 14.bin": b"\x01\x00\x02\x00",
    }
