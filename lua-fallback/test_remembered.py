# SPDX-License-Identifier: GPL-2.0-or-later
"""What sis.lua remembers of telegrams without a tree never outlives its conditions.

The plugin remembers nothing of that kind, so both must have the same packet lists.
"""

from __future__ import annotations

import random
import shutil
import struct
from collections.abc import Iterable
from pathlib import Path

import pytest

import parity
from make import HERE
from sistap.dissected.captures import reading
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.record import Record, Type
from sistap.tap.sis.telegram import build

SEEDS = (1, pytest.param(2, marks=pytest.mark.thorough))
PACKETS = 3000
LONGEST_PIECE = 24  # consecutive packets of one capture
DIFFERENT = 5000  # more telegrams than the script remembers
TWO_PASSES = pytest.param(("-2",), marks=pytest.mark.thorough, id="two_passes")
PASSES = pytest.mark.parametrize("options", [pytest.param((), id="one_pass"), TWO_PASSES])

SETTINGS = LineSettings(115200, 8, "E", 2)
INTERVAL_NS = 20_000_000

# Changes a preference after the first capture, as a user would between two looks.
CHANGER = """
local changer, is_seen = Proto("changer", "Changes a preference"), false
function changer.dissector()
    is_seen = true
end
function changer.init()
    if is_seen then
        set_preference("sis.edition", "ECODRIVE03")
        apply_preferences()
    end
end
register_postdissector(changer)
"""


def write(capture: Path, packets: Iterable[bytes]) -> None:
    """Write packets of one line, evenly spaced."""
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "remembered")
    blocks = [pcapng.section_header("", ""), pcapng.interface_description(interface)]
    blocks += [pcapng.enhanced_packet(0, number * INTERVAL_NS, packet) for number, packet in enumerate(packets)]
    capture.write_bytes(b"".join(blocks))


def packet(telegram: bytes) -> bytes:
    """Make the record of a telegram whose characters came one by one."""
    intervals = [0] + [SETTINGS.character_ns] * (len(telegram) - 1)
    flags = bytes([Flag.INTERVAL_UNKNOWN]) + bytes(len(telegram) - 1)
    return pcapng.upper_pdu("sertap", Record(0, Type.FRAME, 0, SETTINGS, telegram, intervals, flags, 0).pack())


def read(element: int, answer: bytes, master: int = 16) -> list[bytes]:
    """Return command and reaction that read an element (fig. 8-1) of S-0-0044 in station 3."""
    control = bytes([element << 3 | 4, 3])
    return [
        build(0x10, master, 3, control + b"\x00\x2c\x00"),
        build(0x10, master, 3, b"\x00" + control + answer, reaction=True),
    ]


def compare(plugin: Tshark, script: Tshark, capture: Path, *options: str) -> None:
    """Compare the packet lists. AssertionError has the difference."""
    words = parity.difference(*(parity.listed(tshark, capture, *options) for tshark in (plugin, script)))
    assert not words, words


def in_pieces(chance: random.Random) -> Iterable[bytes]:
    """Return pieces of all captures of records in any order, some of them several times."""
    captures = [list(reading.packets(path)) for path in sorted(HERE.glob("*.pcapng"))]
    records = [
        [packet.data for packet in one if packet.link_type == pcapng.LINKTYPE_WIRESHARK_UPPER_PDU] for one in captures
    ]
    sources = [data for data in records if data]
    for _ in range(PACKETS * 2 // LONGEST_PIECE):
        source = chance.choice(sources)
        first = chance.randrange(len(source))
        piece = source[first : first + chance.randrange(1, LONGEST_PIECE)]
        yield from piece * chance.choice((1, 1, 2, 3))


@pytest.mark.thorough
@PASSES
@pytest.mark.parametrize("seed", SEEDS)
def test_pieces_of_captures(
    seed: int, options: tuple[str, ...], plugin: Tshark, script: Tshark, tmp_path: Path
) -> None:
    """The same telegrams in other surroundings: repeated, or during a transfer or a phase switch."""
    capture = tmp_path / "pieces.pcapng"
    write(capture, in_pieces(random.Random(seed)))
    compare(plugin, script, capture, *options)


@pytest.mark.thorough
@PASSES
def test_name_learned_between(options: tuple[str, ...], plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """The same read of a value before its parameter has a name and a unit, after it, and with another name and unit."""
    value, unit = read(7, struct.pack("<i", 12)), read(4, b"mm")
    one, other = read(2, b"Name"), read(2, b"Other")
    ask, answer = read(2, b"Name", master=17)
    telegrams = [*value, *value, *one, *value, *unit, *value, *other, *value, ask, *other, answer, *value, *one, *value]
    capture = tmp_path / "learned.pcapng"
    write(capture, map(packet, telegrams))
    compare(plugin, script, capture, *options)
    readings = [line for line in parity.listed(script, capture, *options) if "S-0-0044" in line and "0c 00" in line]
    names = ["Other" if "(Other)" in line else "Name" if "(Name)" in line else "" for line in readings]
    assert names == ["", "", "Name", "Name", "Other", "Name", "Name"]


@pytest.mark.thorough
@PASSES
def test_more_than_it_remembers(options: tuple[str, ...], plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    values = [telegram for number in range(DIFFERENT) for telegram in read(7, struct.pack("<i", number))]
    capture = tmp_path / "values.pcapng"
    write(capture, map(packet, values + values[: 2 * 100]))
    compare(plugin, script, capture, *options)


@pytest.mark.thorough
def test_preference_changed(plugin: Tshark, script: Tshark, tmp_path: Path) -> None:
    """Two captures in one tshark: what was remembered of a header is dropped when the edition changes."""
    folder = tmp_path / "plugins"
    folder.mkdir()
    shutil.copy(parity.SCRIPT, folder)
    (folder / "z.lua").write_text(CHANGER)
    telegrams = [*read(7, b"\x01\x00"), build(0x12, 16, 150, b""), build(0x12, 16, 254, b"")]
    twice, once = tmp_path / "twice.pcapng", tmp_path / "once.pcapng"
    write(twice, map(packet, telegrams * 2))
    write(once, map(packet, telegrams))
    info = ("-T", "fields", "-e", "_ws.col.Info")
    expected = [
        line
        for edition in ("IF02", "ECODRIVE03")
        for line in plugin.output("-r", str(once), "-o", f"sis.edition:{edition}", *info).splitlines()
    ]
    with Tshark(plugins=folder) as tshark, twice.open("rb") as stdin:
        done = tshark.run(["-i", "-", "-M", str(len(telegrams)), *info], stdin=stdin)
    assert done.returncode == 0, done.stderr
    assert [line for line in done.stdout.splitlines() if line != "resetting session."] == expected
