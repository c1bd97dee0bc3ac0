# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap import --dissector`: a table of messages becomes packets for a dissector, or one line names the fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from sistap import cli
from sistap.commands.imports import messages
from sistap.dissected.captures.reading import packets
from sistap.tap.files import pcapng
from sistap.tap.files.pcapng import PacketFlags

TABLE = """\
time,direction,bytes
0.125,M,0082 000C 0002
# a remark, and an empty line

1.0000000019,s,"01 82 00"
"""


@pytest.fixture
def table(tmp_path: Path) -> Path:
    source = tmp_path / "table.csv"
    source.write_text(TABLE)
    return source


def imported(table: Path, *options: str) -> tuple[int, Path]:
    out = table.with_name("out.pcapng")
    return cli.main(["import", str(table), "-w", str(out), *options]), out


@pytest.mark.parametrize("dissector", messages.DISSECTORS)
def test_packets_by_name(table: Path, dissector: str, capfd: pytest.CaptureFixture[str]) -> None:
    code, out = imported(table, "--dissector", dissector)
    assert code == 0
    assert [(packet.link_type, packet.time_ns, packet.data) for packet in packets(out)] == [
        (252, 125_000_000, pcapng.upper_pdu(dissector, bytes.fromhex("0082000C0002"))),
        (252, 1_000_000_002, pcapng.upper_pdu(dissector, bytes.fromhex("018200"))),
    ]
    assert capfd.readouterr().err.startswith(f"sistap: 2 messages for {dissector} written to ")


def test_who_sent_is_in_the_flags(table: Path) -> None:
    assert [message.sender for message in messages.read(table)] == [PacketFlags.OUTBOUND, PacketFlags.INBOUND]


def test_semicolons_and_a_decimal_comma(table: Path) -> None:
    table.write_text("0,5;M;5E 70 02\r\n")
    assert messages.read(table) == [(500_000_000, PacketFlags.OUTBOUND, b"\x5e\x70\x02")]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0.1,M", "there are 2 columns, not 3; a line is time,M or S,bytes"),
        ("0.1,M,00,01", "there are 4 columns, not 3"),
        ("-1,M,00", "'-1' is no time; write seconds, such as 0.125"),
        ("1e3,M,00", "'1e3' is no time"),
        ("9999999999,M,00", "is no time"),
        ("0.1,X,00", "'X' is no direction; write M for the master, S for the slave"),
        ("0.1,M,0", "'0' is no row of bytes; write two hexadecimal digits a byte"),
        ("0.1,M," + "g" * 99, f"'{'g' * 24}...' is no row of bytes"),
        ("0.1,M,", "there are 0 bytes; a message has 1 to 65535"),
        pytest.param("0.1,M," + "00" * 65536, "there are 65536 bytes", id="long"),
    ],
)
def test_the_line_that_is_wrong(table: Path, line: str, words: str, capfd: pytest.CaptureFixture[str]) -> None:
    table.write_text("0,M,00\n" + line + "\n")
    code, out = imported(table, "--dissector", "synaxpcp")
    assert code == 2
    assert not out.exists()
    error = capfd.readouterr().err
    assert error.startswith(f"sistap: {table}:2: ")
    assert words in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("content", ["", "time,direction,bytes\n", "# nothing\n"])
def test_no_messages(table: Path, content: str, capfd: pytest.CaptureFixture[str]) -> None:
    table.write_text(content)
    assert imported(table, "--dissector", "synaxpcp")[0] == 2
    assert "has no messages in it: a line is" in capfd.readouterr().err


def test_no_file(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert imported(tmp_path / "missing", "--dissector", "synaxpcp")[0] == 2
    assert "cannot read" in capfd.readouterr().err


def test_options_of_a_line(table: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert imported(table, "--dissector", "synaxpcp", "--baud", "9600")[0] == 2
    assert "leave out --baud" in capfd.readouterr().err


def test_another_dissector(table: Path) -> None:
    with pytest.raises(SystemExit) as ended:
        imported(table, "--dissector", "tcp")
    assert ended.value.code == 2


def test_over_the_table_itself(table: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["import", str(table), "-w", str(table), "--dissector", "synaxpcp"]) == 2
    assert "is FILE itself" in capfd.readouterr().err
    assert table.read_text() == TABLE
