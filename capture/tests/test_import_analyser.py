# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters out of what logic analysers export.

The rows of sigrok are what sigrok-cli 0.7.2 (libsigrokdecode 0.5.3) printed of a signal made for this: 1 MHz, 9600 Bd
8E1, on TX 02 FA 03 from sample 1000 on, on RX 02 from 9438 on, 41 with a wrong parity bit, 42 without a stop bit, 43,
a break of 14 bits, 55. Those of Saleae follow the source of its analyser and its documentation.
"""

from __future__ import annotations

import subprocess
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from zipfile import ZipFile

import pytest
from imported import Imported, run
from sampled_wire import Sent, needs_sigrok, sampled

from sistap.commands.imports.formats import opened
from sistap.commands.imports.source import Stated
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.record import Framing, Type
from sistap.tap.terminal.exits import Refusal

CHARACTER_MS = 11 / 9.6
TO_STOP_MS = 10.5 / 9.6  # from the start bit to the middle of the stop bit, 8E1
BAD, BREAK, LOST = Flag.CHARACTER_ERROR, Flag.BREAK, Flag.LOST_BEFORE

SIGROK = """\
1104-1938 uart-1: tx-data: "02"
2250-3084 uart-1: tx-data: "FA"
3396-4230 uart-1: tx-data: "03"
9542-10376 uart-1: rx-data: "02"
10687-11521 uart-1: rx-data: "41"
11521-11626 uart-1: rx-parity-err: "Parity error" "Parity err" "PE"
11833-12667 uart-1: rx-data: "42"
12771-12876 uart-1: rx-warnings: "Frame error" "Frame err" "FE"
13083-13917 uart-1: rx-data: "43"
14229-15063 uart-1: rx-data: "00"
15167-15272 uart-1: rx-warnings: "Frame error" "Frame err" "FE"
14125-15583 uart-1: rx-break: "Break condition" "Break" "Brk" "B"
15791-16625 uart-1: rx-data: "55"
"""
# sigrok-cli without -l 4 and with -A uart=rx-data.
SIGROK_PLAIN = """\
9542-10376 uart-1: 02
10687-11521 uart-1: 41
11521-11626 uart-1: Parity error
"""
# PulseView puts its names of classes, or of rows, and sorts by the first sample.
PULSEVIEW = """\
9542-10376 UART: RX data: 02
9542-9647 UART: RX data bits: 0
11521-11626 UART: RX parity error bits: Parity error
10687-11521 UART: RX data: 41
14125-15583 UART: RX break: Break condition
14229-15063 UART: RX data: 00
1104-1938 UART: TX data: 02
9542-10376 UART: RX packets: 02
"""
LOGIC_2 = """\
name,type,start_time,duration,data,error
"Async Serial","data",0.001,0.00109375,0x02,
"Async Serial","data",0.002145833,0.00109375,0xFA,"parity"
"I2C","start",0.002,0.001,,
"Async Serial [1]","data",0.01,0.00109375,0x03,"framing"
"""
LOGIC_1 = """\
Time [s],Value,Parity Error,Framing Error
0.001000000000000,0x02,,
0.002145833000000,0xFA,Error,
0.010000000000000,0x03,,Error
"""
LOGIC_1_ALL = """\
Time [s], Analyzer Name, Decoded Protocol Result
0.001000000000000,Async Serial,0x02
0.002145833000000,Async Serial,0xFA (parity error)
0.010000000000000,Async Serial - 1,0x03 (framing error & parity error)
"""


def imported(folder: Path, text: str, *options: str) -> Imported:
    source = folder / "export"
    source.write_text(text)
    return run(source, "--baud", "9600", *options)


def rows(done: Imported) -> list[tuple[int, int, int]]:
    """Line, value and errors of each character, the first line first."""
    return sorted(
        (
            (record.line, value, flag & Flag.FROM_READER)
            for record in done.records
            for value, flag in zip(record.data, record.flags, strict=True)
        ),
        key=lambda row: row[0],
    )


def times_ms(done: Imported) -> list[float]:
    """When each character came, line by line."""
    times = []
    for record in sorted(done.records, key=lambda record: record.line):
        time_ns = record.time_ns
        for interval_ns in [0, *record.intervals[1:]]:
            time_ns += interval_ns
            times.append(time_ns / 1e6)
    return times


RECEIVED = [(1, 0x02, 0), (1, 0x41, BAD), (1, 0x42, BAD), (1, 0x43, 0), (1, 0x00, BREAK), (1, 0x55, 0)]
SENT = [(2, 0x02, 0), (2, 0xFA, 0), (2, 0x03, 0)]


def test_sigrok(tmp_path: Path) -> None:
    """Data end at bit 9 after the start; the middle of the stop bit is 1.5 bits later: 156.25 samples of 1 us."""
    done = imported(tmp_path, SIGROK, "--samplerate", "1000000")
    assert done.code == 0
    assert rows(done) == RECEIVED + SENT
    ends = [10376, 11521, 12667, 13917, 15063, 16625, 1938, 3084, 4230]
    assert times_ms(done) == pytest.approx([(end + 156.25) / 1000 for end in ends], abs=1e-5)
    assert {record.uncertainty_ns for record in done.records} == {1000}


def test_sigrok_without_directions(tmp_path: Path) -> None:
    done = imported(tmp_path, SIGROK_PLAIN, "--samplerate", "1000000")
    assert rows(done) == [(0, 0x02, 0), (0, 0x41, BAD)]


@pytest.mark.parametrize("quoted", [False, True])
@pytest.mark.parametrize("names", ["classes", "rows"])
def test_pulseview(tmp_path: Path, names: str, quoted: bool) -> None:
    text = PULSEVIEW
    if names == "rows":
        text = text.replace("RX data:", "RX:").replace("TX data:", "TX:").replace("RX parity error bits", "RX")
        text = text.replace("RX data bits", "RX bits")
    if quoted:
        text = "".join(f'{line.rpartition(": ")[0]}: "{line.rpartition(": ")[2]}"\n' for line in text.splitlines())
    done = imported(tmp_path, text, "--samplerate", "1000000")
    assert rows(done) == [(1, 0x02, 0), (1, 0x41, BAD), (1, 0x00, BREAK), (2, 0x02, 0)]


def test_without_parity_an_error_is_not_the_next_characters(tmp_path: Path) -> None:
    """8N1 back to back, 104.17 samples a bit: the stop bit that is missing begins where the data end."""
    text = "1104-1938 uart-1: 02\n1938-2043 uart-1: Frame error\n2146-2980 uart-1: 03\n"
    done = imported(tmp_path, text, "--samplerate", "1000000", "--format", "8N1")
    assert rows(done) == [(0, 0x02, BAD), (0, 0x03, 0)]


def test_a_decoder_with_wrong_settings(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    text = LOGIC_1.splitlines()[0] + "\n" + "".join(f"{place / 100},0x{place:02X},Error,\n" for place in range(9))
    assert imported(tmp_path, text).code == 0
    assert "most characters are faulty: set the decoder to the format of the line" in capfd.readouterr().err


def test_sigrok_counts_samples(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert imported(tmp_path, SIGROK).code == 2
    assert "add --samplerate HZ" in capfd.readouterr().err


@pytest.mark.parametrize("text", [LOGIC_2, LOGIC_1_ALL])
def test_saleae_with_two_analysers(tmp_path: Path, text: str) -> None:
    done = imported(tmp_path, text)
    assert rows(done) == [(1, 0x02, 0), (1, 0xFA, BAD), (2, 0x03, BAD)]
    assert times_ms(done) == pytest.approx([1 + TO_STOP_MS, 1 + CHARACTER_MS + TO_STOP_MS, 10 + TO_STOP_MS], abs=1e-5)


RATE = 1_000_000


def session(folder: Path, *lines: list[Sent]) -> Path:
    """Let sigrok-cli save samples: line n is channel n, counted from 0."""
    raw, saved = folder / "samples.bin", folder / "x.sr"
    raw.write_bytes(sampled(lines, RATE, 40_000_000))
    form = f"binary:numchannels=8:samplerate={RATE}"
    subprocess.run(["sigrok-cli", "-i", raw, "-I", form, "-o", saved], check=True)
    return saved


def sent(data: str, begin_ms: float, settings: str = "8E1", baud: int = 9600) -> list[Sent]:
    line = LineSettings.parse(baud, settings)
    length_ns = Fraction(11 * 10**9, baud)
    begin_ns = Fraction(begin_ms) * 10**6
    return [Sent(begin_ns + place * length_ns, value, line) for place, value in enumerate(bytes.fromhex(data))]


COMMAND, REACTION = "02e30202000010030301", "02c30202101210030002"


@needs_sigrok
def test_a_session_of_sigrok(tmp_path: Path) -> None:
    """Both directions, the rate from the pulses, each time to a sample."""
    path = session(tmp_path, sent(COMMAND, 5), sent(REACTION, 25))
    done = run(path)
    assert done.code == 0
    assert [(record.line, record.data) for record in done.records if record.type == Type.FRAME] == [
        (1, bytes.fromhex(COMMAND)),
        (2, bytes.fromhex(REACTION)),
    ]
    assert {record.settings.baud for record in done.records} == {9600}
    assert times_ms(done)[::10] == pytest.approx([5, 25], abs=0.002)
    assert {record.uncertainty_ns for record in done.records} == {1000}


@needs_sigrok
def test_a_session_with_more_channels_asks_which(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = session(tmp_path, sent(COMMAND, 5), sent(REACTION, 25), sent(COMMAND, 28))
    assert run(path).code == 2
    said = "3 channels that can be lines of the bus (0, 1, 2): name those that are, such as --device 0 or --device 0,1"
    assert said in capfd.readouterr().err
    done = run(path, "--device", "0")
    assert [(record.line, record.data) for record in done.records if record.type == Type.FRAME] == [
        (0, bytes.fromhex(COMMAND))
    ]


@pytest.mark.parametrize(
    ("metadata", "why"),
    [
        ("", "does not say how many samples a second has"),
        ("[device 1]\nunitsize=x\n", "does not say how many samples a second has"),
        ("[device 1]\nunitsize=1\nprobe1=D0\n", "add --samplerate HZ"),
        ("[device 1]\nsamplerate=1 MHz\nunitsize=1\ntotal analog=1\n", "no samples of logic channels"),
        ("[device 1]\nsamplerate=1 MHz\nunitsize=1\nprobe1=D0\n", "no channel that changes"),
        ("[device 1]\nsamplerate=1 MHz\nunitsize=1\nprobe1=D0\nprobe2=D1\n", "no channel that changes"),
    ],
)
def test_a_session_without_a_bus(tmp_path: Path, capfd: pytest.CaptureFixture[str], metadata: str, why: str) -> None:
    with ZipFile(tmp_path / "x.sr", "w") as archive:
        for name, content in {"version": "2", "metadata": metadata, "logic-1-1": "\xff" * 99}.items():
            archive.writestr(name, content.encode("latin-1"))
    assert run(tmp_path / "x.sr").code == 2
    assert why in capfd.readouterr().err


def test_blocks_of_3964r(tmp_path: Path) -> None:
    said = bytes.fromhex("02 10 41 10 03 52 10")
    rows = "".join(f"{place / 1000},0x{value:02X},,\n" for place, value in enumerate(said))
    done = imported(
        tmp_path, "Time [s],Value,Parity Error,Framing Error\n" + rows, "--baud", "9600", "--framing", "3964r"
    )
    assert [(record.type, record.data.hex()) for record in done.records] == [
        (Type.FRAME, data) for data in ("02", "10", "41100352", "10")
    ]
    assert {record.framing for record in done.records} == {Framing.PROCEDURE_3964R}
    assert "blocks of procedure 3964R" in done.events[0]


def test_saleae_logic_1(tmp_path: Path) -> None:
    done = imported(tmp_path, LOGIC_1)
    assert rows(done) == [(0, 0x02, 0), (0, 0xFA, BAD), (0, 0x03, BAD)]
    assert times_ms(done) == pytest.approx([1 + TO_STOP_MS, 1 + CHARACTER_MS + TO_STOP_MS, 10 + TO_STOP_MS], abs=1e-5)


def test_without_a_sample_rate_a_sample_is_a_quarter_of_a_bit(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """1 / 38400 s; said in two digits, and never as less than it is."""
    assert imported(tmp_path, LOGIC_1).records[0].uncertainty_ns == 26042
    assert "can have come up to 0.027 ms earlier" in capfd.readouterr().err
    assert imported(tmp_path, LOGIC_1, "--samplerate", "12500000").records[0].uncertainty_ns == 80


def test_dates_of_logic_2(tmp_path: Path) -> None:
    """2023-11-14 22:13:20 UTC is 1,700,000,000 s."""
    text = LOGIC_2.splitlines()[0] + "\nAsync Serial,data,2023-11-14T23:13:20.123456789+01:00,0.001,0x02,\n"
    assert imported(tmp_path, text).records[0].time_ns == 1_700_000_000_124_456_789


def test_times_before_the_trigger(tmp_path: Path) -> None:
    """The first character, not the trigger, is then at 0."""
    text = LOGIC_1 + "-0.5,0x01,,\n"
    assert times_ms(imported(tmp_path, text))[:2] == pytest.approx([0, 501], abs=1e-5)


@pytest.mark.parametrize("value", ["2", "'2'", "A", " ", "0b0000 0010", "0x", "0x102", ""])
def test_values_that_are_not_hexadecimal(tmp_path: Path, capfd: pytest.CaptureFixture[str], value: str) -> None:
    """A `2` may be the character or the number: nothing is guessed."""
    assert imported(tmp_path, f"Time [s],Value,Parity Error,Framing Error\n0.001,{value},,\n").code == 2
    said = capfd.readouterr().err
    assert "line 2 cannot be read" in said
    assert "let the decoder show hexadecimal values, and export again" in said


@pytest.mark.parametrize("damage", ["0.002,", "0.002", "what,0x03,,", "1e9999,0x03,,", "0.002,0x0"])
def test_a_damaged_line_is_a_loss(tmp_path: Path, capfd: pytest.CaptureFixture[str], damage: str) -> None:
    done = imported(tmp_path, f"Time [s],Value,Parity Error,Framing Error\n0.001,0x02,,\n{damage}\n0.003,0x04,,\n")
    if damage == "0.002,0x0":
        assert rows(done) == [(0, 0x02, 0), (0, 0x00, 0), (0, 0x04, 0)]
        return
    assert rows(done) == [(0, 0x02, 0), (0, 0x04, LOST)]
    assert "line 3 cannot be read" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("text", "far"),
    [
        (SIGROK_PLAIN, "999999999999999999-999999999999999999 uart-1: 55"),
        (LOGIC_2, "Async Serial,data,9999-01-01T00:00:00,0.001,0x55,"),
    ],
)
def test_times_that_no_file_can_hold(tmp_path: Path, capfd: pytest.CaptureFixture[str], text: str, far: str) -> None:
    done = imported(tmp_path, text + far + "\n", "--samplerate", "1000")
    assert done.code == 0
    assert 0x55 not in [value for _, value, _ in rows(done)]
    assert "is left out" in capfd.readouterr().err


@pytest.mark.parametrize("text", [SIGROK, LOGIC_2, LOGIC_1, LOGIC_1_ALL])
def test_an_export_that_is_cut_anywhere(tmp_path: Path, text: str) -> None:
    """What comes before the line that is cut is there, or the file is refused."""
    source = tmp_path / "export"
    for length in range(text.index("\n") + 1, len(text)):
        source.write_text(text[:length])
        try:
            with ExitStack() as tools:
                found = [read.data[0] for read in opened(source, Stated(9600, samplerate=1_000_000), tools).reads()]
        except Refusal:
            found = []
        whole = text.rfind("\n", 0, length)
        assert len(found) >= text.count("0x", 0, whole) + text.count("data: ", 0, whole)


def test_more_than_two_lines(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert imported(tmp_path, LOGIC_2 + "third,data,0.02,0.001,0x04,\n").code == 2
    assert (
        "3 decoders (Async Serial, Async Serial [1], third): export one, or the two directions of one bus"
        in capfd.readouterr().err
    )
