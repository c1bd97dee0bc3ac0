# SPDX-License-Identifier: GPL-2.0-or-later
"""What a value tells: numbers, bits, texts, diagnoses of two widths; also if nobody describes it."""

from __future__ import annotations

import re

import pytest
from machines import access, undescribed

from sistap.dissected.episodes.readings import RAW, ValueReading, class_of, code_of, is_running, raw_number, reading
from sistap.dissected.episodes.standard import FOLLOWS, FORMS, LIMITS
from sistap.tap.sis.names import S_NAMES

WORDS = b"\x05\x00\x05\x00"  # the length of a text, and the longest


@pytest.mark.parametrize(
    ("ident", "data", "expected"),
    [
        ("P-0-0123", b"\xff", ValueReading(-1.0, "-1", RAW)),
        ("P-0-0123", b"\xf4\x01", ValueReading(500.0, "500", RAW)),
        ("P-0-0123", b"\xff\x7f\xff\xff", ValueReading(-32769.0, "-32769", RAW)),
        ("P-0-0123", b"\1\0\0\0\0\0\0\0", ValueReading(1.0, "1", RAW)),
        ("P-0-0123", b"\1\2\3", ValueReading(None, "010203")),  # no length of a number
        ("S-0-0390", b"\x28\x20\x0f\x00", ValueReading(None, "0x000F2028", "", 0xF2028)),
        ("S-0-0390", b"\x28\xf2", ValueReading(None, "0xF228", "", 0xF228)),
        ("S-0-0135", b"\x00\xc0", ValueReading(None, "0xC000", "", 0xC000)),
        ("S-0-0051", b"\xff\xff\xff\xff", ValueReading(-1.0, "-1", RAW)),  # a position is a number
        ("S-0-0095", WORDS + b"A0012", ValueReading(None, '"A0012"')),
        ("S-0-0095", b"\x04\x01\x04\x01" + b"A" * 260, ValueReading(None, '"' + "A" * 260 + '"')),
        ("S-0-0095", b"A", ValueReading(None, '"A"')),
        ("S-0-0095", b"F228 Excess\0", ValueReading(None, '"F228 Excess"')),
        ("S-0-0095", b"\x05\x00\x05\x00A001", ValueReading(None, '"\x05\x00\x05\x00A001"')),  # its length is another
    ],
)
def test_bytes_that_nobody_describes(ident: str, data: bytes, expected: ValueReading) -> None:
    assert reading(undescribed(3, ident, data)) == expected


@pytest.mark.parametrize(
    ("ident", "value", "number", "expected"),
    [
        ("S-0-0040", "100.0 rpm", 100.0, ValueReading(100.0, "100.0 rpm", "rpm")),
        ("S-0-0011", "0b0000 0000 0000 0011", None, ValueReading(None, "0b0000 0000 0000 0011", "", 3)),
        ("P-0-0012", "0b0000 0000 0000 0011 (set and enable)", None, 3),
        ("S-0-0011", "0b", None, ValueReading(None, "0b", "rpm")),
        ("S-0-0390", "0x000F2028", 991272.0, ValueReading(None, "0x000F2028", "", 991272)),
        ("P-0-4000", "0x00FF", 255.0, ValueReading(None, "0x00FF", "", 255)),
        ("S-0-0051", "100.0 rpm", 100.0, ValueReading(100.0, "100.0 rpm", "rpm")),  # a position
        ("S-0-0095", '"F228"', None, ValueReading(None, '"F228"', "rpm")),
        ("S-0-0012", "4", 4.0, ValueReading(None, "4", "", 4)),
        ("S-0-0012", "", None, None),
    ],
)
def test_described_values(ident: str, value: str, number: float | None, expected: ValueReading | int | None) -> None:
    said = reading(access(3, ident, value, number=number, unit="rpm"))
    assert (said and said.bits if isinstance(expected, int) else said) == expected


def test_what_was_refused_tells_nothing() -> None:
    assert reading(access(3, "S-0-0390", "0xF2028", error="0x1001")) is None
    assert reading(undescribed(3, "S-0-0390", b"")) is None


@pytest.mark.parametrize(
    ("ident", "text", "code"),
    [
        ("S-0-0390", "0x000F2028", "F2028"),
        ("S-0-0390", "0xF228", "F228"),
        ("S-0-0390", "0x050F0200", "50F0200"),
        ("S-0-0390", "991272", "F2028"),  # the drive shows it as a decimal number
        ("S-0-0390", "0x00000000", ""),
        ("S-0-0390", "0x1234", ""),
        ("S-0-0095", '"F228 Excessive deviation"', "F228"),
        ("S-0-0095", '"  A0012 Ready"', "A0012"),
        ("S-0-0095", '"Ready"', ""),
        ("S-0-0095", '"F22 short"', ""),
        ("S-0-0095", '"F20281 long"', ""),
    ],
)
def test_the_diagnosis_of_a_value(ident: str, text: str, code: str) -> None:
    assert code_of(ident, text) == code


@pytest.mark.parametrize(
    ("code", "letter", "runs"),
    [
        ("F2028", "F", False),
        ("F228", "F", False),
        ("E2051", "E", None),
        ("C0300", "C", None),
        ("A0101", "A", True),
        ("A0100", "A", True),
        ("A00FF", "A", False),
        ("A0012", "A", False),
        ("A101", "A", True),
        ("A012", "A", False),
        ("50F0200", "F", False),
        ("50A0200", "A", None),  # of a device with another list of states
        ("1234", "", None),
        ("", "", None),
    ],
)
def test_the_class_of_a_diagnosis(code: str, letter: str, *, runs: bool | None) -> None:
    assert (class_of(code), is_running(code)) == (letter, runs)


@pytest.mark.parametrize(
    ("data", "number"), [(b"\xff\xff", -1), (b"\1\0\0\0", 1), (b"\1", None), (b"\1\2\3", None), (b"\0" * 8, 0)]
)
def test_a_command_and_what_follows_it_are_compared_as_bytes(data: bytes, number: int | None) -> None:
    assert raw_number(undescribed(3, "S-0-0040", data)) == number


def test_standard_parameters_are_what_wireshark_names_them() -> None:
    named = {name: f"S-0-{number:04}" for number, name in S_NAMES.items()}
    assert {ident for name, ident in named.items() if name.endswith("limit value")} == LIMITS
    positions = [ident for ident, form in FORMS.items() if form == "position"]
    assert positions == [ident for name, ident in named.items() if re.match("Position .* value(?! status)", name)]
    assert FOLLOWS == {
        named["Velocity feedback value 1"]: named["Velocity command value"],
        named["Torque feedback value"]: named["Torque command value"],
    }
    forms = {
        "DiagnosticNumber": "diagnosis",
        "Diagnostic message": "diagnosis_text",
        "Class 1 diagnostic": "error_bits",
        "Class 2 diagnostic": "warning_bits",
        "Drive control": "control_word",
        "Drive status": "status_word",
        "Position feedback value status": "referenced",
        "Interface status": "bits",
        "Reset class 1 diagnostic": "bits",
    }
    assert {name: FORMS[named[name]] for name in forms} == forms
