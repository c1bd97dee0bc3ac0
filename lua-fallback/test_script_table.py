# SPDX-License-Identifier: GPL-2.0-or-later
"""The table SIS parameters, made from a backup with 40 parameters of all formats: plugin and script read the file."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import parity
from sisbus.devices.parameters import ident
from sistap.commands.parameters import writing
from sistap.commands.parameters.backup import Saved, drives
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Framing, Record, Type
from sistap.tap.sis.telegram import build

BACKUP = Path(__file__).parent.parent / "capture" / "tests" / "drive.par"
(DRIVE,) = drives(BACKUP)
MS = 1_000_000

# The values as the documents and the backup say them, with the scaling of their attribute.
SHOWN = {
    "S-0-0000": "0x0000",
    "S-0-0001": "2000 us",
    "S-0-0013": "0b0000 1000 1100 0111",
    "S-0-0017": "S-0-0001,S-0-0390,S-0-0390.0.136,P-0-4089.0.13",
    "S-0-0030": "FWA-MADE1",
    "S-0-0040": "-0.0015 rpm",
    "S-0-0046": "-4",
    "S-0-0099": "0b0000 0000 0000 0000 (clear)",
    "S-0-0138": "10.000 rad/s²",
    "S-0-0142": 'Förder "1"\\',
    "S-0-0187": "S-0-0040,P-2-0012",
    "S-0-0390": "0x000A0013",
    "S-1-0100": "0.060 Nm/(rad/s)",
    "P-0-0040": "10.5 %",
    "P-0-0041": "500 mm",
    "P-0-0051": "1.25 Nm/A",
    "P-0-0052": "-0.125 mm",
    "P-0-0053": "18446744073709551615",
    "P-0-0054": "-1.50 mm",
    "P-0-0147": "S-0-0051",
    "P-0-0192": "0x000F2028,0x00000000",
    "P-0-4006": "0.0000 Deg,-90.0000 Deg,180.0000 Deg",
}


@pytest.fixture
def readable() -> Iterator[Path]:
    """A folder that tshark may read, whoever runs it."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o755)
        yield Path(folder)


def read(stations: tuple[int, ...]) -> list[bytes]:
    """Return commands and reactions that read all values, as the drive would say them: lists with their lengths."""
    telegrams = []
    for station in stations:
        for saved in DRIVE.parameters:
            if saved.data is not None and "." not in saved.ident:
                lengths = len(saved.data).to_bytes(2, "little") * 2 if saved.attribute.is_list else b""
                telegrams.append(build(0x10, 16, station, b"\x3c\x05" + ident(saved.ident)))
                telegrams.append(build(0x10, 16, station, b"\x00\x3c\x05" + lengths + saved.data, reaction=True))
    return telegrams


def write(capture: Path, frames: list[bytes], framing: Framing = Framing.SIS) -> None:
    interface = pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, "bus")
    packets = [pcapng.section_header("test", "test"), pcapng.interface_description(interface)]
    settings = LineSettings()
    for number, data in enumerate(frames):
        intervals = [settings.character_ns] * len(data)
        record = Record((number + 1) * 50 * MS, Type.FRAME, 0, settings, data, intervals, bytes(len(data)), 0, framing)
        packets.append(pcapng.enhanced_packet(0, record.time_ns, pcapng.upper_pdu("sertap", record.pack())))
    capture.write_bytes(b"".join(packets))


def tabled(folder: Path, monkeypatch: pytest.MonkeyPatch, station: str, *more: str) -> None:
    """Put the file where Wireshark looks."""
    (folder / "sis_parameters").write_text("\n".join([*writing.user_table(DRIVE, station), *more]) + "\n")
    monkeypatch.setitem(os.environ, "WIRESHARK_CONFIG_DIR", str(folder))
    monkeypatch.setitem(os.environ, "TMPDIR", str(folder))


def script_folder(folder: Path) -> Path:
    script = folder / "script"
    script.mkdir(mode=0o755)
    (script / "sis.lua").write_bytes(parity.SCRIPT.read_bytes())
    return script


def shown(tshark: Tshark, capture: Path) -> dict[str, str]:
    rows = tshark.output(
        *("-r", str(capture), "-Y", "sis.value", "-T", "fields"),
        *("-e", "sis.parameter", "-e", "sis.value", "-e", "sis.parameter.name"),
    )
    rows = rows.replace("\\\\", "\\")  # from 4.4 on, tshark escapes its output once more
    return {row.split("\t")[0]: row.split("\t")[1] for row in rows.splitlines()}


def plain() -> list[Saved]:
    return [saved for saved in DRIVE.parameters if "." not in saved.ident]


def test_all_formats_in_both(readable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(DRIVE.parameters) == 40
    capture = tmp_path / "read.pcapng"
    write(capture, read((3,)))
    tabled(readable, monkeypatch, "")
    with Tshark() as in_c, Tshark(plugins=script_folder(readable)) as in_lua:
        parity.check(in_c, in_lua, capture)
        values = shown(in_c, capture)
        names = in_lua.output("-r", str(capture), "-Y", 'sis.parameter.name == "Velocity feedforward evaluation"')
    assert {name: values.get(name) for name in SHOWN} == SHOWN
    assert set(values) == {saved.ident for saved in plain() if saved.data}, "every parameter that has a value decodes"
    assert len(names.splitlines()) == 2


def test_limits_look_like_values(readable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The backup writes 0b0000.0011.0011.1111, where values have blanks between groups."""
    capture = tmp_path / "read.pcapng"
    write(capture, read((3,)))
    tabled(readable, monkeypatch, "")
    fields = ("-T", "fields", "-e", "sis.parameter.minimum", "-e", "sis.parameter.maximum")
    with Tshark() as in_c, Tshark(plugins=script_folder(readable)) as in_lua:
        for tshark in (in_c, in_lua):
            rows = tshark.output("-r", str(capture), "-Y", 'sis.parameter == "S-0-0032"', *fields).splitlines()
            assert set(rows) == {"0b0000 0000 0000 0000\t0b0000 0011 0011 1111"}


def test_names_of_bits(readable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """S-0-0013 is 0000.1000.1100.0111, and P-0-0192 a list of 0x000F2028 and 0."""
    capture = tmp_path / "read.pcapng"
    write(capture, read((3,)))
    more = [
        '"S","0013","","","0","","","","0=Standstill, 3=Not this,11=Last"',
        '"P","0192","","","0","","","","3=Three, 13=Thirteen, 31=Not this, 63=Too high"',
    ]
    tabled(readable, monkeypatch, "", *more)
    with Tshark() as in_c, Tshark(plugins=script_folder(readable)) as in_lua:
        parity.check(in_c, in_lua, capture)
        fields = ("-T", "fields", "-e", "sis.parameter", "-e", "sis.value.bit")
        rows = in_c.output("-r", str(capture), "-Y", "sis.value.bit", *fields)
        assert rows.splitlines() == ["S-0-0013\tStandstill,Last", "P-0-0192\tThree,Thirteen"]
        assert len(in_lua.output("-r", str(capture), "-Y", 'sis.value.bit == "Last"').splitlines()) == 1


def test_a_table_of_one_station(readable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It says nothing of the other."""
    capture = tmp_path / "read.pcapng"
    write(capture, read((3, 4)))
    tabled(readable, monkeypatch, "3")
    with Tshark() as in_c, Tshark(plugins=script_folder(readable)) as in_lua:
        parity.check(in_c, in_lua, capture)
        found = in_c.output("-r", str(capture), "-Y", "sis.parameter.minimum", "-T", "fields", "-e", "sis.receiver")
    assert set(found.split()) == {"3"}


def test_idents_in_lists_have_the_names_of_their_station(
    readable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A backup of several drives has a station in each row. S-0-0017 of the backup lists S-0-0390."""
    capture = tmp_path / "read.pcapng"
    write(capture, read((3, 4)))
    more = ['"S","0017","","","0x70560001","","","4"', '"S","0390","Number of the fault","","0","","","4"']
    tabled(readable, monkeypatch, "3", *more)
    show = ("-r", str(capture), "-Y", 'sis.parameter == "S-0-0017"', "-V")
    with Tshark() as in_c, Tshark(plugins=script_folder(readable)) as in_lua:
        parity.check(in_c, in_lua, capture)
        for tshark in (in_c, in_lua):
            lines = [line.strip() for line in tshark.output(*show).splitlines() if ": S-0-0390 " in line]
            assert lines == [
                "Element 2: S-0-0390 (Diagnostic message number)",
                "Element 2: S-0-0390 (Number of the fault)",
            ]


# Attribute, value as text, and the bits that are set: MPH-02 writes binary values with b and hexadecimal ones with h.
TYPED_BITS = [
    ("0", "0x0010", "4"),  # of no known attribute: its text says what it is
    ("0", "8001h", "0,15"),
    ("0", "10001b", "0,4"),
    ("0", "10001", ""),
    ("0", "-1.5", ""),
    ("0x00010001", "0000000000010001", "0,4"),
    ("0x00320001", "A0013", "0,1,4,17,19"),
    ("0x00320001", "10b", "0,1,3,8"),  # 0x10B
    ("0x00110001", "11", ""),  # a number has no bits
    ("0x00330001", "8000000000000001", "0,63"),
    ("0x00330001", "F8000000000000001", ""),  # more than 64
]


def test_named_bits_of_the_ascii_protocol(readable: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    capture = tmp_path / "typed.pcapng"
    frames, rows = [b"BCD:3\r", b"E3:>"], []
    names = ", ".join(f"{bit}={bit}" for bit in (0, 1, 3, 4, 8, 15, 17, 19, 63))
    for number, (attribute, text, _) in enumerate(TYPED_BITS):
        frames += [f"P-0-{number:04},7,R\r".encode(), f"{text}\r".encode(), b"E3:>"]
        rows.append(f'"P","{number:04}","","","{attribute}","","","","{names}"')
    write(capture, frames, Framing.ASCII)
    tabled(readable, monkeypatch, "3", *rows)
    fields = ("-Y", "sisascii.kind && sis.value", "-T", "fields", "-e", "sis.value.bit")
    with Tshark() as in_c, Tshark(plugins=script_folder(readable)) as in_lua:
        parity.check(in_c, in_lua, capture)
        for tshark in (in_c, in_lua):
            said = tshark.output("-r", str(capture), *fields).split("\n")
            assert said[: len(TYPED_BITS)] == [bits for _, _, bits in TYPED_BITS]
