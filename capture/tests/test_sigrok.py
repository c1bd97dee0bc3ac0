# SPDX-License-Identifier: GPL-2.0-or-later
"""A logic analyser as the tap: the real sigrok-cli delivers samples of a rendered wire (sampled_wire.py).

The result is compared with what was sent, and with the result of sigrok's own decoder for the same samples.
"""

from __future__ import annotations

import os
import random
import re
import subprocess
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path

import imported
import pytest
from portable import posix
from sampled_wire import NS, SIGROK, Sent, needs_sigrok, of_records, play, sampled

from sistap import cli
from sistap.dissected.captures.reading import records
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.analyser.probe import Probe, hertz, plugged_in
from sistap.tap.analyser.reader import SampleClock
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.record import Event, Record, Type

BAD, BREAK, LOST, GOOD = Flag.CHARACTER_ERROR, Flag.BREAK, Flag.LOST_BEFORE, Flag(0)
MHZ = 1_000_000
PORT = "sigrok:fx2lafw?rx=0"


def traffic(count: int, settings: LineSettings, seed: int = 1, *, faulty: bool = False) -> list[Sent]:
    """Return characters at any distance, with possible faults."""
    chance = random.Random(seed)
    bit_ns = Fraction(NS, settings.baud)
    time_ns = Fraction(2_000_000)
    sent = []
    for _ in range(count):
        time_ns += settings.character_ns + bit_ns * chance.choice((0, 0, 0, 1, 7, 100)) + chance.randrange(1000)
        flag = chance.choice((GOOD,) * 9 + (BAD, BREAK)) if faulty else GOOD
        value = 0 if flag == BREAK else chance.randrange(1, 256)
        sent.append(Sent(time_ns, value, settings, flag, without_stop=flag == BAD and chance.random() < 0.5))
        if flag != GOOD:
            time_ns += 3 * bit_ns
    return sent


def end_of(*lines: Sequence[Sent]) -> int:
    return max(int(line[-1].time_ns) for line in lines) + 20_000_000


@pytest.fixture
def wire(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a file for samples, which the simulated analyser then has."""
    samples = tmp_path / "samples"
    play(tmp_path, samples, monkeypatch)
    return samples


def captured(folder: Path, port: str, *options: str, code: int = 1) -> list[Record]:
    """Capture until the samples end, as if the analyser was unplugged."""
    file = folder / "captured.pcapng"
    assert cli.main(["capture", "-i", port, "-w", str(file), "-q", *options]) == code
    return list(records(file))


def judged(samples: Path, samplerate: int, settings: LineSettings) -> list[Sent]:
    """Return what sigrok's own decoder finds; times count from the first sample, in ns."""
    parity = {"N": "none", "E": "even", "O": "odd"}[settings.parity]
    decoder = f"uart:rx=0:baudrate={settings.baud}:parity={parity}:format=hex"
    text = subprocess.run(
        [str(SIGROK), "-i", str(samples), "-I", f"binary:numchannels=8:samplerate={samplerate}", "-P", decoder]
        + ["-A", "uart=rx-data:rx-warnings:rx-parity-err:rx-break", "--protocol-decoder-samplenum", "-l", "4"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    listed = samples.with_suffix(".txt")
    listed.write_text("\n".join(line for line in text.splitlines() if re.match(r"\d+-\d+ ", line)))
    done = imported.run(
        listed, "--baud", str(settings.baud), "--format", settings.format, "--samplerate", str(samplerate)
    )
    return of_records(done.records, 0)


def alike(found: Sequence[Sent], sent: Sequence[Sent], within_ns: float) -> None:
    """Compare characters, and their times from the first one on."""
    assert [(one.value, one.flag) for one in found] == [(one.value, one.flag) for one in sent]
    for one, was in zip(found, sent, strict=True):
        assert abs((one.time_ns - found[0].time_ns) - (was.time_ns - sent[0].time_ns)) <= within_ns


@needs_sigrok
@pytest.mark.parametrize(("baud", "text"), [(9600, "8E1"), (115200, "8N1")])
def test_every_character_with_its_time_and_its_errors(wire: Path, tmp_path: Path, baud: int, text: str) -> None:
    settings = LineSettings.parse(baud, text)
    sent = traffic(300, settings, faulty=text == "8E1")
    wire.write_bytes(sampled([sent], 4 * MHZ, end_of(sent)))
    heard = captured(tmp_path, PORT, "--baud", str(baud), "--format", text)
    alike(of_records(heard, 0), sent, 250)
    assert {one.uncertainty_ns for one in heard if one.type != Type.EVENT} == {500}
    started = heard[0].data.decode()
    assert "4000000 Hz" in started
    assert "100 ppm" in started


@needs_sigrok
def test_the_decoder_of_sigrok_finds_the_same(wire: Path, tmp_path: Path) -> None:
    settings = LineSettings(38400)
    sent = traffic(200, settings, faulty=True)
    wire.write_bytes(sampled([sent], 4 * MHZ, end_of(sent)))
    heard = of_records(captured(tmp_path, PORT, "--baud", "38400"), 0)
    # It rounds each bit to a sample.
    alike(heard, judged(wire, 4 * MHZ, settings), 1000)


@needs_sigrok
def test_both_directions_and_an_inverted_line(wire: Path, tmp_path: Path) -> None:
    settings = LineSettings(9600)
    first, second = traffic(60, settings, 1), traffic(60, settings, 2)
    samples = sampled([first, second], MHZ, end_of(first, second))
    wire.write_bytes(bytes(sample ^ 2 for sample in samples))
    heard = captured(tmp_path, "sigrok:fx2lafw?rx=0&tx=1&samplerate=1m&invert=tx", "--framing", "silence:5")
    for line, sent in ((1, first), (2, second)):
        alike(of_records([one for one in heard if one.line == line], 0), sent, 1000)
    times = [one.time_ns for one in heard if one.type != Type.EVENT]
    assert times == sorted(times)
    together = of_records([one for one in heard if one.line == 1], 0)[0].time_ns - int(first[0].time_ns)
    assert abs(of_records([one for one in heard if one.line == 2], 0)[0].time_ns - together - second[0].time_ns) <= 1000


def telegrams(settings: LineSettings, count: int) -> list[Sent]:
    """SIS telegrams of a master that asks for its drive's phase, 20 ms from one to the next."""
    telegram = bytes.fromhex("026C00000092 0000")
    to_stop_ns = Fraction(settings.character_ns)
    return [
        Sent(10_000_000 + number * 20_000_000 + (place + 1) * to_stop_ns, value, settings)
        for number in range(count)
        for place, value in enumerate(telegram)
    ]


@contextmanager
def fed(wire: Path, *pieces: bytes, samplerate: float, pause_s: float = 0) -> Iterator[None]:
    """Deliver the samples at the pace of an analyser, with a pause between two pieces."""
    os.mkfifo(wire)

    def feed() -> None:
        step = int(samplerate / 100)
        with wire.open("wb", buffering=0) as pipe:
            due = time.monotonic()
            for piece in pieces:
                for at in range(0, len(piece), step):
                    pipe.write(piece[at : at + step])
                    due += 0.01
                    time.sleep(max(0.0, due - time.monotonic()))
                due += pause_s

    feeding = threading.Thread(target=feed)
    feeding.start()
    yield
    feeding.join()


@needs_sigrok
@pytest.mark.parametrize(("baud", "text"), [(57600, "8N1"), pytest.param(19200, "8E1", marks=pytest.mark.thorough)])
def test_the_rate_is_seen_on_the_line(wire: Path, tmp_path: Path, baud: int, text: str) -> None:
    sent = telegrams(LineSettings.parse(baud, text), 120)
    with fed(wire, sampled([sent], 4 * MHZ, end_of(sent)), samplerate=4 * MHZ):
        heard = captured(tmp_path, PORT, "--baud", "auto")
    said = [one.data.decode() for one in heard if one.event == Event.SETTINGS_CHANGED]
    assert said[-1] == f"{baud} Bd {text}: found, by a valid telegram"
    # None of the rates between was tried.
    assert len({one.partition(" Bd")[0] for one in said} - {"9600", str(baud)}) == 0


@needs_sigrok
@pytest.mark.thorough
def test_samples_that_are_missing_are_told(wire: Path, tmp_path: Path) -> None:
    """The analyser goes on after a second in which nothing was sampled."""
    sent = telegrams(LineSettings(9600), 500)
    samples = sampled([sent], 200_000, end_of(sent))
    half = len(samples) // 2
    with fed(wire, samples[:half], samples[half:], samplerate=200_000, pause_s=1):
        heard = captured(tmp_path, f"{PORT}&samplerate=200k")
    assert sum(one.errors & LOST == LOST for one in heard if one.type != Type.EVENT) == 1
    found = of_records(heard, 0)
    assert abs(found[-1].time_ns - found[0].time_ns - NS - (sent[-1].time_ns - sent[0].time_ns)) < NS // 10


def test_missing_samples_and_late_ones_are_told_apart() -> None:
    def lost_ms(late_ms: Sequence[float]) -> list[int]:
        """Return the detected loss when samples come this late, each 0.25 s."""
        clock = SampleClock(0, 1000)
        found = []
        for number, late in enumerate(late_ms, 1):
            now_ns = int((number * 250 + late) * MHZ)
            if lost_ns := clock.lost_ns(now_ns, number * 250):
                clock.skip(lost_ns)
                found.append(lost_ns // MHZ)
        return found

    good: list[float] = [5, 3, 4, 3] * 5
    assert lost_ms(good * 10) == []
    assert lost_ms([*good, 2000, 1750, 1500, 1250, 1000, 750, 500, 250, *good]) == []  # a disk was busy
    assert lost_ms([*good, *(late + 300 for late in good * 4)]) == [300]
    # 100 ppm of a crystal, for an hour.
    assert lost_ms([5 + number * 0.025 for number in range(14400)]) == []


@needs_sigrok
def test_an_analyser_that_makes_its_samples_itself(tmp_path: Path) -> None:
    """The demo device of sigrok, unmodified: it runs until the capture ends."""
    file = tmp_path / "demo.pcapng"
    port = "sigrok:demo?rx=D0&tx=D3&samplerate=500k"
    assert cli.main(["capture", "-i", port, "-w", str(file), "-q", "-a", "duration:1"]) == 0
    assert any(one.type != Type.EVENT for one in records(file))


@needs_sigrok
@pytest.mark.parametrize(
    ("port", "words"),
    [
        ("sigrok:fx2lafw?rx=D0", "No devices found"),
        ("sigrok:nothing?rx=D0", "Driver nothing not found"),
        ("sigrok:demo?rx=D77", "D77"),
        ("sigrok:demo?rx=D0&samplerate=20k", "9600 Bd with 20000 samples a second"),
        ("sigrok:demo?rx=D0&tx=D0", "write it as"),
        ("sigrok:", "write it as"),
        ("sigrok:--version", "write it as"),
        ("sigrok:demo?rx=D0&samplerate=fast", "'fast'"),
        ("sigrok:demo?rx=D0&invert=maybe", "invert"),
        ("sigrok:demo?channel=D0", "channel"),
    ],
)
def test_what_cannot_be_opened_is_one_line(port: str, words: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["capture", "-i", port, "-q"]) == 3
    said = capfd.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_without_sigrok_cli_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert cli.main(["capture", "-i", PORT]) == 3
    assert "apt-get install sigrok-cli" in capfd.readouterr().err


def test_both_directions_leave_no_room_for_another_port(capfd: pytest.CaptureFixture[str]) -> None:
    port = "sigrok:demo?rx=D0&tx=D1"
    assert cli.main(["capture", "-i", port, "-i", "sigrok:demo?rx=D2"]) == 3
    assert "remove the other -i" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("text", "hz"),
    [("4m", 4 * MHZ), ("500k", 500_000), ("2.304 MHz", 2_304_000), ("200000", 200_000), ("1G", NS)],
)
def test_rates_of_samples(text: str, hz: int) -> None:
    assert hertz(text) == hz


@pytest.mark.parametrize(("baud", "hz"), [(9600, 4 * MHZ), (115200, 4 * MHZ), (250_000, 8 * MHZ), (3 * MHZ, 24 * MHZ)])
def test_a_bit_has_twenty_samples_or_as_many_as_there_can_be(baud: int, hz: int) -> None:
    assert Probe.parse(PORT).samplerate_for(baud) == hz


@posix("no folder with all USB devices")
def test_analysers_that_are_plugged_in(tmp_path: Path) -> None:
    for name, vendor, product, title in [
        ("1-1", "0403", "6001", "FT232R"),
        ("1-2", "0925", "3881", ""),
        ("1-3", "1d50", "608c", "fx2lafw"),
    ]:
        folder = tmp_path / "bus/usb/devices" / name
        folder.mkdir(parents=True)
        for file, text in [("idVendor", vendor), ("idProduct", product), ("product", title), ("busnum", "1")]:
            (folder / file).write_text(text + "\n")
        (folder / "devnum").write_text(f"{name[-1]}\n")
    (tmp_path / "001").mkdir()
    (tmp_path / "001/003").touch()
    found = plugged_in(tmp_path, tmp_path)
    assert [(one.name, one.usb, one.may_be_opened) for one in found] == [
        ("Saleae Logic or a copy of it", "1.2", False),
        ("fx2lafw", "1.3", True),
    ]
    assert found[0].port == "sigrok:fx2lafw:conn=1.2?rx=D0"
    assert Probe.parse(found[0].port).driver == "fx2lafw:conn=1.2"


VERDICTS = ["sis.tza.verdict", "sis.tza.interval_max", "sertap.uncertainty"]


def verdicts(capture: Path) -> list[list[str]]:
    fields = [word for name in VERDICTS for word in ("-e", name)]
    with Tshark() as tshark:
        lines = tshark.output("-2", "-r", str(capture), "-Y", "sis.tza.verdict", "-T", "fields", *fields)
    return [line.split("\t") for line in lines.splitlines()]


@pytest.mark.thorough
@needs_sigrok
def test_its_verdicts_are_right_and_none_is_open(wire: Path, tmp_path: Path) -> None:
    """Pauses inside telegrams, some longer than TzA: the virtual bus itself says which."""
    true = tmp_path / "true.pcapng"
    assert cli.main(["bus", "slow-characters", "-w", str(true)]) == 0
    sent = list(records(true))
    characters = of_records(sent, sent[0].time_ns - 5_000_000)
    wire.write_bytes(sampled([characters], 4 * MHZ, end_of(characters)))
    captured(tmp_path, PORT)
    right, heard = verdicts(true), verdicts(tmp_path / "captured.pcapng")
    assert [verdict for verdict, *_ in heard] == [verdict for verdict, *_ in right]
    assert {"0", "1"} == {verdict for verdict, *_ in heard}


@needs_sigrok
@pytest.mark.thorough
def test_a_hundred_thousand_characters_are_right_to_a_sample(wire: Path, tmp_path: Path) -> None:
    settings = LineSettings(38400)
    sent = traffic(100_000, settings, faulty=True)
    wire.write_bytes(sampled([sent], MHZ, end_of(sent)))
    heard = captured(tmp_path, f"{PORT}&samplerate=1m", "--baud", "38400")
    found = of_records(heard, 0)
    assert len(found) == 100_000
    alike(found, sent, 1000)
