# SPDX-License-Identifier: GPL-2.0-or-later
"""The ASCII protocol of ECODRIVE and IndraDrive: lines as MPH-02 (p. 10-86 to 10-91) and public clients have them."""

from __future__ import annotations

import json

from sistap.dissected.wireshark.tshark import Tshark
from tables import HERE, Table, check

NAMES = "Text Open Prompt Read Write Element Asks Error Echo Answer End"  # the kinds, in the order of their codes
TEXT, OPEN, PROMPT, READ, WRITE, ELEMENT, ASKS, ERROR, ECHO, ANSWER, END = (
    f"sisascii.kind={number}" for number, _ in enumerate(NAMES.split())
)
FIELDS = (
    "sisascii.kind sisascii.drive sisascii.element sisascii.index sisascii.text "
    "sis.parameter sis.parameter.name sis.value sis.value.number sis.error sis.reaction_in sis.command_in"
)
STANDARD = "sis.parameter=S-0-0051; sis.parameter.name=Position feedback value 1 (motor feedback)"
NAMED = "sis.parameter=S-0-0051; sis.parameter.name=Position feedback 1 value"
SCALING = "sis.parameter=S-0-0044; sis.parameter.name=Velocity data scaling type"
DIAGNOSIS = "sis.parameter=S-0-0390; sis.parameter.name=DiagnosticNumber"
DRIVE, DATA = "sisascii.drive=21", "sisascii.element=7"


def of(frame: int) -> str:
    """Return the link to a command."""
    return f"{DRIVE}; sis.command_in={frame}"


def by(frame: int) -> str:
    """Return the link to an answer."""
    return f"{DRIVE}; sis.reaction_in={frame}"


LIST, STRUCTURE = "sis.parameter=P-0-4006", "sis.parameter=S-0-0390.0.136"
LINES: Table = {
    1: f"{OPEN}; {by(2)}",
    2: f"{PROMPT}; {of(1)}",
    3: f"{READ}; {by(5)}; {DATA}; {STANDARD}",
    4: f"{ECHO}; {of(3)}; {DATA}; {STANDARD}; sisascii.text=S-0-0051,7,R",
    5: f"{ANSWER}; {of(3)}; {DATA}; {STANDARD}; sis.value=12.3456; sis.value.number=12.3456",
    6: f"{PROMPT}; {of(3)}",
    7: f"{READ}; {by(9)}; sisascii.element=2; {STANDARD}",
    8: f"{ECHO}; {of(7)}; sisascii.element=2; {STANDARD}; sisascii.text=S-0-0051,2,r",
    9: f"{ANSWER}; {of(7)}; sisascii.element=2; {STANDARD}; sis.value=Position feedback 1 value",
    10: f"{PROMPT}; {of(7)}",
    11: f"{READ}; {by(12)}; sisascii.element=4; {NAMED}",
    12: f"{ANSWER}; {of(11)}; sisascii.element=4; {NAMED}; sis.value=mm",
    13: f"{PROMPT}; {of(11)}",
    14: f"{READ}; {by(15)}; {DATA}; {NAMED}",
    15: f"{ANSWER}; {of(14)}; {DATA}; {NAMED}; sis.value=-7.5000 mm; sis.value.number=-7.5",
    16: f"{PROMPT}; {of(14)}",
    17: f"{WRITE}; {by(18)}; {DATA}; {SCALING}; sis.value=-2.50; sis.value.number=-2.5",
    18: f"{PROMPT}; {of(17)}",
    19: f"{WRITE}; {by(21)}; {DATA}; sis.parameter=P-0-0004; sis.value=0x0010",
    20: f"{ECHO}; {of(19)}; {DATA}; sis.parameter=P-0-0004; sisascii.text=P-0-0004,7,W,0x0010",
    21: f"{PROMPT}; {of(19)}",
    # A list, element by element: each has an echo, and "?" or the prompt as its answer
    22: f"{WRITE}; {by(24)}; {DATA}; {LIST}",
    23: f"{ECHO}; {of(22)}; {DATA}; {LIST}; sisascii.text=P-0-4006,7,W,>",
    24: f"{ASKS}; {of(22)}; {DATA}; {LIST}",
    25: f"{ELEMENT}; {by(27)}; {DATA}; sisascii.index=1; {LIST}; sis.value=1.0000; sis.value.number=1",
    26: f"{ECHO}; {of(25)}; {DATA}; {LIST}; sisascii.text=1.0000",
    27: f"{ASKS}; {of(25)}; {DATA}; {LIST}",
    28: f"{ELEMENT}; {by(29)}; {DATA}; sisascii.index=2; {LIST}; sis.value=2.5000; sis.value.number=2.5",
    29: f"{ASKS}; {of(28)}; {DATA}; {LIST}",
    30: f"{END}; {by(32)}; {DATA}; {LIST}",
    31: f"{ECHO}; {of(30)}; {DATA}; {LIST}; sisascii.text=<",
    32: f"{PROMPT}; {of(30)}",
    33: f"{READ}; {by(34)}; {DATA}; {LIST}",
    34: f"{ANSWER}; {of(33)}; {DATA}; {LIST}; sis.value=1.0000; sis.value.number=1",
    35: f"{ANSWER}; {of(33)}; {DATA}; sisascii.index=2; {LIST}; sis.value=2.5000; sis.value.number=2.5",
    36: f"{PROMPT}; {of(33)}",
    37: f"{READ}; {by(38)}; {DATA}; {DIAGNOSIS}",
    38: f"{ANSWER}; {of(37)}; {DATA}; {DIAGNOSIS}; sis.value=A0013",
    39: f"{PROMPT}; {of(37)}",
    40: f"{READ}; {by(41)}; {DATA}; {STRUCTURE}",
    41: f"{ANSWER}; {of(40)}; {DATA}; {STRUCTURE}; sis.value=0013",  # a code is no number
    42: f"{PROMPT}; {of(40)}",
    43: f"{WRITE}; {by(44)}; {DATA}; {NAMED}; sis.value=1x",
    44: f"{ERROR}; {of(43)}; {DATA}; {NAMED}; sis.error=0x9007",
    45: f"{PROMPT}; {of(43)}",
    46: f"{WRITE}; {by(47)}; {DATA}; {NAMED}; sis.value=1 mm; sis.value.number=1",
    47: f"{ERROR}; {of(46)}; {DATA}; {NAMED}; sis.error=0x7004",
    48: f"{PROMPT}; {of(46)}",
    49: f"{READ}; {by(50)}; {DATA}; {NAMED}",
    50: f"{ERROR}; {of(49)}; {DATA}; {NAMED}; sis.error=0xbeef",
    51: f"{PROMPT}; {of(49)}",
    # What no document and no client shows
    52: f"{TEXT}; {DRIVE}; sisascii.text=#12345",
    53: f"{TEXT}; {DRIVE}; sisascii.text=S-0-0051,8,R",
    54: f"{TEXT}; {DRIVE}; sisascii.text=S-0-0051,7,X",
    55: f"{TEXT}; {DRIVE}; sisascii.text=BCD:256",
    56: f"{TEXT}; {DRIVE}; sisascii.text=E21:> ",
    57: f"{TEXT}; {DRIVE}",
    58: f"{TEXT}; {DRIVE}; sisascii.text=ÿ%s␉",
    59: f"{TEXT}; {DRIVE}; sisascii.text=S-0-4096,7,R",
}

LINKS = "sisascii.kind sis.command_in sis.reaction_in sis.repeat_of sis.unanswered_before"
NONE = "sis.command.unanswered"
CONVERSATIONS: Table = {
    1: f"{OPEN}; {NONE}",
    2: f"{OPEN}; sis.repeat_of=1; sis.unanswered_before=1; {NONE}; sis.command.repeat",
    3: f"{OPEN}; sis.repeat_of=1; sis.unanswered_before=2; {NONE}; sis.command.repeat",
    4: f"{OPEN}; sis.unanswered_before=3; sis.reaction_in=5",
    5: f"{PROMPT}; sis.command_in=4",
    6: f"{READ}; {NONE}",
    7: f"{ECHO}; sis.command_in=6",
    8: f"{READ}; sis.repeat_of=6; sis.unanswered_before=6; {NONE}; sis.command.repeat",
    9: f"{READ}; sis.repeat_of=6; sis.unanswered_before=8; {NONE}; sis.command.repeat",
    10: f"{READ}; sis.repeat_of=6; sis.unanswered_before=9; {NONE}; sis.command.repeat",
    11: f"{READ}; sis.repeat_of=6; sis.unanswered_before=10; sis.reaction_in=12; sis.command.repeat",
    12: f"{ANSWER}; sis.command_in=11",
    13: f"{PROMPT}; sis.command_in=11",
    14: f"{READ}; sis.reaction_in=16",
    15: f"{ECHO}; sis.command_in=14",
    16: f"{ANSWER}; sis.command_in=14",
    17: f"{PROMPT}; sis.command_in=14",
    18: READ,  # nobody knows what the damaged characters were
    20: f"{READ}; sis.reaction_in=21",
    21: f"{ANSWER}; sis.command_in=20",
    22: f"{READ}; {NONE}",
    23: f"{WRITE}; sis.unanswered_before=22; sis.reaction_in=24",
    24: f"{ASKS}; sis.command_in=23",
    25: f"{OPEN}; sis.reaction_in=26",  # the master gave up its list; the drive owes it nothing
    26: f"{PROMPT}; sis.command_in=25",
    27: f"{READ}; {NONE}",
    28: f"{READ}; sis.repeat_of=27; sis.unanswered_before=27; sis.reaction_in=31; sis.command.repeat",
    29: TEXT,
    30: f"{ECHO}; sis.command_in=28",
    31: f"{ANSWER}; sis.command_in=28",
    32: f"{PROMPT}; sis.command_in=28",
}
_ANSWERED = (5, 12, 16, 21, 24, 26)  # 25 ms after the last character of the command, or of its echo


def test_lines(tshark: Tshark) -> None:
    check(tshark, "ascii", FIELDS, "", LINES, prefix="")


def test_commands_and_answers(tshark: Tshark) -> None:
    check(tshark, "ascii-lines", LINKS, f"{NONE} sis.command.repeat", CONVERSATIONS, prefix="")


def test_a_time_is_judged_where_a_limit_is_known(tshark: Tshark) -> None:
    """Uncertain by 0.31 ms. Frames 16 and 31 come 25 ms after the echo, whose 13 intervals count, and so on."""
    assert _verdicts(tshark) == {}
    late = {frame: "0.025000000 0.020000000 1" for frame in _ANSWERED}
    late |= {16: "0.063541658 0.020000000 1", 31: "0.092708322 0.020000000 1"}
    assert _verdicts(tshark, "-o", "sis.trs_ms:20") == late
    assert _verdicts(tshark, "-o", "sis.trs_ms:25")[5] == "0.025000000 0.025000000 2"
    assert _verdicts(tshark, "-o", "sis.trs_ms:26")[5] == "0.025000000 0.026000000 0"


def _verdicts(tshark: Tshark, *options: str) -> dict[int, str]:
    fields = ("frame.number", "sis.reaction_time", "sis.trs.limit", "sis.trs.verdict")
    printed = [word for name in fields for word in ("-e", name)]
    capture = str(HERE / "ascii-lines.pcapng")
    rows = tshark.output("-r", capture, *options, "-Y", "sis.trs.verdict", "-T", "fields", *printed).splitlines()
    return {int(number): " ".join(rest) for number, *rest in (row.split("\t") for row in rows)}


def test_reads_and_writes_are_counted_like_those_of_sis(tshark: Tshark) -> None:
    """A list counts once, with all its elements; a write that was refused as an error."""
    capture = str(HERE / "ascii.pcapng")
    told = tshark.output("-r", capture, "-Y", "sis.access", "-T", "fields", "-e", "frame.number", "-e", "sis.access")
    found = {int(frame): json.loads(text) for frame, text in (row.split("\t") for row in told.splitlines())}
    feedback = {"station": "21", "device": 21, "parameter": "S-0-0051", "name": STANDARD.split("=")[2]}
    named = feedback | {"name": "Position feedback 1 value", "unit": "mm"}
    values = "1.0000, 2.5000"
    elements = {"station": "21", "device": 21, "parameter": "P-0-4006", "value": values, "text": values}
    assert found[6] == {"access": "read", **feedback, "value": "12.3456", "number": 12.3456, "text": "12.3456"}
    assert found[16] == {"access": "read", **named, "value": "-7.5000 mm", "number": -7.5, "text": "-7.5000"}
    assert found[32] == {"access": "write", **elements}
    assert found[36] == {"access": "read", **elements}
    assert found[48] == {"access": "write", **named, "error": "0x7004 Operating data cannot be changed"}
    assert set(found) == {6, 16, 18, 21, 32, 36, 39, 42, 45, 48, 51}
    times = tshark.output("-r", capture, "-q", "-z", "sisascii,srt").splitlines()
    assert [row.split()[3] for row in times if "Read parameter" in row] == ["8"]


def test_one_filter_finds_a_parameter_on_every_road(tshark: Tshark) -> None:
    """SIS, ASCII, RK512 and PCP in one capture."""
    capture = str(HERE / "roads.pcapng")
    found = tshark.output(
        "-r",
        capture,
        "-Y",
        'sis.parameter == "S-0-0051"',
        "-T",
        "fields",
        "-e",
        "frame.number",
        "-e",
        "frame.protocols",
    )
    carriers = ("sisascii", "3964r", "synaxpcp", "sis")
    roads = {
        int(number): next(carrier for carrier in carriers if carrier in protocols.split(":"))
        for number, protocols in (row.split("\t") for row in found.splitlines())
    }
    assert roads == {
        **dict.fromkeys((1, 2), "sis"),
        **dict.fromkeys((5, 6), "sisascii"),
        **dict.fromkeys((10, 14), "3964r"),  # with RK512 inside
        16: "synaxpcp",
    }
