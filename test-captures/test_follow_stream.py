# SPDX-License-Identifier: GPL-2.0-or-later
"""Follow: a pair of stations as tshark writes it, and the filter for a packet as sharkd does."""

from __future__ import annotations

import base64
import json
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark

# Streams 0, 1, 2: 16 and 3, 16 and 4, 16 and what is behind 3. Damaged telegrams and those without a command have none.
SCENARIO = """
command 16>3 12
reaction 16>3 12 00 02
command 16>4 12
reaction 16>4 12 00 04
command 16>3/8 12
command 16>3 00 03 01
byte 2 0x00
command 16>3 00 03 01
reaction 3>16 00 00 03 01 "01V01"
reaction 16>9 12 00 02
"""
STREAM_0 = {
    1: (0, "02 D9 00 00 00 12 10 03"),
    2: (1, "02 C3 02 02 10 12 10 03 00 02"),
    7: (0, "02 E3 02 02 00 00 10 03 03 01"),
    8: (1, "02 AF 08 08 10 00 03 10 00 03 01 30 31 56 30 31"),  # this device swaps the addresses
}
STREAMS = {1: 0, 2: 0, 3: 1, 4: 1, 5: 2, 6: None, 7: 0, 8: 0, 9: None}


@pytest.fixture
def capture() -> Iterator[Path]:
    """Make the capture where any user can read it: tshark and sharkd may run as another user."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        (folder / "follow.txt").write_text(SCENARIO)
        (folder / "follow.pcapng").write_bytes(Scenario(folder / "follow.txt").capture())
        yield folder / "follow.pcapng"


def test_stream(tshark: Tshark, capture: Path) -> None:
    text = tshark.output("-q", "-r", str(capture), "-z", "follow,sis,yaml,0")
    peers = re.findall(r"^    host: (.*)$", text, re.MULTILINE)
    packets = re.findall(r"packet: (\d+)\n +peer: (\d)\n +timestamp: \S+\n +data: !!binary \|\n +(\S+)", text)
    seen = {int(frame): (int(peer), base64.b64decode(data).hex(" ").upper()) for frame, peer, data in packets}
    assert peers == ["16", "3"]
    assert seen == STREAM_0


def test_no_such_stream(tshark: Tshark, capture: Path) -> None:
    done = tshark.run(["-q", "-r", str(capture), "-z", "follow,sis,hex,9"])
    assert done.returncode == 0
    assert "00000000" not in done.stdout


def test_addresses_of_ip(tshark: Tshark, capture: Path) -> None:
    done = tshark.run(["-q", "-r", str(capture), "-z", "follow,sis,hex,10.0.0.1:1,10.0.0.2:2"])
    assert done.returncode != 0
    assert "filter" in done.stderr


def test_filter_of_packet(capture: Path, tmp_path: Path) -> None:
    asked = tmp_path / "asked"
    calls = [{"method": "load", "params": {"file": str(capture)}}]
    calls += [{"method": "frame", "params": {"frame": frame}} for frame in STREAMS]
    asked.write_text("".join(json.dumps({"jsonrpc": "2.0", "id": i, **call}) + "\n" for i, call in enumerate(calls, 1)))
    with Tshark("sharkd") as sharkd, asked.open("rb") as requests:
        answers = [json.loads(line) for line in sharkd.run(["-"], stdin=requests).stdout.splitlines()]
    offered = [dict(answer["result"].get("fol", [])) for answer in answers[1:]]
    expected = [None if stream is None else f"sis.stream == {stream}" for stream in STREAMS.values()]
    assert [filters.get("SIS") for filters in offered] == expected
