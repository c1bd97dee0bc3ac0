# SPDX-License-Identifier: GPL-2.0-or-later
"""The ASCII protocol of a drive: conversations as public clients for DKCxx.3 drives lead them, and those of MPH-02."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sisbus.scenarios.scenario import Playing, load
from sisbus.stations.making import make
from sisbus.wires.answering import Answering
from sistap.tap.line.settings import LineSettings
from sistap.tap.sis.telegram import build

TABLES: list[dict[str, object]] = [
    {"address": 21, "parameters": {"P-0-4006": {"decimals": 4, "value": [0, 90, 180]}}},
    {"address": 1},
]


class Client:
    """Sends a line and reads what has come, as the clients do."""

    def __init__(self) -> None:
        self.bus = Answering(make(TABLES, 1), LineSettings.parse(9600, "8N1"))
        self.now_ns = 0

    def say(self, characters: bytes) -> str:
        self.now_ns += 1_000_000_000
        return b"".join(answer.reaction for answer in self.bus.hear(characters, self.now_ns)).decode("latin-1")

    def read(self, parameter: str) -> str:
        """Read the operating data: the second line of what comes, if the prompt is there."""
        answer = self.say(f"{parameter},7,R\r\n".encode())
        assert "E21:>" in answer
        assert f"{parameter},7,R" in answer
        return answer.split("\r\n")[1]


@pytest.fixture
def client() -> Client:
    opened = Client()
    assert opened.say(b"BCD:21\r\n").split()[0] == "E21:>"
    return opened


@pytest.mark.parametrize("end", [b"\r", b"\r\n"])
def test_a_drive_is_opened_and_read(end: bytes) -> None:
    client = Client()
    assert client.say(b"S-0-0051,7,R" + end) == ""  # nobody is open
    assert client.say(b"BCD:21" + end) == "E21:>"
    assert client.say(b"S-0-0051,7,R" + end) == "S-0-0051,7,R\r\n0.0000\r\nE21:>"
    assert client.say(b"BCD:1" + end) == "E01:>"  # MPH-02, p. 10-86
    assert client.say(b"S-0-0001,7,r" + end) == "S-0-0001,7,r\r\n2000\r\nE01:>"
    assert client.say(b"BCD:9" + end) == ""


def test_what_the_clients_read(client: Client) -> None:
    for parameter in ("S-0-0051", "S-0-0040", "S-0-0047", "S-0-0049", "S-0-0050"):
        float(client.read(parameter))
    assert client.read("S-0-0134")[13:15] == "00"  # halt and enable
    assert client.read("S-0-0013")[1] in "01"
    assert client.read("S-0-0390") == "A101"  # the number that the display shows


def test_a_target_position_is_written_as_the_clients_do(client: Client) -> None:
    assert client.say(b"P-0-4006,7,W,>\r\n") == "P-0-4006,7,W,>\r\n?"
    answer = client.say(b"100.5\r\n")
    assert float(answer.split("\r")[0]) == 100.5
    assert answer.endswith("?")
    assert client.say(b"<\r\n") == "<\r\nE21:>"
    assert "E21" in client.say(b"<\r\n")  # one of them sends it twice
    assert client.say(b"P-0-4006,7,R\r").replace("\r", "").split("\n")[1] == "100.5000"


def test_an_error_is_cleared_as_the_clients_do(client: Client) -> None:
    for line in (b"S-0-0099,3,r", b"S-0-0099,7,w,11b", b"S-0-0099,1,w,0", b"S-0-0099,7,w,0b"):
        answer = client.say(line + b"\r")
        assert answer.startswith(line.decode())
        assert answer.endswith("E21:>")
        assert "#" not in answer


def test_a_list_is_written_as_the_manual_has_it() -> None:
    """MPH-02, p. 10-91: S-0-0328, here a list of ours."""
    client = Client()
    client.say(b"BCD:1\r")
    said = [client.say(line + b"\r") for line in (b"P-0-4006,7,w,>", b"1", b"2", b"<", b"P-0-4006,7,r")]
    assert said[:4] == ["P-0-4006,7,w,>\r\n?", "1\r\n?", "2\r\n?", "<\r\nE01:>"]
    assert said[4].split("\r\n")[1:5] == ["1.0000", "2.0000", "180.0000", "270.0000"], "a list of fixed length"


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("X-0-0051,7,r", 0x9002),
        ("S-8-0051,7,r", 0x9003),
        ("hello", 0x9004),
        ("S-0-0051,8,r", 0x9005),
        ("S-0-0051,7,x", 0x9006),
        ("S-0-0091,7,w,fast", 0x9007),
        ("S-0-3000,7,r", 0x1001),
        ("S-0-0051,7,w,1", 0x7004),
        ("S-0-0091,7,w,3001", 0x7007),
    ],
)
def test_errors(client: Client, line: str, code: int) -> None:
    """MPH-02, fig. 10-51; the last ones are those of parameter services."""
    assert client.say(line.encode() + b"\r") == f"{line}\r\n#{code:04X}\r\nE21:>"


def test_telegrams_and_lines_take_turns(client: Client) -> None:
    command = build(0x10, 16, 21, bytes.fromhex("3C 15 00 01 00"))
    assert client.read("S-0-0001") == "2000"
    assert client.say(command)[0] == "\x02"
    assert client.read("S-0-0001") == "2000"


@given(
    st.lists(st.one_of(st.binary(max_size=30), st.sampled_from([b"BCD:21\r", b"P-0-4006,7,W,>\r", b"<\r"])), max_size=9)
)
def test_any_characters_are_heard(pieces: list[bytes]) -> None:
    client = Client()
    for piece in pieces:
        client.bus.hear(piece, client.now_ns)


def test_the_scenario_speaks_both() -> None:
    played = load("ascii")
    sent = [one.sent for one in played.play(played.settings, Playing(cycles=1))]
    assert sent[:2] == [b"BCD:21\r\n", b"E21:>"]
    assert any(one[:1] == b"\x02" for one in sent)
