# SPDX-License-Identifier: GPL-2.0-or-later
"""Parameters: values by their attributes, commands, and what is learned from the bus."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import pytest

from make import Scenario
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.sis.names import S_NAMES as S_NAMES_WRITTEN
from tables import HERE, Table, check, shown

FIELDS = "parameter parameter.name value attribute element.name element.unit error list.actual list.maximum"
ATTRIBUTE = "attribute.factor attribute.length attribute.command attribute.format attribute.decimals"
PROTECTED = "attribute.protected_2 attribute.protected_3 attribute.protected_4"
STATUS = (
    "data_status data_status.set data_status.enabled data_status.not_executed data_status.impossible "
    "data_status.invalid"
)

VALUES: Table = {
    # 2 bytes, binary
    2: "attribute=0x00010001",
    4: "value=0b1000 0000 0000 0101",
    # 2 bytes, unsigned
    6: "attribute=0x00110001",
    8: "value=65535",
    # 2 bytes, unsigned, factor 5, two decimal places: 100 x 5 / 100
    10: "attribute=0x02110005",
    12: "value=5.00",
    # 2 bytes, signed
    14: "attribute=0x00210001",
    16: "value=-1",
    # 2 bytes, signed, the least
    18: "attribute=0x00210001",
    20: "value=-32768",
    # 2 bytes, hexadecimal
    22: "attribute=0x00310001",
    24: "value=0x12AB",
    # 2 bytes, ident number
    26: "attribute=0x00510001",
    28: "value=P-0-0044",
    # 2 bytes, ident number with parameter set
    30: "attribute=0x00510001",
    32: "value=P-2-0044",
    # 4 bytes, binary
    34: "attribute=0x00020001",
    36: "value=0b1111 0000 0000 0000 0000 0000 0000 0001",
    # 4 bytes, unsigned
    38: "attribute=0x00120001",
    40: "value=4294967295",
    # 4 bytes, signed, three decimal places
    42: "attribute=0x03220001",
    44: "value=-0.001",
    # 4 bytes, hexadecimal
    46: "attribute=0x00320001",
    48: "value=0x0EADBEEF",
    # 4 bytes, float
    50: "attribute=0x00620001",
    52: "value=-1.5",
    # 8 bytes, unsigned
    54: "attribute=0x00130001",
    56: "value=18446744073709551615",
    # 8 bytes, signed, the least
    58: "attribute=0x00230001",
    60: "value=-9223372036854775808",
    # 8 bytes, signed, 15 decimal places
    62: "attribute=0x0f230001",
    64: "value=0.000000000000001",
    # 8 bytes, float
    66: "attribute=0x00630001",
    68: "value=1.5",
    # list of single bytes, unsigned
    70: "attribute=0x00140001",
    72: "value=1,2,255",
    # list of 2-byte elements, signed
    74: "attribute=0x00250001",
    76: "value=-1,2",
    # list of 2-byte elements, ident numbers
    78: "attribute=0x00550001",
    80: "value=S-0-0047,P-0-0012",
    # list of 4-byte elements, unsigned, one decimal place
    82: "attribute=0x01160001",
    84: "value=1.0,2.0",
    # list of 4-byte elements, float
    86: "attribute=0x00660001",
    88: "value=1,-2",
    # list of 8-byte elements, unsigned
    90: "attribute=0x00170001",
    92: "value=1,2",
    # text
    94: "attribute=0x00440001",
    96: "value=AB",
    # text with length words: actual 2, maximum 40
    98: "attribute=0x00440001",
    100: "value=AB; list.actual=2; list.maximum=40",
    # list with length words: actual 4, maximum 8
    102: "attribute=0x00150001",
    104: "value=1,2; list.actual=4; list.maximum=8",
    # not length words: 2 + 4 are not 8 bytes
    106: "attribute=0x00150001",
    108: "value=2,8,5,8",
    # not length words: more than the maximum
    110: "attribute=0x00150001",
    112: "value=4,2,1,2",
    # an empty list with length words
    114: "attribute=0x00150001",
    116: "list.actual=0; list.maximum=8",
    # 4 bytes where the attribute says 2: no value
    118: "attribute=0x00110001",
    # length code 0 is not defined: no value
    122: "attribute=0x00200001",
    # A remainder of a list is not a value: bytes
    126: "attribute=0x00160001",
    128: "value=7; raw=0102",
    # Its minimum is as long as one element
    130: "value=9",
    # Elements with a unit; that of S-0-0400 is "mm"
    134: "value=1 mm,2 mm",
    # A segment never begins with length words
    135: "list_offset=0; list_length=8",
    136: "value=524292 mm,1 mm",
    137: "list_offset=40; list_length=4; value=100000000 mm",
    # The ident number, read
    140: "value=S-0-0400",
    # 4 and 8 bytes, hexadecimal
    142: "attribute=0x00320001",
    144: "value=0x000F2028",
    146: "attribute=0x00330001",
    148: "value=0xFFFFFFFFFFFFFFFF",
    # List of idents of 4 bytes
    150: "attribute=0x70560001",
    152: "value=S-0-0390,S-0-0390.0.136,S-0-0600.1.1,P-0-4089.0.13; list.actual=16; list.maximum=16692",
    # One ident of 4 bytes
    154: "attribute=0x00520001",
    156: "value=S-0-0047",
    # A time, and what is none
    158: "attribute=0x00730001",
    160: "value=2000-01-01 00:00:00.000000001",
    162: "value=0x3B9ACA00386D4380",
}

PARAMETERS: Table = {
    # Before anything is known
    1: "parameter=S-0-0047; parameter.name=Position command value",
    2: "parameter=S-0-0047; parameter.name=Position command value",
    # Attribute 0x04220001: 4 bytes, signed, 4 decimal places; unit; name
    3: "parameter=S-0-0047; parameter.name=Position command value",
    4: "parameter=S-0-0047; parameter.name=Position command value; attribute=0x04220001",
    5: "parameter=S-0-0047; parameter.name=Position command value",
    6: "parameter=S-0-0047; parameter.name=Position command value; value=-12.3450",
    7: "parameter=S-0-0047; parameter.name=Position command value",
    8: "parameter=S-0-0047; parameter.name=Position command value; element.unit=deg",
    9: "parameter=S-0-0047; parameter.name=Position command value",
    10: "parameter=S-0-0047; parameter.name=Position command value; element.name=Position",
    11: "parameter=S-0-0047; parameter.name=Position",
    12: "parameter=S-0-0047; parameter.name=Position; value=-12.3450 deg",
    13: "parameter=S-0-0047; parameter.name=Position; value=12.3456 deg",
    14: "parameter=S-0-0047; parameter.name=Position",
    # Minimum and maximum are scaled, too
    15: "parameter=S-0-0047; parameter.name=Position",
    16: "parameter=S-0-0047; parameter.name=Position; value=-178.8032 deg",
    17: "parameter=S-0-0047; parameter.name=Position",
    18: "parameter=S-0-0047; parameter.name=Position; value=0.0001 deg",
    # Another device or station: the standard's name. The P parameter of the same number, another parameter set: unknown
    19: "parameter=S-0-0047; parameter.name=Position command value",
    20: "parameter=S-0-0047; parameter.name=Position command value",
    21: "parameter=S-0-0047; parameter.name=Position command value",
    22: "parameter=S-0-0047; parameter.name=Position command value",
    23: "parameter=P-0-0047",
    24: "parameter=P-0-0047",
    25: "parameter=S-2-0047",
    26: "parameter=S-2-0047",
    27: "parameter=A-0-0047",
    28: "parameter=A-0-0047",
    # Another master asks the same drive: known
    29: "parameter=S-0-0047; parameter.name=Position",
    30: "parameter=S-0-0047; parameter.name=Position; value=-12.3450 deg",
    # A new name, in two pieces and with length words (actual 4, maximum 40): from then on
    31: "parameter=S-0-0047; parameter.name=Position",
    32: "parameter=S-0-0047; parameter.name=Position",
    33: "parameter=S-0-0047; parameter.name=Position",
    34: "parameter=S-0-0047; parameter.name=Position; element.name=Axis; list.actual=4; list.maximum=40",
    35: "parameter=S-0-0047; parameter.name=Axis",
    36: "parameter=S-0-0047; parameter.name=Axis; value=-12.3450 deg",
    # A new attribute: 4 bytes, unsigned, 1 decimal place
    37: "parameter=S-0-0047; parameter.name=Axis",
    38: "parameter=S-0-0047; parameter.name=Axis; attribute=0x01120001",
    39: "parameter=S-0-0047; parameter.name=Axis",
    40: "parameter=S-0-0047; parameter.name=Axis; value=1.0 deg",
    # A damaged reaction teaches nothing; a refused one neither
    41: "parameter=S-0-0047; parameter.name=Axis",
    42: "element.name=Bad",
    43: "parameter=S-0-0047; parameter.name=Axis",
    44: "parameter=S-0-0047; parameter.name=Axis; error=0x2001",
    45: "parameter=S-0-0047; parameter.name=Axis",
    46: "parameter=S-0-0047; parameter.name=Axis; value=1.0 deg",
    # How parameters are written: sets, kinds, undocumented types
    47: "parameter=P-2-0012",
    48: "parameter=S-7-4095",
    49: "parameter=C-0-4095",
    50: "parameter=type3-0-0066",
    # Names that Wireshark has or that are built in
    51: "parameter=S-0-0044; parameter.name=Velocity data scaling type",
    52: "parameter=C-0-0066; parameter.name=Master axis, position feedback value",
    53: "parameter=A-0-0066",
    # A learned name goes before the built-in one
    54: "parameter=S-0-0044; parameter.name=Velocity data scaling type",
    55: "parameter=S-0-0044; parameter.name=Velocity data scaling type; element.name=Scale",
    56: "parameter=S-0-0044; parameter.name=Scale",
    57: "parameter=S-0-0044; parameter.name=Scale",
    # Drives 8 and 9 behind router 4, both with device address 0: each has its own
    58: "parameter=S-0-0047; parameter.name=Position command value",
    59: "parameter=S-0-0047; parameter.name=Position command value; element.name=8",
    60: "parameter=S-0-0047; parameter.name=Position command value",
    61: "parameter=S-0-0047; parameter.name=Position command value",
    62: "parameter=S-0-0047; parameter.name=8",
    63: "parameter=S-0-0047; parameter.name=8",
    # Router 4 itself is not station 0 behind it
    64: "parameter=S-0-0047; parameter.name=Position command value",
    65: "parameter=S-0-0047; parameter.name=Position command value; element.name=4",
    66: "parameter=S-0-0047; parameter.name=Position command value",
    67: "parameter=S-0-0047; parameter.name=Position command value",
}

# A master that never reads a name.
S_NAMES: Table = {
    **dict.fromkeys((1, 2, 8), "parameter=S-0-0051; parameter.name=Position feedback value 1 (motor feedback)"),
    # The P parameter of the number, another parameter set, a control parameter
    3: "parameter=P-0-0051",
    4: "parameter=S-1-0051",
    5: "parameter=A-0-0051",
    # Not in Wireshark's table, or a dummy there
    6: "parameter=S-0-0000",
    7: "parameter=S-0-0003",
    # What the bus says goes first
    9: "parameter=S-0-0051; parameter.name=Position feedback value 1 (motor feedback); element.name=Axis",
    10: "parameter=S-0-0051; parameter.name=Axis",
}

USER_TABLE: Table = {
    # The table alone
    1: "parameter.name=Table position",
    2: "parameter.name=Table position; value=-12.3450 mm",
    # The bus says that there is no unit: length words, actual 0, maximum 40
    3: "parameter.name=Table position",
    4: "parameter.name=Table position",
    5: "parameter.name=Table position",
    6: "parameter.name=Table position; value=-12.3450",
    # The bus says the name
    7: "parameter.name=Table position",
    8: "parameter.name=Table position",
    9: "parameter.name=Axis",
    10: "parameter.name=Axis; value=-12.3450",
    # The bus says the attribute: 4 bytes, unsigned, 1 decimal place
    11: "parameter.name=Axis",
    12: "parameter.name=Axis",
    13: "parameter.name=Axis",
    14: "parameter.name=Axis; value=1.0",
    # Another device: still the table
    15: "parameter.name=Table position",
    16: "parameter.name=Table position; value=-12.3450 mm",
    # The table goes before the built-in name; a row without a name leaves it; a row is for one parameter set
    17: "parameter.name=Table scaling",
    18: "parameter.name=Table scaling",
    19: "parameter.name=Master axis, position feedback value",
    20: "parameter.name=Master axis, position feedback value",
    21: "parameter.name=Master axis, position feedback value",
    22: "parameter.name=Master axis, position feedback value; value=12.3456 deg",
    23: "parameter.name=Second set",
    24: "parameter.name=Second set",
    # P-0-0040 has no built-in name: what it is depends on the device
    # The bus goes before the built-in name, too
    27: "parameter.name=Modulo value",
    28: "parameter.name=Modulo value",
    29: "parameter.name=Turn",
    30: "parameter.name=Turn",
}

COMMANDS: Table = {
    # Attribute 0x70090001: factor 1, 2 bytes, a command, binary, no decimal places, write-protected in phases 2, 3
    # and 4
    2: "attribute=0x70090001; attribute.factor=1; attribute.length=1; attribute.command=1; "
    "attribute.format=0; attribute.decimals=0; attribute.protected_2=1; attribute.protected_3=1; "
    "attribute.protected_4=1",
    # Attribute 0x2F660102 of S-0-0001: factor 258, list of 4-byte elements, float, 15 places, write-protected in
    # phase 3
    4: "attribute=0x2f660102; attribute.factor=258; attribute.length=6; attribute.command=0; "
    "attribute.format=6; attribute.decimals=15; attribute.protected_2=0; attribute.protected_3=1; "
    "attribute.protected_4=0",
    # Requests: set and enable, interrupt, clear
    5: "value=0b0000 0000 0000 0011 (set and enable)",
    7: "value=0b0000 0000 0000 0001 (interrupt)",
    9: "value=0b0000 0000 0000 0000 (clear)",
    11: "value=0b0000 0000 0000 0010",
    # Data status: fig. 8-42 and 8-43, the request repeats the ident number
    14: "data_status=0x0003; data_status.set=1; data_status.enabled=1; data_status.not_executed=0; "
    "data_status.impossible=0; data_status.invalid=0",
    # Without it: in process, interrupted, not possible, not set, operating data invalid
    16: "data_status=0x0007; data_status.set=1; data_status.enabled=1; data_status.not_executed=1; "
    "data_status.impossible=0; data_status.invalid=0",
    18: "data_status=0x0005; data_status.set=1; data_status.enabled=0; data_status.not_executed=1; "
    "data_status.impossible=0; data_status.invalid=0",
    20: "data_status=0x000f; data_status.set=1; data_status.enabled=1; data_status.not_executed=1; "
    "data_status.impossible=1; data_status.invalid=0",
    22: "data_status=0x0000; data_status.set=0; data_status.enabled=0; data_status.not_executed=0; "
    "data_status.impossible=0; data_status.invalid=0",
    24: "data_status=0x0100; data_status.set=0; data_status.enabled=0; data_status.not_executed=0; "
    "data_status.impossible=0; data_status.invalid=1",
    # Attribute 0x003B0001: factor 1, 8 bytes, a command, hexadecimal. 0x0000000100000003 is no request, 3 is one.
    26: "attribute=0x003b0001; attribute.factor=1; attribute.length=3; attribute.command=1; "
    "attribute.format=3; attribute.decimals=0; attribute.protected_2=0; attribute.protected_3=0; "
    "attribute.protected_4=0",
    27: "value=0x0000000100000003",
    29: "value=0x0000000000000003 (set and enable)",
}

# Values that no document describes have a note; so has an attribute of 3 bytes.
RARE: Table = {
    4: "value=1.2089073728705555e+24",  # (2^64 - 1) x 65535
    8: "value=0x0807060504030201; body.note",
    12: "value=0x1234; body.note",
    14: "body.note",
    36: "value=12.3456",
    42: "value=12.3456",
}

TIMES = (160, 162)  # have no number
NUMBER = re.compile(r"(?:-?[\d.]+(e[+-]\d+)?|0x[\dA-F]+)(?= |$)")  # in front of a unit; not 0b1010, S-0-0047


def numbers(row: str) -> list[float]:
    """Return the numbers that the values in a row show: infinity has none, and neither has a list of characters."""
    values = re.search(r"(?:^|; )value=([^;]*)", row)
    texts = [found[0] for text in (values[1].split(",") if values else ()) if (found := NUMBER.match(text))]
    return [float(int(text, 16) if text.startswith("0x") else text) for text in texts]


def test_each_value_that_is_a_number_is_one(tshark: Tshark) -> None:
    """Without a unit, once for each element of a list, as displayed."""
    found = shown(tshark, HERE / "values.pcapng", "value.number")
    for frame, cells in found.items():
        expected = numbers(VALUES.get(frame, "")) if frame not in TIMES else []
        shown_here = [float(text) for text in cells.get("value.number", "").split(",") if text]
        assert shown_here == pytest.approx(expected, rel=1e-14), frame


def test_an_access_has_the_number_of_a_hexadecimal_value(tshark: Tshark) -> None:
    frames = shown(tshark, HERE / "values.pcapng", "access")
    for frame, number in ((24, 0x12AB), (144, 0xF2028), (148, 2**64 - 1)):
        access = json.loads(frames[frame]["access"])
        assert (access["number"], access["value"]) == (number, VALUES[frame].partition("=")[2])


def test_a_filter_compares_numbers(tshark: Tshark) -> None:
    """As texts, 65535 and 524292 are less than 9, and -1 is more than -2."""
    above = shown(tshark, HERE / "values.pcapng", "value", "-Y", "sis.value.number > 1000")
    rows = [row for frame, row in VALUES.items() if frame not in TIMES]
    expected = [row for row in rows if any(number > 1000 for number in numbers(row))]
    assert len(above) == len(expected)
    assert all("value=" + cells["value"] in row for cells, row in zip(above.values(), expected, strict=True))


# By frame; what is not here has no name and no value.
TWINS: Table = {
    **dict.fromkeys((5, 6, 7, 9), "parameter.name=Limit"),
    8: "parameter.name=Limit; element.unit=Nm",
    4: "element.name=Limit",
    10: "parameter.name=Limit; value=10.00 Nm",
    # Station 3, which has told the same type
    15: "parameter.name=Limit; parameter.maximum=10.00 Nm",
    16: "parameter.name=Limit; parameter.maximum=10.00 Nm; value=5.00 Nm",
    17: "parameter.name=Limit; parameter.maximum=10.00 Nm",
    18: "parameter.name=Limit; parameter.maximum=10.00 Nm; element.name=Own",
    19: "parameter.name=Own; parameter.maximum=10.00 Nm",
    20: "parameter.name=Own; parameter.maximum=10.00 Nm; value=5.00 Nm",
    # The standard's name, and that of the twin
    21: "parameter.name=Position feedback value 1 (motor feedback)",
    22: "parameter.name=Position feedback value 1 (motor feedback); element.name=Position",
    23: "parameter.name=Position",
    # The same firmware
    33: "element.name=Behind",
    34: "parameter.name=Behind",
    # The twin has another type now
    37: "parameter.name=Position feedback value 1 (motor feedback)",
    # From before this file
    46: "element.name=Told",
    47: "parameter.name=Told",
}


def test_what_a_device_of_the_same_type_says(tshark: Tshark) -> None:
    check(tshark, "twins", "parameter.name parameter.maximum value element.name element.unit", "", TWINS)
    text = tshark.output("-r", str(HERE / "twins.pcapng"), "-V", "-O", "sis", "-Y", "frame.number in {15, 19, 34}")
    assert text.count("[Name: Limit (learned from station 4, device 4, which has the same type)]") == 1
    assert text.count("[Name: Own (learned from the bus)]") == 1
    assert text.count("[Unit: Nm (learned from station 4, device 4, which has the same type)]") == 2
    assert text.count("[Name: Behind (learned from station 4/8, device 8, which has the same type)]") == 1


def test_values(tshark: Tshark) -> None:
    check(tshark, "values", "attribute value list.actual list.maximum list_offset list_length raw", "", VALUES)


def test_values_that_no_document_describes(tshark: Tshark) -> None:
    check(tshark, "rare", "value", "body.note", RARE)


def test_idents_in_a_list_have_names(tshark: Tshark) -> None:
    shown_text = tshark.output("-r", str(HERE / "values.pcapng"), "-V", "-O", "sis", "-Y", "frame.number in {152, 156}")
    assert "Element 1: S-0-0390 (DiagnosticNumber)\n" in shown_text
    assert "Element 2: S-0-0390.0.136\n" in shown_text, "an element of a structure is another parameter"
    assert "Value: S-0-0047 (Position command value)\n" in shown_text


def test_parameters(tshark: Tshark) -> None:
    check(tshark, "parameters", FIELDS, "", PARAMETERS)


def test_names_of_the_standard(tshark: Tshark) -> None:
    check(tshark, "s-names", "parameter parameter.name element.name", "", S_NAMES)


@pytest.mark.thorough
def test_names_of_the_standard_are_those_of_wireshark(tshark: Tshark) -> None:
    """For sis.lua and the virtual bus; in Wireshark, 0 is a dummy, and two numbers have a structure."""
    rows = (line.split("\t") for line in tshark.output("-G", "values").splitlines() if "\tsiii.mdt.svch.idn\t" in line)
    names = {int(row[2]): row[3] for row in rows if row[0] == "V" and 0 < int(row[2]) <= 0xFFF}
    assert names == S_NAMES_WRITTEN


def test_user_table(tshark: Tshark) -> None:
    options = Scenario(HERE / "user-table.txt").options
    check(tshark, "user-table", "parameter.name value", "", USER_TABLE, *options)


def test_commands(tshark: Tshark) -> None:
    check(tshark, "commands", f"attribute {ATTRIBUTE} {PROTECTED} {STATUS} value", "", COMMANDS)


def test_a_request_for_the_status_of_a_command_has_no_value(tshark: Tshark) -> None:
    """Fig. 8-42: it may carry its own ident number, which nobody has read or written."""
    shown = ["-T", "fields", "-e", "sis.data", "-e", "sis.value"]
    said = tshark.output("-r", str(HERE / "commands.pcapng"), "-Y", "frame.number == 13", *shown)
    assert said.rstrip("\n").split("\t") == ["0c80", ""]


@pytest.mark.thorough
@pytest.mark.parametrize("number", ["4096", "8-0001", "12-1", "", "S-0-0047", "1-", "-1"])
def test_user_table_refuses_what_is_no_number(number: str, tshark: Tshark) -> None:
    row = f'uat:sis_parameters:"S","{number}","A name","","0"'
    with pytest.raises(TsharkError):
        tshark.output("-r", str(HERE / "user-table.pcapng"), "-o", row)


# Frames of user-table.txt whose names come from each source.
SOURCES = {
    "learned from the bus": [9, 10, 11, 12, 13, 14, 29, 30],
    "from the table SIS parameters": [1, 2, 3, 4, 5, 6, 7, 8, 15, 16, 17, 18, 23, 24],
    "built in": [19, 20, 21, 22],
    "from Wireshark's SERCOS III table": [27, 28],
}


@pytest.mark.thorough
@pytest.mark.parametrize("cells", ['"256",""', '"3/",""', '"","1"', '"","64=A"', '"","1="'])
def test_user_table_refuses_what_is_no_station_and_no_bit(cells: str, tshark: Tshark) -> None:
    row = f'uat:sis_parameters:"S","0047","A name","","0","","",{cells}'
    with pytest.raises(TsharkError):
        tshark.output("-r", str(HERE / "user-table.pcapng"), "-o", row)


def test_source_of_a_name_is_shown(tshark: Tshark) -> None:
    scenario = Scenario(HERE / "user-table.txt")
    text = tshark.output("-r", str(HERE / "user-table.pcapng"), *scenario.options, "-T", "pdml")
    found: dict[str, list[int]] = {source: [] for source in SOURCES}
    for number, packet in enumerate(ElementTree.fromstring(text), 1):
        for field in packet.iter("field"):
            if field.get("name") == "sis.parameter.name":
                source = str(field.get("showname")).rpartition("(")[2].rstrip(")]")
                found[source].append(number)
    assert found == SOURCES
