# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameter backups of drives: read, made into Wireshark's table, and compared with a capture; damaged ones refused.

drive.par has 40 parameters of all formats, with the layout of a backup that IndraWorks wrote.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import refused, run

from sistap.parameters.backup import Damaged, drives
from sistap.parameters.values import Attribute, decoded, encoded, same

PAR = Path(__file__).parent / "drive.par"
CAPTURE = PAR.parents[2] / "test-captures" / "accesses.pcapng"
TEXT = PAR.read_bytes().decode("latin-1")


def number_of(line: str) -> int:
    """Return the number of the only line like this, from 1."""
    lines = TEXT.split("\r\n")
    assert lines.count(line) == 1
    return lines.index(line) + 1


def test_what_a_backup_says() -> None:
    (drive,) = drives(PAR)
    assert (drive.name, drive.address, len(drive.parameters)) == ("Feed axis", "1", 40)
    saved = {one.ident: one for one in drive.parameters}
    cycle = saved["S-0-0001"]
    assert (cycle.name, cycle.unit, cycle.minimum, cycle.maximum) == ("NC cycle time (TNcyc)", "us", "250", "65000")
    assert cycle.data == bytes.fromhex("d007")
    assert saved["S-0-0017"].data == bytes.fromhex("01000000 86010000 86018800 f98f0d00")
    assert saved["S-0-0095"].data == b"A0004 Initialization"
    assert saved["S-0-0040"].data == bytes.fromhex("f1ffffff"), "-0.0015 with four decimal places"
    assert saved["P-0-0041"].data == bytes.fromhex("6400"), "500 with the factor 5"
    assert saved["S-0-0138"].unit == "rad/s²"
    assert saved["S-0-1305.0.1"].data is None, "how a backup writes a time is not known"


def test_values_come_back() -> None:
    for saved in drives(PAR)[0].parameters:
        if saved.data is not None:
            assert decoded(saved.attribute, saved.data) == ", ".join(saved.values)


def test_line_ends_of_unix(tmp_path: Path) -> None:
    unix = tmp_path / "unix.par"
    unix.write_bytes(TEXT.replace("\r\n", "\n").encode("latin-1"))
    assert drives(unix) == drives(PAR)


@pytest.mark.parametrize(
    ("line", "other", "at", "why"),
    [
        ("SERCOS-ASCII", "SERCOS", 1, "is no backup"),
        ("S-0-0001.0.0", "S-0-001", 0, "'S-0-001' is not an ident"),
        ("01100000000100010000000000000001", "0110000000010001000000000000000", 0, "32 binary digits"),
        ("65000\r\n2000\r\n", "65000\r\n", 1, "a value has one line, not 0"),
        ("2000", "2 000", 0, "'2 000' is not a number of 2 bytes"),
        ("2000", "1e999999999", 0, "'1e999999999' is not a number of 2 bytes"),
        ("2000", "70000", 0, "'70000' is not a number of 2 bytes"),
        ("0000.1000.1100.0111", "0000.1000.1100.0112", 0, "is not binary digits"),
        ("0x000A0013\r\n|", "0x000A00G3\r\n|", 0, "is not a hexadecimal number"),
        ("20 20 A0004 Initialization", "20 20 A0004 Init", 0, "the text does not have its length"),
        ("S-0-0390\r\nS-0-0390.0.136", "S-0-0390.0.136", -3, "the list does not have its length"),
        ("S-0-0390\r\nS-0-0390.0.136", "S-0-390\r\nS-0-0390.0.136", 0, "'S-0-390' is not an ident"),
    ],
)
def test_damaged(line: str, other: str, at: int, why: str, tmp_path: Path) -> None:
    assert line in TEXT
    path = tmp_path / "damaged.par"
    path.write_bytes(TEXT.replace(line, other, 1).encode("latin-1"))
    number = TEXT[: TEXT.index(line)].count("\n") + 1 + at
    with pytest.raises(Damaged) as caught:
        drives(path)
    assert why in str(caught.value)
    assert f"line {number}:" in str(caught.value) or "no backup" in why


def test_every_cut(tmp_path: Path) -> None:
    """A cut backup is refused, or it is a shorter one that is whole."""
    path = tmp_path / "cut.par"
    for length in range(0, len(TEXT), 7):
        path.write_bytes(TEXT[:length].encode("latin-1"))
        try:
            (drive,) = drives(path)
        except Damaged as error:
            assert "save the" in str(error)
        else:
            assert len(drive.parameters) < 40 or TEXT[length:].strip() == ""


def test_the_table_of_a_station(tmp_path: Path) -> None:
    done = run(tmp_path, "parameters", "--from", PAR, "--station", "3/2")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert len(lines) == 40
    assert lines[1] == '"S","0001","NC cycle time (TNcyc)","us","0x60110001","250 us","65000 us","3/2"'
    assert '"S","0390.0.136","Diagnostic message number, list","","0x70360001","","","3/2"' in lines
    assert '"S","1-0100","Velocity loop proportional gain, set 1"' in done.stdout
    assert lines[16].startswith(r'"S","0138","Bipolar acceleration limit value","rad/s\xc2\xb2","0x03120001"')


def test_several_drives(tmp_path: Path) -> None:
    """The address of each is its station."""
    two = tmp_path / "two.par"
    two.write_bytes((TEXT + TEXT.replace("CSB02.1C\r\n1\r\n", "CSB02.1C\r\n7\r\n")).encode("latin-1"))
    lines = run(tmp_path, "parameters", "--from", two).stdout.splitlines()
    assert [line.rpartition(",")[2] for line in lines] == ['"1"'] * 40 + ['"7"'] * 40
    lines = run(tmp_path, "parameters", "--from", two, "--station", "7").stdout.splitlines()
    assert len(lines) == 40
    refused(run(tmp_path, "parameters", "--from", two, "--station", "3"), 2, "has no drive 3: --station is one of 1, 7")


def test_what_differs_from_a_backup(tmp_path: Path) -> None:
    """Accesses.txt writes S-0-0047 as 05 02 03 04 to device 5, and as 11 22 33 44 to device 6: 4 decimal places."""
    done = run(tmp_path, "parameters", CAPTURE, "--against", PAR)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        "3 device 5  S-0-0047 (Position command value)  12.3456 Deg -> 6730.5989 Deg  written by 16 in packet 28",
        "3 device 6  S-0-0047 (Position command value)  12.3456 Deg -> 114420.1745 Deg  written by 16 in packet 32",
        "2 of 2 parameters differ from the backup",
    ]
    same = tmp_path / "same.par"
    same.write_bytes(TEXT.replace("\r\n12.3456\r\n", "\r\n6730.5989\r\n").encode("latin-1"))
    done = run(tmp_path, "parameters", CAPTURE, "--against", same)
    assert done.stdout.splitlines()[-1] == "1 of 2 parameters differ from the backup"
    done = run(tmp_path, "parameters", CAPTURE, "--against", same, "--station", "9")
    assert done.stdout.splitlines() == ["0 of 0 parameters differ from the backup"]


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ((), "name a capture"),
        (("--from", PAR, CAPTURE), "leave out captures"),
        (("--from", PAR, "--station", "256"), "an address from 0 to 255"),
        ((CAPTURE, "--station", "3"), "--station belongs to"),
        ((CAPTURE, "--against", PAR, "--changes"), "leave out --changes"),
        (("--from", "none.par"), "cannot read none.par"),
        (("--from", CAPTURE), "is no backup"),
    ],
)
def test_wrong_usage(arguments: tuple[str | Path, ...], why: str, tmp_path: Path) -> None:
    refused(run(tmp_path, "parameters", *arguments), 2, why)


def test_a_floating_number_is_compared_as_people_write_it() -> None:
    """0.1 has no exact value: 0.1000001 is another number, the last bit is not."""
    float_, saved = Attribute(0x00620001), bytes.fromhex("cdcccc3d")
    assert encoded(float_, "0.1") == saved
    assert same(float_, saved, bytes.fromhex("cecccc3d"))
    assert not same(float_, saved, encoded(float_, "0.100001") or b"")
