# SPDX-License-Identifier: GPL-2.0-or-later
"""What `sistap import` finds in the samples of a logic analyser: rate, format, polarity, and the channels of the bus.

The waveforms are rendered here, bit by bit; what must come out are the bytes that went in.
"""

from __future__ import annotations

import random
import struct
from array import array
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile

import pytest
from imported import run
from sampled_wire import NS, Sent, edges

from sistap.commands.imports import session
from sistap.commands.imports import vcd as vcd_reader
from sistap.commands.imports.formats import known
from sistap.commands.imports.source import Stated
from sistap.commands.imports.wave import HEAD, Wave, opened
from sistap.tap.analyser.finding import BAUDS, Trace, find
from sistap.tap.common.packed import unpack
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Type
from sistap.tap.terminal.exits import Refusal

MHZ = 1_000_000
TELEGRAMS = [bytes.fromhex(text) for text in ("02D7030300031003040700", "026C000000920000", "02560202109200000002")]
SENT = b"".join(TELEGRAMS)
NOTHING = Stated()


def bursts(settings: LineSettings, telegrams: Sequence[bytes] = TELEGRAMS, begin_ms: float = 1) -> list[Sent]:
    """Telegrams with a pause of 30 bits between two of them, and of a bit between two characters here and there."""
    bit_ns = Fraction(NS, settings.baud)
    chance = random.Random(1)
    time_ns = Fraction(begin_ms) * MHZ
    characters = []
    for telegram in telegrams:
        time_ns += 30 * bit_ns
        for value in telegram:
            time_ns += settings.character_ns + chance.choice((0, 0, 1)) * bit_ns
            characters.append(Sent(time_ns, value, settings))
    return characters


def trace(
    characters: Iterable[Sent], rate: int, *, late_ns: int = 0, inverted: bool = False, glitches: Iterable[int] = ()
) -> array[int]:
    """Return the edges of a channel, in samples. Falling edges are late, if `late_ns` is more than 0, else the others.

    A glitch is one sample of the other level.
    """
    times = [
        (time_ns + (abs(late_ns) if (level == 0) == (late_ns > 0) else 0), level)
        for time_ns, level in edges(characters)
    ]
    levels = [1 ^ inverted]
    for time_ns, level in times:
        sample = int(-(-time_ns * rate // NS))
        del levels[sample + 1 :]
        levels += [levels[-1]] * (sample - len(levels) + 1)
        levels[sample] = level ^ inverted
    for glitch in glitches:
        levels[glitch] ^= 1
    return of_levels(levels)


def of_levels(levels: Sequence[int]) -> array[int]:
    """Return where samples differ from the one before; before the first one, a channel counts as low."""
    return array("q", [place for place, level in enumerate(levels) if level != (levels[place - 1] if place else 0)])


def wave(rate: int, **channels: array[int]) -> Wave:
    return Wave(rate, channels, max(edge for channel in channels.values() for edge in channel[-1:]) + rate // 10, rate)


class Found(NamedTuple):
    lines: list[bytes]  # the bytes of each
    said: str


def found(recording: Wave, told: Stated = NOTHING) -> Found:
    source = opened(Path("x"), recording, told)
    reads = list(source.reads())
    lines = [
        b"".join(read.data for read in reads if read.line == line) for line in sorted({read.line for read in reads})
    ]
    assert not any(read.flags[0] for read in reads), reads
    return Found(lines, f"{source.settings}, {source.settings_from}")


FORMATS = [(text, inverted) for text in ("8E1", "8N1", "8O1") for inverted in (False, True)]


@pytest.mark.parametrize(
    ("baud", "text", "inverted"),
    [  # the quick tests try one format at each rate
        pytest.param(baud, *one, marks=() if number == place % len(FORMATS) else pytest.mark.thorough)
        for place, baud in enumerate(BAUDS)
        for number, one in enumerate(FORMATS)
    ],
)
def test_rate_format_and_polarity_are_found(baud: int, text: str, inverted: bool) -> None:
    rate = next(rate for rate in (20_000, 200_000, 2 * MHZ, 24 * MHZ) if rate >= 16 * baud)
    channel = trace(bursts(LineSettings.parse(baud, text)), rate, inverted=inverted)
    polarity = ", idle low (inverted)" if inverted else ""
    assert found(wave(rate, D0=channel)) == ([SENT], f"{baud} Bd {text}, found by the pulses; channel D0{polarity}")


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("text", ["8E1", "8N1"])
@pytest.mark.parametrize(
    ("baud", "rate", "late_ns"),
    [
        *((115200, 24 * MHZ, late_ns) for late_ns in (300, 400, 500, 600, -400, -500, 1500)),
        *((115200, 2 * MHZ, late_ns) for late_ns in (500, -500)),
        *((19200, 500_000, late_ns) for late_ns in (2000, -2000, 8000)),
        (187500, 24 * MHZ, 500),
    ],
)
def test_edges_of_one_direction_may_be_late(baud: int, rate: int, late_ns: int, text: str, inverted: bool) -> None:
    channel = trace(bursts(LineSettings.parse(baud, text)), rate, late_ns=late_ns, inverted=inverted)
    assert found(wave(rate, D0=channel)).lines == [SENT]


@pytest.mark.parametrize("late_ns", [0, 600, -600])
def test_a_live_capture_finds_it_too(late_ns: int) -> None:
    """Its newest edges begin anywhere."""
    settings = LineSettings.parse(115200, "8N1")
    channel = trace(bursts(settings, TELEGRAMS * 5), 4 * MHZ, late_ns=late_ns)
    reading = find(Trace(channel[41:], is_high=False, end=channel[-1] + 4000), 4 * MHZ)
    assert reading
    assert reading.settings == settings


@pytest.mark.parametrize("seed", range(5))
def test_noise_between_the_characters(seed: int) -> None:
    settings = LineSettings(9600)
    characters = bursts(settings, TELEGRAMS * 2)
    chance = random.Random(seed)
    firsts = [characters[at] for at in (0, 11, 19, 29, 40, 48)]
    # In the pause before each telegram: 30 bits of 104 samples.
    glitches = [
        int((first.time_ns - settings.character_ns) * MHZ // NS) - chance.randrange(200, 2500)
        for first in firsts
        for _ in range(5)
    ]
    assert found(wave(MHZ, D0=trace(characters, MHZ, glitches=glitches))).lines == [SENT * 2]


def enable(characters: Sequence[Sent], rate: int, high: int = 1) -> array[int]:
    """The driver enable of a station that sends every second telegram."""
    levels = [1 - high] * int(characters[-1].time_ns * rate // NS + rate)
    begin = 0
    for number, telegram in enumerate(TELEGRAMS):
        first, last = characters[begin], characters[begin + len(telegram) - 1]
        begin += len(telegram)
        if number % 2 == 0:
            sends = slice(
                *(int(time_ns * rate // NS) for time_ns in (first.time_ns - 1_300_000, last.time_ns + 100_000))
            )
            levels[sends] = [high] * (sends.stop - sends.start)
    return of_levels(levels)


@pytest.mark.parametrize("high", [0, 1])
@pytest.mark.parametrize("inverted", [False, True])
def test_a_driver_enable_is_no_direction(inverted: bool, high: int) -> None:
    characters = bursts(LineSettings(9600))
    recording = wave(MHZ, RO=trace(characters, MHZ, inverted=inverted), DE=enable(characters, MHZ, high))
    polarity = ", idle low (inverted)" if inverted else ""
    said = f"9600 Bd 8E1, found by the pulses; channel RO{polarity}; channel DE is a driver enable"
    assert found(recording) == ([SENT], said)


def test_two_directions_one_of_them_inverted() -> None:
    settings = LineSettings(19200)
    recording = wave(
        2 * MHZ,
        TX=trace(bursts(settings, TELEGRAMS[:2]), 2 * MHZ),
        RX=trace(bursts(settings, TELEGRAMS[2:], begin_ms=40), 2 * MHZ, inverted=True),
    )
    lines, said = found(recording)
    assert lines == [TELEGRAMS[2], b"".join(TELEGRAMS[:2])]  # in the order of their names
    assert said == "19200 Bd 8E1, found by the pulses; channel TX; channel RX, idle low (inverted)"


def test_a_direction_that_begins_later_is_no_driver_enable() -> None:
    settings = LineSettings(9600)
    recording = wave(
        MHZ, A=trace(bursts(settings), MHZ), B=trace(bursts(settings, [TELEGRAMS[1][:2]], begin_ms=100), MHZ)
    )
    said = "9600 Bd 8E1, found by the pulses; channel A; channel B has few characters"
    assert found(recording) == ([SENT], said)


def test_the_same_line_twice_is_one_direction() -> None:
    """Both wires of a pair, or what a station sends beside what its receiver hears."""
    characters = bursts(LineSettings(9600))
    recording = wave(
        MHZ,
        A=trace(characters, MHZ),
        B=trace(characters, MHZ, inverted=True),
        DI=trace(characters[:11], MHZ),
    )
    said = "9600 Bd 8E1, found by the pulses; channel A; channel B is a copy of A; channel DI is a copy of A"
    assert found(recording) == ([SENT], said)


def clock(period: int, high: int, count: int, pause: int = 0, burst: int = 8) -> array[int]:
    """Pulses, in bursts with a pause between them."""
    levels = [0] * 1000
    for number in range(count):
        levels += [1] * high + [0] * (period - high + (0 if (number + 1) % burst else pause))
    return of_levels(levels)


def shifted_out(values: bytes, bit: int, pause: int = 0) -> array[int]:
    """Data of SPI: each bit lasts as long as a period of the clock."""
    levels = [0] * 1000
    for value in values:
        levels += [value >> place & 1 for place in range(7, -1, -1) for _ in range(bit)] + [0] * pause
    return of_levels(levels)


def i2c(values: bytes, quarter: int) -> dict[str, array[int]]:
    """A transfer: a start, bytes with acknowledgements, a stop. SDA changes while SCL is low."""
    scl, sda = [1] * 1000, [1] * 1000
    for piece in (values[at : at + 4] for at in range(0, len(values), 4)):
        scl += [1] * quarter
        sda += [0] * quarter
        for bit in (value >> place & 1 if place >= 0 else 0 for value in piece for place in range(7, -2, -1)):
            scl += [0] * 2 * quarter + [1] * 2 * quarter
            sda += [sda[-1]] * quarter + [bit] * 3 * quarter
        scl += [0] * quarter + [1] * 90 * quarter
        sda += [0] * 2 * quarter + [1] * 89 * quarter
    return {"SCL": of_levels(scl), "SDA": of_levels(sda)}


NOISE = random.Random(3).randbytes(400)
OTHERS = {
    "a clock": {"D0": clock(100, 50, 500)},
    "a clock in bursts": {"CLK": clock(8, 4, 800, pause=200)},
    "pulse width modulation": {
        "PWM": array("q", [at for n in range(400) for at in (n * 1000, n * 1000 + 100 + n * 2)]),
    },
    "I2C at 100 kHz": i2c(NOISE, 10),
    "I2C at 10 kHz": i2c(NOISE[:80], 100),
    "SPI at 250 kHz": {"CLK": clock(16, 8, 3200), "MOSI": shifted_out(NOISE, 16)},
    "SPI at 38.4 kHz": {"CLK": clock(104, 52, 800, pause=52), "MOSI": shifted_out(NOISE[:100], 104, 52)},
    "noise": {"D0": array("q", sorted(random.Random(2).sample(range(1_000_000), 2000)))},
    "a switch": {"D0": array("q", [100_000, 300_000, 300_020, 300_050, 900_000])},
}


@pytest.mark.parametrize("name", OTHERS)
def test_what_is_no_serial_line_is_refused(name: str) -> None:
    with pytest.raises(Refusal, match="no channel with characters at a usual rate") as refused:
        found(wave(4 * MHZ, **OTHERS[name]))
    clocks = [channel for channel in OTHERS[name] if channel in ("CLK", "SCL", "PWM")]
    assert all(f"{channel} is a clock" in str(refused.value) for channel in clocks)


def test_without_a_telegram_that_is_said() -> None:
    """With pauses, data of SPI look like characters without parity, whose line is low while it is idle."""
    channels = {"CLK": clock(16, 8, 3200, pause=96), "MOSI": shifted_out(NOISE, 16, 96)}
    source = opened(Path("x"), wave(4 * MHZ, **channels), NOTHING)
    assert str(source.settings) == "250000 Bd 8N1"
    assert source.settings_from == (
        "found by the pulses, without a telegram of SIS; channel CLK is a clock; channel MOSI, idle low (inverted)"
    )


def test_other_signals_beside_the_bus() -> None:
    settings = LineSettings(38400)
    recording = wave(4 * MHZ, BUS=trace(bursts(settings), 4 * MHZ), **i2c(NOISE, 10))
    said = "38400 Bd 8E1, found by the pulses; channel BUS; channel SCL is a clock; channel SDA makes no characters"
    assert found(recording) == ([SENT], said)


def test_pulses_beside_the_bus_are_no_direction() -> None:
    """A pulse of 9 bits or fewer looks like a character, however often it comes."""
    characters = bursts(LineSettings.parse(9600, "8N1"))
    edge = [int(character.time_ns * MHZ // NS) for character in characters]
    pulses = array("q", [0, *(time for at in edge for time in (at, at + 300))])
    said = "9600 Bd 8N1, found by the pulses; channel D0; channel IRQ has few characters"
    assert found(wave(MHZ, D0=trace(characters, MHZ), IRQ=pulses)) == ([SENT], said)


def test_what_is_given_is_not_searched_for() -> None:
    recording = wave(MHZ, D0=trace(bursts(LineSettings.parse(9600, "8N1")), MHZ))
    assert found(recording, Stated(9600, "8N1")).said == "9600 Bd 8N1, as given; channel D0"
    assert found(recording, Stated(9600)).said == "9600 Bd 8N1, the rate as given; channel D0"
    for told in (Stated(19200), Stated(9600, "8E1")):
        source = opened(Path("x"), recording, told)
        assert str(source.settings) == str(told.settings)
        assert source.warning == (
            "these are not the settings of this line: D0 has 9600 Bd 8N1, so leave out --baud and --format"
        )


@pytest.mark.parametrize("inverted", [False, True])
def test_settings_that_make_characters_but_no_telegram_are_told(inverted: bool) -> None:
    """Upside down, 8E1 with a short pause after each character is 8N1, nearly without an error."""
    settings, better = LineSettings(9600), "D0 has 9600 Bd 8E1, so leave out --baud and --format"
    ends_ns = (Fraction(10 * MHZ + place * (settings.character_ns + 40_000)) for place in range(220))
    characters = [Sent(end_ns, value, settings) for end_ns, value in zip(ends_ns, TELEGRAMS[0] * 20, strict=True)]
    recording = wave(MHZ, D0=trace(characters, MHZ, inverted=inverted))
    for told in (Stated(9600, "8N1"), Stated(format="8N1")):
        source = opened(Path("x"), recording, told)
        assert "without a telegram of SIS" in source.settings_from
        assert source.warning == f"these are not the settings of this line: {better}"
    with pytest.raises(Refusal, match=better):
        opened(Path("x"), recording, Stated(format="8O1"))


def test_a_channel_that_is_named_is_taken() -> None:
    settings = LineSettings(9600)
    characters = bursts(settings)
    recording = wave(MHZ, A=trace(characters, MHZ), B=trace(characters, MHZ, inverted=True))
    assert found(recording, Stated(device="B")) == (
        [SENT],
        "9600 Bd 8E1, found by the pulses; channel B, idle low (inverted)",
    )
    assert found(recording, Stated(device="A,B")).lines == [SENT, SENT]


def test_a_comma_may_be_in_a_name() -> None:
    channel = trace(bursts(LineSettings(9600)), MHZ)
    recording = Wave(MHZ, {"A,B": channel, "A": clock(100, 50, 500)}, channel[-1] + MHZ, MHZ)
    assert found(recording, Stated(device="A,B")) == ([SENT], "9600 Bd 8E1, found by the pulses; channel A,B")


def test_a_rate_that_changes_is_told() -> None:
    """Only the beginning is searched: 4000 edges. All of it is read."""
    slow, fast = bursts(LineSettings(9600)), bursts(LineSettings(115200), TELEGRAMS * 40, begin_ms=100)
    source = opened(Path("x"), wave(2 * MHZ, D0=trace([*slow, *fast], 2 * MHZ)), Stated(9600))
    assert "most characters are faulty: the settings change in the file" in source.warning


# The same recording in each form: a bus at 9600 Bd 8N1, inverted, and its driver enable.
CHARACTERS = bursts(LineSettings.parse(9600, "8N1"))
RECORDING = wave(MHZ, RO=trace(CHARACTERS, MHZ, inverted=True), DE=enable(CHARACTERS, MHZ))


def samples(recording: Wave) -> list[list[int]]:
    """The levels of the channels, sample by sample."""
    rows = []
    for channel in recording.channels.values():
        level = 0
        levels: list[int] = []
        for edge in channel:
            levels += [level] * (edge - len(levels))
            level ^= 1
        rows.append(levels + [level] * (recording.end - len(levels)))
    return rows


def changes(recording: Wave) -> list[tuple[int, list[int]]]:
    """The levels of all channels at the beginning and after each edge, by its time."""
    times = sorted({0}.union(*recording.channels.values()))
    return [
        (time, [sum(edge <= time for edge in channel) % 2 for channel in recording.channels.values()]) for time in times
    ]


def zipped(path: Path, **files: str | bytes) -> None:
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)


def sr(path: Path, metadata: str = "probe1=RO\nprobe2=DE\nunitsize=1\n") -> None:
    ro, de = samples(RECORDING)
    data = bytes(one | other << 1 for one, other in zip(ro, de, strict=True))
    half = len(data) // 2
    described = f"[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\nsamplerate=1 MHz\n{metadata}"
    zipped(path, version="2", metadata=described, **{"logic-1-1": data[:half], "logic-1-2": data[half:]})


def sr_with_triggers(path: Path) -> None:
    """Old programs wrote their triggers beside the channels, with a blank before the key."""
    sr(path, "probe1=RO\n trigger1 = 0\nprobe2=DE\n trigger2 = r\nunitsize=1\n")


def dsl(path: Path) -> None:
    said = "[version]\nversion = 3\n[header]\ndriver = DSLogic\ndevice mode = 0\ncapturefile = data\n"
    said += "total probes = 2\ntotal blocks = 2\nsamplerate = 1 MHz\nprobe0 = RO\nprobe5 = DE\n"
    files: dict[str, str | bytes] = {"header": said, "decoders": "[]", "session": "{}"}
    for number, levels in zip((0, 5), samples(RECORDING), strict=True):
        packed = bytes(
            sum(bit << place for place, bit in enumerate(levels[at : at + 8])) for at in range(0, len(levels), 8)
        )
        files |= {f"L-{number}/0": packed[:1000], f"L-{number}/1": packed[1000:]}
    zipped(path, **files)


def vcd(path: Path) -> None:
    """As sigrok writes it: all changes of a time in one line."""
    lines = "".join(f'#{time} {levels[0]}! {levels[1]}"\n' for time, levels in changes(RECORDING))
    path.write_text(
        "$date Fri Nov 27 04:46:23 2026 $end\n$version libsigrok 0.5.2 $end\n$comment\n"
        "  Acquisition with 2/8 channels at 1 MHz\n$end\n$timescale 1 us $end\n$scope module libsigrok $end\n"
        '$var wire 1 ! RO $end\n$var wire 1 " DE $end\n$upscope $end\n$enddefinitions $end\n'
        f"{lines}#{RECORDING.end}\n"
    )


def vcd_of_a_simulator(path: Path) -> None:
    """A timescale of 100 ps, scopes, unknown levels, vectors and real numbers, one bit as a vector; no end."""
    lines = "".join(
        f"#{time * 10_000}\n{levels[0]}a\nb{levels[1]} b\nb1x01 v\nr{time / 3} r\n"
        for time, levels in changes(RECORDING)
    )
    path.write_text(
        "$timescale\n\t100ps\n$end\n$scope module top $end\n$var reg 1 a RO $end\n$scope module bus $end\n"
        "$var wire 1 b DE $end\n$var wire 1 a RO $end\n$upscope $end\n$var real 64 r volts $end\n"
        "$var wire 4 v state [3:0] $end\n$var integer 32 n count $end\n$var wire 1 z RO $end\n$upscope $end\n"
        f"$enddefinitions $end\n#0\n$dumpvars\nxa\nxb\nbxxxx v\nzz\n$end\n{lines}"
    )


def saleae(path: Path) -> None:
    rows = "".join(f"{time / 1e6 - 0.05:.9f},{ro},{de}\n" for time, (ro, de) in changes(RECORDING))
    path.write_text(f"Time [s],RO,DE\n{rows}")


def saleae_1(path: Path) -> None:
    rows = "".join(f"{time / 1e6:.15f}, {ro}, {de}\r\n" for time, (ro, de) in changes(RECORDING))
    path.write_text(f"Time[s], RO, DE\r\n{rows}", newline="")


def saleae_dates(path: Path) -> None:
    rows = "".join(f"2026-11-27T10:00:{time / 1e6:09.6f}000+01:00,{ro},{de}\n" for time, (ro, de) in changes(RECORDING))
    path.write_text(f"Time,RO,DE\n{rows}")


def dsview(path: Path) -> None:
    rows = "".join(f"{time / 1e6:.15g},{ro},{de}\n" for time, (ro, de) in changes(RECORDING))
    path.write_text(
        "; CSV, generated by libsigrok4DSL 0.2.0 on Fri Nov 27 10:00:00 2026\n; Channels (2/16)\n"
        f"; Sample rate: 1 MHz\n; Sample count: 1 M Samples\nTime(s), RO, DE\n{rows}"
    )


PULSEVIEW = (
    "; CSV generated by libsigrok 0.5.2\n; from Session-emulating driver on Fri Nov 27 04:46:23 2026\n"
    "; Channels (2/8): RO, DE\n; Samplerate: 1 MHz\n"
)


def pulseview(path: Path) -> None:
    rows = "".join(f"{ro},{de}\n" for ro, de in zip(*samples(RECORDING), strict=True))
    path.write_text(f"{PULSEVIEW}logic,logic\n{rows}")


def pulseview_times(path: Path) -> None:
    rows = "".join(f"{time},{ro},{de}\n" for time, (ro, de) in changes(RECORDING))
    path.write_text(f"{PULSEVIEW}microseconds,logic,logic\n{rows}\n")


def spreadsheet(path: Path) -> None:
    rows = "".join(f"{time / 1e3:.6f};{ro};{de}\n".replace(".", ",") for time, (ro, de) in changes(RECORDING))
    path.write_text(f'"Time [ms]";"RO";"DE"\n{rows}', encoding="utf-8-sig")


FORMS: list[Callable[[Path], None]] = [
    sr,
    sr_with_triggers,
    dsl,
    vcd,
    vcd_of_a_simulator,
    saleae,
    saleae_1,
    saleae_dates,
    dsview,
    pulseview,
    pulseview_times,
    spreadsheet,
]


@pytest.mark.parametrize("form", FORMS)
def test_each_form_has_the_same_bytes(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], form: Callable[[Path], None]
) -> None:
    path = tmp_path / "recording"
    form(path)
    assert known(path)
    done = run(path)
    said = capfd.readouterr().err
    assert done.code == 0, said
    assert [record.data for record in done.records] == TELEGRAMS
    assert {record.type for record in done.records} == {Type.FRAME}
    assert "9600 Bd 8N1, found by the pulses; channel RO, idle low (inverted); channel DE is a driver enable" in said
    first, last = done.records[0], done.records[-1]
    assert last.time_ns - first.time_ns == pytest.approx(
        CHARACTERS[len(SENT) - len(TELEGRAMS[-1])].time_ns - CHARACTERS[0].time_ns, abs=1000
    )


def test_a_binary_export_of_saleae(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Digital, version 0: level, begin and end in s, count, times in s. One channel a file."""
    low_idle = RECORDING.channels["RO"]
    times = struct.pack(f"<{len(low_idle)}d", *(edge / MHZ - 0.05 for edge in low_idle))
    path = tmp_path / "digital_3.bin"
    path.write_bytes(struct.pack("<8siiIddQ", b"<SALEAE>", 0, 0, 0, -0.05, RECORDING.end / MHZ, len(low_idle)) + times)
    assert [record.data for record in run(path).records] == TELEGRAMS
    assert "9600 Bd 8N1, found by the pulses; channel digital_3, idle low (inverted)" in capfd.readouterr().err
    path.write_bytes(struct.pack("<8sii", b"<SALEAE>", 1, 1) + bytes(99))
    assert run(path).code == 2
    assert "export the levels as CSV" in capfd.readouterr().err


@pytest.mark.parametrize("cuts", [5, pytest.param(50, marks=pytest.mark.thorough)])
@pytest.mark.parametrize("form", FORMS)
def test_a_recording_that_is_cut_anywhere(tmp_path: Path, form: Callable[[Path], None], cuts: int) -> None:
    """What comes before is there, or the file is refused."""
    path = tmp_path / "recording"
    form(path)
    data = path.read_bytes()
    for length in range(0, len(data), len(data) // cuts):
        path.write_bytes(data[:length])
        if opener := known(path):
            try:
                heard = b"".join(read.data for read in opener(path, Stated(9600, "8N1", MHZ, "RO")).reads())
            except Refusal:
                continue
            assert len(heard) <= len(TELEGRAMS[0]) or SENT.startswith(heard[:-1])  # a telegram tells the polarity


@pytest.mark.parametrize("seeds", [range(5), pytest.param(range(5, 60), marks=pytest.mark.thorough)])
@pytest.mark.parametrize("form", FORMS)
def test_damaged_recordings_are_read_or_refused(
    tmp_path: Path, form: Callable[[Path], None], seeds: Sequence[int]
) -> None:
    path = tmp_path / "recording"
    form(path)
    whole = path.read_bytes()[:8000]
    for seed in seeds:
        chance = random.Random(seed)
        data = bytearray(whole)
        for _ in range(chance.choice((1, 3, 20))):
            at = chance.randrange(chance.choice((300, len(data))))
            data[at : at + chance.choice((0, 1, 30))] = bytes(chance.choices(b"0123456789-.e#$,;xb \n\0\xff", k=3))
        path.write_bytes(data)
        try:
            opener = known(path)
            assert not opener or list(opener(path, chance.choice((NOTHING, Stated(9600, device="RO")))).reads())
        except Refusal:
            pass


@pytest.mark.parametrize(
    ("form", "end"),
    [
        (vcd, "#99999999999999999999 1!\n"),
        (vcd, '#x 1! 0"\n'),
        *((saleae, f"{time},1,0\n") for time in ("nan", "inf", "1e400", "1e18", "x")),
    ],
)
def test_what_comes_before_a_time_that_is_none_is_kept(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], form: Callable[[Path], None], end: str
) -> None:
    path = tmp_path / "recording"
    form(path)
    with path.open("a") as file:
        file.write(end)
    assert [record.data for record in run(path).records] == TELEGRAMS
    assert f"{path}: its end cannot be read, and is left out" in capfd.readouterr().err


def test_signals_of_the_same_name(tmp_path: Path) -> None:
    """In another scope, and in the same one."""
    path = tmp_path / "x.vcd"
    path.write_text(
        "$timescale 1 us $end $scope module top $end $var wire 1 ! D $end $var wire 1 % D $end $var wire 1 & D $end "
        "$enddefinitions $end #0 1! #1 1% #2 1&\n"
    )
    read = vcd_reader.read(path, NOTHING)
    assert {name: list(edges) for name, edges in read.channels.items()} == {"D": [0], "top.D": [1], "D &": [2]}


def test_without_a_row_at_the_end_the_last_character_is_complete(tmp_path: Path) -> None:
    """A table has edges only: the line stays as it is after the last one."""
    path = tmp_path / "recording"
    saleae(path)
    assert path.read_text().count("\n") == len(changes(RECORDING)) + 1
    assert run(path).records[-1].data == TELEGRAMS[-1]


@pytest.mark.parametrize(
    ("name", "cure"),
    [("metadata", "`sistap import "), ("header", "`sistap import "), ("meta.json", "as CSV")],
)
def test_a_zip_of_an_analyser_is_not_to_be_unpacked(tmp_path: Path, name: str, cure: str) -> None:
    """What all commands say of it that cannot read it."""
    zipped(tmp_path / "x", **{name: ""})
    assert cure in unpack(tmp_path / "x")
    zipped(tmp_path / "x", **{"log.txt": ""})
    assert "unzip" in unpack(tmp_path / "x")


@pytest.mark.parametrize(
    "text",
    ["Time [s],Value\n0.1,0x02\n", "Time,TX\n10:00:00,02 D7 03\n", "a,b\n0,1\n", "Time [s],D0\n", ";\n", "$ ls\n", ""],
)
def test_what_is_no_recording(tmp_path: Path, text: str) -> None:
    path = tmp_path / "text"
    path.write_text(text)
    assert not known(path)


@pytest.mark.parametrize("form", [sr, dsl])
def test_of_what_is_too_fast_for_a_line_only_the_beginning_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, form: Callable[[Path], None]
) -> None:
    """A bit has five samples or more. A small zip can hold much."""
    recording = wave(MHZ, RO=array("q", range(0, 400_000, 2)), DE=array("q", range(3, 400_000, 6)))
    monkeypatch.setitem(globals(), "RECORDING", recording)
    form(tmp_path / "x")
    read = session.read(tmp_path / "x", NOTHING)
    assert len(read.channels["RO"]) <= 2 * HEAD
    assert read.channels["DE"][:60_000] == recording.channels["DE"][:60_000]
    monkeypatch.setattr(session, "_MOST_EDGES", 60_000)
    with pytest.raises(Refusal, match="edges: save it again with the channels of the bus only, or a part of it"):
        session.read(tmp_path / "x", NOTHING)


@pytest.mark.parametrize("probes", ["", "probe0 = RO\n"])
def test_a_session_of_dsview_without_samples(tmp_path: Path, probes: str) -> None:
    """Its channels are others than those of the samples, or none."""
    path = tmp_path / "x.dsl"
    zipped(path, header=f"[header]\nsamplerate = 1 MHz\n{probes}", **{"L-7/0": b"\0"})
    with pytest.raises(Refusal, match="has no samples of logic channels: save them from DSView"):
        session.read(path, NOTHING)


def test_a_session_that_is_cut_off(tmp_path: Path) -> None:
    """The directory of a zip is at its end."""
    cut = tmp_path / "cut.sr"
    cut.write_bytes(b"PK\x03\x04" + bytes(400))
    assert unpack(cut) == f"{cut} is a damaged zip: copy it again from where it was recorded"
