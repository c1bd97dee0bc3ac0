# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameter backups of drives: read, made into Wireshark's table, and compared with a capture; damaged ones refused.

drive.par has 40 parameters of all formats, with the layout of a backup that IndraWorks wrote.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest
from commands import refused, run
from portable import fifos

from sistap.commands.parameters.backup import drives
from sistap.dissected.telegrams.attribute import Attribute
from sistap.dissected.telegrams.values import decoded, encoded, same
from sistap.tap.terminal.exits import Refusal

PAR = Path(__file__).parent / "drive.par"
CAPTURE = PAR.parents[2] / "test-captures" / "accesses.pcapng"
TEXT = PAR.read_bytes().decode("latin-1")


# A line, what it becomes, how far below it the damage is, and what is wrong.
UNREADABLE = [
    ("2000", "2 000", 0, "'2 000' is not a number of 2 bytes"),
    ("2000", "1e999999999", 0, "'1e999999999' is not a number of 2 bytes"),
    ("2000", "70000", 0, "'70000' is not a number of 2 bytes"),
    ("2000", ".", 0, "'.' is not a number of 2 bytes"),
    ("0000.1000.1100.0111", "0000.1000.1100.0112", 0, "is not binary digits"),
    ("0x000A0013\r\n|", "0x000A00G3\r\n|", 0, "is not a hexadecimal number"),
    ("2014-01-02T23:56:52.942499600Z", "2014-02-30T23:56:52.942499600Z", 0, "is not a time"),
    ("S-0-0390\r\nS-0-0390.0.136", "S-0-390\r\nS-0-0390.0.136", 0, "'S-0-390' is not an ident"),
]


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
    assert saved["S-0-1305.0.1"].data == bytes.fromhex("c4fcc552 10672d38"), "seconds, nanoseconds"


def test_values_come_back() -> None:
    for saved in drives(PAR)[0].parameters:
        if saved.data is not None:
            assert decoded(saved.attribute, saved.data) == ", ".join(saved.values)


ASCII = TEXT.replace("\u00b2", "2").replace("\u00f6", "o").encode("ascii")
# Unit and name of S-0-0138 as bytes, the encoding, and the unit. In CP850, FD is the square, FC the cube, F8 the
# degree, and 84 an a with dots. In Latin-1 these are B2, B3, B0 and E4.
ENCODED = [
    (b"rad/s\xfd", b"Bipolar acceleration", "CP850", "rad/s\u00b2"),
    (b"rad/s\xfc", b"Bipolar acceleration", "CP850", "rad/s\u00b3"),
    (b"\xf8C", b"Bipolar acceleration", "CP850", "\u00b0C"),
    (b"m\xfc/h", b"Bipolar acceleration", "CP850", "m\u00b3/h"),
    (b"rad/s2", b"Verst\x84rkung", "CP850", "rad/s2"),
    (b"rad/s\xb2", b"Verst\xe4rkung", "Latin-1", "rad/s\u00b2"),
    (b"St\xfcck", b"Bipolar acceleration", "Latin-1", "St\u00fcck"),
    (b"rad/s2", b"Bipolar acceleration", "Latin-1", "rad/s2"),
]


@pytest.mark.parametrize(("unit", "name", "encoding", "text"), ENCODED)
@pytest.mark.parametrize("end", [b"\r\n", b"\n"])
def test_the_encoding_is_what_the_bytes_say(
    tmp_path: Path, unit: bytes, name: bytes, encoding: str, text: str, end: bytes
) -> None:
    lines = ASCII.split(b"\r\n")
    at = lines.index(b"S-0-0138.0.0")
    lines[at + 1], lines[at + 3] = name, unit
    backup = tmp_path / "drive.par"
    backup.write_bytes(end.join(lines))
    (drive,) = drives(backup)
    saved = {one.ident: one for one in drive.parameters}["S-0-0138"]
    assert (drive.encoding, saved.unit, saved.name) == (encoding, text, name.decode(encoding))


def test_texts_in_cp850_are_not_compared(tmp_path: Path) -> None:
    """No document says which bytes they have on the bus."""
    backup = tmp_path / "drive.par"
    content = ASCII.replace(b"rad/s2", b"rad/s\xfd").replace(b"A0004 Init", b"\x84\x94004 Init")
    backup.write_bytes(content)
    (drive,) = drives(backup)
    saved = {one.ident: one for one in drive.parameters}
    assert (saved["S-0-0095"].values, saved["S-0-0095"].data) == (["\u00e4\u00f6004 Initialization"], None)


def test_the_command_names_the_encoding(tmp_path: Path) -> None:
    backup = tmp_path / "drive.par"
    backup.write_bytes(ASCII.replace(b"rad/s2", b"rad/s\xfd"))
    done = run(tmp_path, "parameters", "--from", backup)
    assert '"rad/s\\xc2\\xb2"' in done.stdout
    assert done.stderr == f"sistap: {backup}: its units and texts are read as CP850\n"


def test_line_ends_of_unix(tmp_path: Path) -> None:
    unix = tmp_path / "unix.par"
    unix.write_bytes(TEXT.replace("\r\n", "\n").encode("latin-1"))
    assert drives(unix) == drives(PAR)


@pytest.mark.attack("what is no backup of a drive: a pipe, a device, a file without an end", "refused in one line")
@pytest.mark.parametrize("kind", [pytest.param("pipe", marks=fifos), "device", "large"])
def test_only_files_of_a_likely_size(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "x.par"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path = Path("/dev/zero")
    else:
        path.write_bytes(PAR.read_bytes())
        os.truncate(path, 1 << 30)
    with pytest.raises(Refusal, match="not a file, or larger than 32 MB"):
        drives(path)


@pytest.mark.parametrize(
    ("line", "other", "at", "why"),
    [
        ("SERCOS-ASCII", "SERCOS", 1, "is no backup"),
        ("S-0-0001.0.0", "S-0-001", 0, "'S-0-001' is not an ident"),
        ("01100000000100010000000000000001", "0110000000010001000000000000000", 0, "32 binary digits"),
        ("65000\r\n2000\r\n", "65000\r\n", 1, "a value has one line, not 0"),
        ("20 20 A0004 Initialization", "20 20 A0004 Init", 0, "the text does not have its length"),
        ("S-0-0390\r\nS-0-0390.0.136", "S-0-0390.0.136", -3, "the list does not have its length"),
        ("CSB02.1C\r\n1\r\n", "CSB02.1C\r\n", 1, "address is missing"),
        *UNREADABLE,
    ],
)
def test_damaged(line: str, other: str, at: int, why: str, tmp_path: Path) -> None:
    assert line in TEXT
    path = tmp_path / "damaged.par"
    path.write_bytes(TEXT.replace(line, other, 1).encode("latin-1"))
    number = TEXT[: TEXT.index(line)].count("\n") + 1 + at
    with pytest.raises(Refusal) as caught:
        drives(path)
    assert why in str(caught.value)
    assert f"line {number}:" in str(caught.value) or "no backup" in why


@pytest.mark.parametrize(("line", "other", "at", "why"), UNREADABLE)
def test_one_value_does_not_cost_the_table(line: str, other: str, at: int, why: str, tmp_path: Path) -> None:
    """The table needs no values. A comparison does: it would not be complete."""
    path = tmp_path / "odd.par"
    path.write_bytes(TEXT.replace(line, other, 1).encode("latin-1"))
    place = f"line {TEXT[: TEXT.index(line)].count(chr(10)) + 1 + at}:"
    done = run(tmp_path, "parameters", "--from", path)
    assert done.returncode == 0
    assert done.stdout == run(tmp_path, "parameters", "--from", PAR).stdout
    assert place in done.stderr
    assert why in done.stderr
    refused(run(tmp_path, "parameters", CAPTURE, "--against", path), 2, place)


def test_many_values_that_cannot_be_read_have_one_line(tmp_path: Path) -> None:
    path = tmp_path / "odd.par"
    path.write_bytes(TEXT.replace("\r\n2000\r\n", "\r\n2 000\r\n").replace("1.25\r\n", "1,25\r\n").encode("latin-1"))
    (line,) = run(tmp_path, "parameters", "--from", path).stderr.splitlines()
    assert f"line {number_of('2000')}: '2 000'" in line
    assert "1 more value" in line


# As firmware writes backups: without names, dots in binary numbers, and zeros before the point; with blanks behind
# units and texts of odd length.
TERSE = """\
SERCOS-ASCII
2026-11-24 13:00:00


7
|
P-0-0051.0.0

00000010000100010000000000000001
Nm/A{blank}
.0
655.35
.80
|
P-0-0141.0.0

00000010001000010000000000000001
--
-.05
.05
-.05
|
S-0-0032.0.0

01000000000000010000000000000001
--
--
0b0000001100111111
0000000000000010
|
S-0-1302.0.3

00000000010001000000000000000001
--
--
--
07 40 default{blank}
|
S-0-1300.20.11

00000000010001000000000000000001
--
--
--
0 50 {blank}
|
S-0-1303.0.11

01110000011101110000000000000001
s{blank}
--
--
8
1024
2014-01-02T22:47:31.000000000Z
|
P-0-0023.0.0

00000000010100100000000000000001
--
--
--
S-0-0000.0.0
|
"""


def test_a_terse_backup(tmp_path: Path) -> None:
    path = tmp_path / "terse.par"
    path.write_text(TERSE.replace("{blank}", " "))
    data = [one.data for one in drives(path)[0].parameters]
    assert data[:5] == [b"\x50\0", b"\xfb\xff", b"\x02\0", b"default", b""]
    assert data[5:] == [(1_388_702_851).to_bytes(4, "little") + bytes(4), bytes(4)]
    assert run(tmp_path, "parameters", "--from", path).stdout.splitlines()[:4] == [
        '"P","0051","","Nm/A","0x02110001","0.00 Nm/A","655.35 Nm/A",""',
        '"P","0141","","","0x02210001","-0.05","0.05",""',
        '"S","0032","","","0x40010001","","0b0000 0011 0011 1111",""',
        '"S","1302.0.3","","","0x00440001","","",""',
    ]


def test_every_cut(tmp_path: Path) -> None:
    """A cut backup is refused, or it is a shorter one that is whole."""
    path = tmp_path / "cut.par"
    for length in range(0, len(TEXT), 7):
        path.write_bytes(TEXT[:length].encode("latin-1"))
        try:
            (drive,) = drives(path)
        except Refusal as error:
            assert "save the" in str(error)
        else:
            assert len(drive.parameters) < 40 or TEXT[length:].strip() == ""


def test_the_table_of_a_station(tmp_path: Path) -> None:
    done = run(tmp_path, "parameters", "--from", PAR, "--station", "3/2")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert len(lines) == 40
    assert lines[1] == '"S","0001","NC cycle time (TNcyc)","us","0x60110001","250 us","65000 us","3/2"'
    assert lines[5].endswith('"0x40010001","0b0000 0000 0000 0000","0b0000 0011 0011 1111","3/2"')
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


@pytest.mark.parametrize("address", ["foo", "300", "", "3/2/"])
def test_the_addresses_of_several_drives_are_stations(address: str, tmp_path: Path) -> None:
    two = tmp_path / "two.par"
    two.write_bytes((TEXT + TEXT.replace("CSB02.1C\r\n1\r\n", f"CSB02.1C\r\n{address}\r\n")).encode("latin-1"))
    place = f"line {TEXT.count(chr(10)) + 5}: '{address}' is not the address of a drive"
    refused(run(tmp_path, "parameters", "--from", two), 2, place)


def test_what_differs_from_a_backup(tmp_path: Path) -> None:
    """Accesses.txt writes S-0-0047 as 05 02 03 04 to device 5, and as 11 22 33 44 to device 6: 4 decimal places."""
    done = run(tmp_path, "parameters", CAPTURE, "--against", PAR)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        "3 device 5  S-0-0047 (Position command value)  12.3456 Deg -> 6730.5989 Deg  written by 16 in packet 28",
        "3 device 6  S-0-0047 (Position command value)  12.3456 Deg -> 114420.1745 Deg  written by 16 in packet 32",
        "2 of 2 parameters of station 3 differ from the backup",
    ]
    same = tmp_path / "same.par"
    same.write_bytes(TEXT.replace("\r\n12.3456\r\n", "\r\n6730.5989\r\n").encode("latin-1"))
    done = run(tmp_path, "parameters", CAPTURE, "--against", same)
    assert done.stdout.splitlines()[-1] == "1 of 2 parameters of station 3 differ from the backup"


# Ascii.txt reads S-0-0051 as -7.5000, writes 0x0010 to P-0-0004, and the list P-0-4006 as 1.0000 and 2.5000.
TYPED = """\
SERCOS-ASCII
2026-11-24 13:00:00
Axis
DKC
21
|
S-0-0051.0.0
Position feedback
00000100001000100000000000000001
mm
--
--
-7.5
|
P-0-0004.0.0
Control word
00000000001100010000000000000001
--
--
--
0x0011
|
P-0-4006.0.0
Positions
00000100001001100000000000000001
mm
--
--
8
64
1.0000
2.5000
"""


def test_values_of_the_ascii_protocol_are_compared_by_their_number(tmp_path: Path) -> None:
    """Both protocols write numbers with more or fewer zeros; what is no value of its attribute differs, too."""
    par = tmp_path / "typed.par"
    par.write_text(TYPED)
    ascii_ = CAPTURE.with_name("ascii.pcapng")
    changed = "21 device 21  P-0-0004 (Control word)  0x0011 -> 0x0010  written by ASCII in packet 21"
    done = run(tmp_path, "parameters", ascii_, "--against", par)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [changed, "1 of 3 parameters of station 21 differ from the backup"]
    par.write_text(TYPED.replace("00110001", "00010001").replace("0x0011", "17").replace("2.5000", "2.5001"))
    assert run(tmp_path, "parameters", ascii_, "--against", par).stdout.splitlines() == [
        changed.replace("0x0011", "17"),
        "21 device 21  P-0-4006 (Positions)  1.0000, 2.5001 mm -> 1.0000, 2.5000 mm  written by ASCII in packet 32",
        "2 of 3 parameters of station 21 differ from the backup",
    ]


@pytest.mark.parametrize(
    ("line", "other", "options", "why"),
    [
        ("", "", ("--station", "9"), "the backup is of station 9, and the capture has values of stations 3, 4/8"),
        ("S-0-0047.0.0", "S-0-3047.0.0", (), "no value of a parameter that the backup has"),
    ],
)
def test_nothing_compared_is_not_all_well(
    line: str, other: str, options: Sequence[str], why: str, tmp_path: Path
) -> None:
    par = tmp_path / "drive.par"
    par.write_bytes(TEXT.replace(line, other, 1).encode("latin-1"))
    refused(run(tmp_path, "parameters", CAPTURE, "--against", par, *options), 2, why)


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
