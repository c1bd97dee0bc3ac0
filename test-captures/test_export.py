# SPDX-License-Identifier: GPL-2.0-or-later
"""Export Objects: long parameters and memory images, as files."""

from __future__ import annotations

import base64
import json
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from random import Random

import pytest

from bad_input import write
from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.sis.telegram import build

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


NAMES = {
    "station-3_memory-written_0x00010000-0x00010007.bin": b"ABcdEFGH",
    "station-3_memory-written_0x00020000-0x00020002.bin": b"far",
    "station-3_memory-read_0x00030000-0x00030004.bin": b"hello",
    "station-3_device-3_S-0-0017_packet-14.bin": b"\x01\x00\x02\x00",
}


@pytest.fixture
def folder() -> Iterator[Path]:
    """Make a folder that nobody can write, too: tshark may run so, and pytest's folders are closed to him."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o777)
        yield Path(name)


def exported(tshark: Tshark, capture: Path, folder: Path) -> dict[str, bytes]:
    """Return all objects of a capture, by name."""
    tshark.output("-q", "-r", str(capture), "--export-objects", f"sis,{folder}")
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def test_objects(tshark: Tshark, tmp_path: Path, folder: Path) -> None:
    scenario, capture = tmp_path / "objects.txt", tmp_path / "objects.pcapng"
    scenario.write_text(SCENARIO)
    capture.write_bytes(Scenario(scenario).capture())
    assert exported(tshark, capture, folder) == NAMES


def test_sections_are_apart(tshark: Tshark, tmp_path: Path, folder: Path) -> None:
    """The same station in another section is another station."""
    scenario, capture = tmp_path / "objects.txt", tmp_path / "objects.pcapng"
    scenario.write_text(
        'command 16>3 02 03 96 00 00 01 00 04 "ABCD"\nsection\ncommand 16>3 02 03 96 04 00 01 00 04 "EFGH"\n'
    )
    capture.write_bytes(Scenario(scenario).capture())
    assert exported(tshark, capture, folder) == {
        "station-3_memory-written_0x00010000-0x00010003.bin": b"ABCD",
        "station-3-of-section-2_memory-written_0x00010004-0x00010007.bin": b"EFGH",
    }


def programmed(station: int, address: int, data: bytes) -> bytes:
    """Return the command that programs a piece of flash memory."""
    return build(0x02, 16, station, b"\x03\x96" + address.to_bytes(4, "little") + b"\x04" + data)


Piece = tuple[int, int, bytes]  # station, address, data


def put_together(pieces: Iterable[Piece]) -> dict[str, bytes]:
    """Put each piece into the first memory that it begins in or directly after, else begin another."""
    memories: list[tuple[int, int, bytearray]] = []
    for station, address, data in pieces:
        for owner, begin, memory in memories:
            at = address - begin
            if owner == station and 0 <= at <= len(memory):
                memory[at : at + len(data)] = data
                break
        else:
            memories.append((station, address, bytearray(data)))
    return {
        f"station-{owner}_memory-written_0x{begin:08x}-0x{begin + len(memory) - 1:08x}.bin": bytes(memory)
        for owner, begin, memory in memories
    }


def few_bytes(random: Random) -> Iterator[Piece]:
    """Make pieces that overlap, grow together and leave holes, up to the last address there is."""
    for _ in range(600):
        last = random.choice((0, 2**32 - 400))
        yield random.choice((3, 3, 4)), last + random.randrange(400), random.randbytes(random.choice((1, 2, 5, 40)))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_memory_is_put_together(seed: int, tshark: Tshark, tmp_path: Path, folder: Path) -> None:
    pieces = [*few_bytes(Random(seed))]
    write(tmp_path / "pieces.pcapng", (programmed(*piece) for piece in pieces))
    found, expected = exported(tshark, tmp_path / "pieces.pcapng", folder), put_together(pieces)
    assert len(expected) > 10
    assert found.keys() == expected.keys()
    assert found == expected


@pytest.mark.thorough
@pytest.mark.timeout(120)
@pytest.mark.parametrize(("distance", "objects"), [(200, 1), (300, 10_000)], ids=["in_a_row", "apart"])
def test_many_pieces(distance: int, objects: int, tshark: Tshark, tmp_path: Path, folder: Path) -> None:
    """Searching all objects for every piece would take minutes."""
    write(tmp_path / "many.pcapng", (programmed(3, number * distance, bytes(200)) for number in range(10_000)))
    found = exported(tshark, tmp_path / "many.pcapng", folder)
    assert len(found) == objects
    assert sum(map(len, found.values())) == 10_000 * 200


def test_list_that_is_emptied_without_a_word(tmp_path: Path, folder: Path) -> None:
    """sharkd fills the same list for each request, and frees the earlier objects."""
    scenario, capture, asked = folder / "objects.txt", folder / "objects.pcapng", tmp_path / "asked"
    scenario.write_text(SCENARIO)
    capture.write_bytes(Scenario(scenario).capture())
    calls: list[dict[str, object]] = [{"method": "load", "params": {"file": str(capture)}}]
    calls += [{"method": "tap", "params": {"tap0": "eo:sis"}}] * 3
    calls += [{"method": "download", "params": {"token": f"eo:sis_{row}"}} for row in range(len(NAMES))]
    asked.write_text("".join(json.dumps({"jsonrpc": "2.0", "id": i, **call}) + "\n" for i, call in enumerate(calls, 1)))
    with Tshark("sharkd") as sharkd, asked.open("rb") as requests:
        answers = [json.loads(line)["result"] for line in sharkd.run(["-"], stdin=requests).stdout.splitlines()]
    for answer in answers[1:4]:
        (tap,) = answer["taps"]
        assert {entry["filename"] for entry in tap["objects"]} == NAMES.keys()
    assert {answer["file"]: base64.b64decode(answer["data"]) for answer in answers[4:]} == NAMES
