# SPDX-License-Identifier: GPL-2.0-or-later
"""A replayed capture: every character, at its time; and files that are not captures."""

from __future__ import annotations

import os
import select
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from portable import terminals
from test_bus import BUS, TIMEOUT_S, drain, finish, listening_only_if_asked

from sisbus.replay import look, played
from sistap.dissected.captures.reading import records
from sistap.tap.files import pcapng
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records import record
from sistap.tap.records.record import Event, Record, Type
from sistap.tap.terminal.exits import NotCaptured

REPLAY = [sys.executable, "-m", "sistap", "replay"]
CAPTURE = [sys.executable, "-m", "sistap", "capture", "-q"]
LINE = LineSettings()
START_NS = 1_700_000_000_000_000_000
MS = 1_000_000


def write(file: Path, *found: Record, link_type: int = 252, name: str = "sertap") -> Path:
    blocks = [pcapng.section_header("a test", ""), pcapng.interface_description(pcapng.Interface(link_type, "x"))]
    blocks += [pcapng.enhanced_packet(0, one.time_ns, pcapng.upper_pdu(name, one.pack())) for one in found]
    file.write_bytes(b"".join(blocks))
    return file


def frame(time_ns: int, data: bytes, intervals: list[int], flags: bytes = b"", line: int = 0, u: int = 1000) -> Record:
    return Record(START_NS + time_ns, Type.FRAME, line, LINE, data, intervals, flags or bytes(len(data)), u)


@contextmanager
def running(*options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    process = subprocess.Popen([*REPLAY, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


def heard_again(file: Path, folder: Path) -> list[Record]:
    """Replay into a socket as fast as possible, and capture that."""
    again = folder / "again.pcapng"
    with running(str(file), "--listen", "127.0.0.1:0", "--fast") as (process, name):
        subprocess.run([*CAPTURE, "-i", name, "-w", str(again)], timeout=TIMEOUT_S, check=False, capture_output=True)
        assert finish(process)[0] == 0
    return with_characters(again)


def with_characters(file: Path) -> list[Record]:
    return [one for one in records(file) if one.type != Type.EVENT]


def times(one: Record) -> list[int]:
    return [one.time_ns + sum(one.intervals[1 : place + 1]) for place in range(len(one.data))]


# -- Character by character -----------------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize(
    "options",
    [
        ["demo"],
        ["noise"],
        ["noise", "--reads", "7", "--faults", "loss=0.01,break=0.01,parity=0.01"],
        ["late-reaction", "--format", "8N1", "--baud", "57600"],
    ],
)
def test_captured_again_it_is_the_same(tmp_path: Path, options: list[str]) -> None:
    file = tmp_path / "x.pcapng"
    subprocess.run([*BUS, *options, "-w", str(file)], check=True)
    first = with_characters(file)
    capture = tmp_path / "again.pcapng"
    tap = ["--baud", str(first[0].settings.baud), "--format", first[0].settings.format]
    with running(str(file), "--listen", "127.0.0.1:0", "--fast") as (process, name):
        subprocess.run([*CAPTURE, "-i", name, "-w", str(capture), *tap], check=False, capture_output=True)
        code, said = finish(process)
    assert (code, said.count("\n")) == (0, 1)
    assert f"{sum(len(one.data) for one in first)} characters at {first[0].settings}" in said
    again = with_characters(capture)
    step_ns = again[0].time_ns - first[0].time_ns
    assert [one._replace(time_ns=one.time_ns + step_ns) for one in first] == again


def test_two_lines_in_the_order_of_their_times(tmp_path: Path) -> None:
    file = write(
        tmp_path / "x",
        frame(0, b"abc", [0, 5 * MS, 5 * MS], bytes([Flag.INTERVAL_UNKNOWN, 0, 0]), 1),
        frame(3 * MS, b"xyz", [0, 5 * MS, 5 * MS], bytes([Flag.INTERVAL_UNKNOWN, 0, Flag.BREAK]), 2),
        frame(30 * MS, b"d", [20 * MS], b"", 1),
    )
    sent = list(played(file, look(file)))
    first_ns = sent[0].time_ns
    assert first_ns == LINE.character_ns  # time 0 is when it began to be sent
    assert [(one.time_ns - first_ns, one.line, one.sent) for one in sent] == [
        (0, 1, b"a"),
        (3 * MS, 2, b"x"),
        (5 * MS, 1, b"b"),
        (8 * MS, 2, b"y"),
        (10 * MS, 1, b"c"),
        (13 * MS, 2, b"z"),
        (30 * MS, 1, b"d"),
    ]
    assert [character.flags for one in sent for character in one.characters] == [0, 0, 0, 0, 0, Flag.BREAK, 0]
    again = heard_again(file, tmp_path)
    assert {line: b"".join(one.data for one in again if one.line == line) for line in (1, 2)} == {1: b"abcd", 2: b"xyz"}


def test_what_came_in_one_read_goes_out_together_also_over_two_records(tmp_path: Path) -> None:
    same = Flag.SAME_READ
    file = write(
        tmp_path / "x",
        frame(0, b"abc", [0, 0, 7 * MS], bytes([0, same, 0]), u=3000),
        frame(7 * MS, b"de", [0, 9 * MS], bytes([same, 0]), u=2000),
    )
    sent = [(one.sent, one.uncertainty_ns) for one in played(file, look(file))]
    assert sent == [(b"ab", 3000), (b"cd", 2000), (b"e", 2000)]


def test_an_interval_that_does_not_fit_is_that_of_the_time_stamps(tmp_path: Path) -> None:
    hour_ns = 3600 * 1000 * MS
    saturated = frame(hour_ns, b"b", [record.INTERVAL_MAX], bytes([Flag.INTERVAL_SATURATED]))
    file = write(tmp_path / "x", frame(0, b"a", [0]), saturated)
    one, other = played(file, look(file))
    assert other.time_ns - one.time_ns == hour_ns


def test_events_are_passed_over_and_an_unknown_rate_is_that_after_power_on(tmp_path: Path) -> None:
    unknown = frame(0, b"a", [0])._replace(settings=LINE._replace(baud=0))
    file = write(tmp_path / "x", record.event(START_NS, 0, LINE, Event.MARKER, "here"), unknown)
    (one,) = played(file, look(file))
    assert one.settings == LINE


# -- At terminals and ports -------------------------------------------------------------------------------------------


def errors_and_values(file: Path) -> tuple[Path, bytes]:
    values = bytes(range(256))
    flags = bytes([Flag.CHARACTER_ERROR, Flag.BREAK, *bytes(254)])
    return write(file, frame(0, values, [0] + [10_000] * 255, flags)), values


@terminals
def test_a_pseudo_terminal_gets_the_values_and_a_line_tells_of_the_errors(tmp_path: Path) -> None:
    file, values = errors_and_values(tmp_path / "x")
    with running(str(file)) as (process, name):
        terminal = os.open(name, os.O_RDWR | os.O_NOCTTY)
        heard = drain(terminal)
        os.close(terminal)
        code, said = finish(process)
    assert heard == values
    assert code == 0
    assert said.splitlines()[-1] == "sistap replay: 2 line errors were left out: only a socket carries them (--listen)"


@terminals
def test_a_port_gets_the_values_with_transmit_only(tmp_path: Path) -> None:
    file, values = errors_and_values(tmp_path / "x")
    ours, theirs = os.openpty()
    try:
        port = os.ttyname(theirs)
        refused = subprocess.run([*REPLAY, str(file), "--port", port], capture_output=True, text=True, check=False)
        assert refused.returncode == 2
        assert "add --transmit" in refused.stderr
        assert not select.select([ours], [], [], 0)[0]
        done = subprocess.run([*REPLAY, str(file), "--port", port, "--transmit"], capture_output=True, check=False)
        assert done.returncode == 0
        heard = b""
        while select.select([ours], [], [], 0)[0]:
            heard += os.read(ours, 4096)
    finally:
        os.close(ours)
        os.close(theirs)
    assert heard == values


# -- Files ----------------------------------------------------------------------------------------------------------


def test_a_capture_that_was_cut_off_is_played_up_to_there(tmp_path: Path) -> None:
    file = write(tmp_path / "x", frame(0, b"abc", [0, 1, 1]), frame(MS, b"def", [1, 1, 1]))
    whole = file.read_bytes()
    file.write_bytes(whole[:-5])
    assert [one.data for one in records(file)] == [b"abc"]


def test_other_byte_order_and_microseconds(tmp_path: Path) -> None:
    """As another program may write it: big-endian, no if_tsresol."""
    one = frame(5000, b"abc", [0, 1, 1])
    packet = pcapng.upper_pdu("sertap", one.pack())

    def block(kind: int, body: bytes) -> bytes:
        body += bytes(-len(body) % 4)
        return struct.pack(">II", kind, 12 + len(body)) + body + struct.pack(">I", 12 + len(body))

    us = one.time_ns // 1000
    file = tmp_path / "x"
    file.write_bytes(
        block(0x0A0D0D0A, struct.pack(">IHHq", 0x1A2B3C4D, 1, 0, -1))
        + block(1, struct.pack(">HHI", 252, 0, 0))
        + block(6, struct.pack(">IIIII", 0, us >> 32, us & 0xFFFFFFFF, len(packet), len(packet)) + packet)
    )
    assert list(records(file)) == [one._replace(intervals=(0, 1, 1))]


EVENT = record.event(START_NS, 0, LINE, Event.MARKER, "here")
DAMAGED = frame(0, b"abc", [0, 1, 1])


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"", "has no records of sistap"),
        (b"hello, this is a text", "is not a pcapng file: open it in Wireshark and save it as pcapng"),
        (bytes.fromhex("D4C3B2A1") + bytes(20), "is not a pcapng file"),  # pcap
        (
            pcapng.section_header("", "") + struct.pack("<II", 6, 13) + bytes(5),
            "is damaged: a block says it has 13 bytes",
        ),
        (pcapng.section_header("", "") + struct.pack("<II", 6, 1 << 30), "is damaged: a block says"),
        (pcapng.section_header("", "") + struct.pack("<IIII", 6, 16, 0, 16), "is damaged: a block of kind 6 has only"),
    ],
)
def test_files_that_are_no_capture(tmp_path: Path, content: bytes, line: str) -> None:
    file = tmp_path / "x"
    file.write_bytes(content)
    result = subprocess.run([*REPLAY, str(file)], capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith(f"sistap replay: {file} {line}")
    assert result.stderr.count("\n") == 1


SECTION, INTERFACE, PACKET = 0x0A0D0D0A, 1, 6
FIXED = {SECTION: 16, INTERFACE: 8, PACKET: 20}  # bytes, draft-ietf-opsawg-pcapng


def block(kind: int, body: bytes) -> bytes:
    length = struct.pack("<I", 12 + len(body))
    return struct.pack("<I", kind) + length + body + length


@pytest.mark.parametrize("kind", FIXED)
def test_a_block_that_is_shorter_than_its_fixed_part(tmp_path: Path, kind: int) -> None:
    """All lengths that one can have."""
    head = struct.pack("<I", 0x1A2B3C4D) if kind == SECTION else b""  # says which byte order it is
    whole = pcapng.section_header("", "") + pcapng.interface_description(pcapng.Interface(252, "x"))
    before = b"" if kind == SECTION else pcapng.section_header("", "") if kind == INTERFACE else whole
    for size in range(len(head), FIXED[kind], 4):
        file = tmp_path / "x"
        file.write_bytes(before + block(kind, head.ljust(size, b"\0")) + whole)
        with pytest.raises(NotCaptured, match=f"x is damaged: a block of kind {kind} has only {size} bytes; open and"):
            look(file)


def test_an_option_without_its_value_is_passed_over(tmp_path: Path) -> None:
    """The resolution of time stamps, at the end of its block."""
    file = write(tmp_path / "x", DAMAGED)
    content = file.read_bytes()
    described = pcapng.interface_description(pcapng.Interface(252, "x"))
    cut = block(INTERFACE, struct.pack("<HHI", 252, 0, 0) + struct.pack("<HH", 9, 1))
    assert described in content
    file.write_bytes(content.replace(described, cut))
    (found,) = records(file)
    assert found.data == DAMAGED.data


def test_captures_without_what_is_to_be_played(tmp_path: Path) -> None:
    for file, line in (
        (write(tmp_path / "rtac", DAMAGED, link_type=250), "without --link-type"),
        (write(tmp_path / "sis", DAMAGED, name="sis"), "has no records of sistap"),
        (write(tmp_path / "events", EVENT), "only events: nothing to play"),
    ):
        with pytest.raises(NotCaptured, match=line):
            look(file)


def test_a_record_that_is_damaged(tmp_path: Path) -> None:
    file = write(tmp_path / "x", DAMAGED)
    content = bytearray(file.read_bytes())
    content[content.index(b"sertap") + 12] = 2  # the version
    file.write_bytes(content)
    with pytest.raises(NotCaptured, match="record version 2 is not 1"):
        look(file)


@pytest.mark.parametrize(
    ("options", "code", "cure"),
    [
        (["/nowhere/x"], 2, f"cannot read {Path('/nowhere/x')}: No such file or directory; name a capture file"),
        (["/"], 2, f"cannot read {Path('/')}: Is a directory"),
        pytest.param(["x", "--fast"], 2, "--fast needs --listen", marks=listening_only_if_asked),
        (["x", "--transmit"], 2, "name it with --port"),
    ],
)
def test_wrong_options_get_one_line_with_the_cure(options: list[str], code: int, cure: str) -> None:
    result = subprocess.run([*REPLAY, *options], capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert (result.returncode, result.stdout) == (code, "")
    assert result.stderr.count("\n") == 1
    assert cure in result.stderr
