# SPDX-License-Identifier: GPL-2.0-or-later
"""Live values of `sistap record`: what is written, and that a reader who is slow, or gone, disturbs nothing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from commands import refused, run
from portable import posix

from sistap import cli
from sistap.commands.recorder import values as values_module
from sistap.commands.recorder.keeper import Around
from sistap.commands.recorder.reasons import judges
from sistap.commands.recorder.recorder import Recorder, Wanted
from sistap.commands.recorder.values import Value, ValueLines, line
from sistap.dissected.accesses.access import Access, Parameter
from sistap.dissected.captures import reading
from sistap.dissected.episodes.live import LIVE
from sistap.dissected.explain.relay import Seams
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files.pcapng import Interface

PATIENCE_S = 60
thorough = pytest.mark.thorough


def access(value: str = "1000.5 rpm", number: float | None = 1000.5, **more: Any) -> Access:
    parameter = Parameter("/dev/ttyUSB0", "3", 7, "S-0-0040")
    said = {"name": "Velocity feedback value", "unit": "rpm", "error": ""} | more
    return Access(
        said.pop("parameter", parameter),
        False,
        16,
        value=value,
        number=number,
        data=None,
        minimum="",
        maximum="",
        **said,
    )


def value(*arguments: Any, **more: Any) -> Value:
    return Value(1_773_522_060_025_791_346, access(*arguments, **more))


@pytest.fixture(autouse=True)
def _this_computer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(values_module, "_HOST", "pi")
    monkeypatch.setattr(values_module, "_TURN_S", 0.01)


# -- What is sent


def test_a_line() -> None:
    tags = "sis,device=7,host=pi,parameter=S-0-0040,port=/dev/ttyUSB0,station=3"
    names = 'name="Velocity feedback value",unit="rpm"'
    assert line(value()) == f"{tags} value=1000.5,{names} 1773522060025791346"
    assert line(value("00 01", None, name="", unit="")) == f'{tags} text="00 01" 1773522060025791346'


def test_a_number_without_decimals_is_a_number() -> None:
    assert " value=7," in line(value("7 rpm", 7))


@pytest.mark.parametrize("number", [float("inf"), float("nan")])
def test_what_no_number_can_say_is_text(number: float) -> None:
    """The line protocol does not have these."""
    assert 'text="too much",' in line(value("too much", number))


@pytest.mark.attack("a drive names a parameter like a line or a tag of live values", "escaped; it adds none")
def test_a_name_adds_nothing() -> None:
    """The reference of the line protocol: a \\ before a comma, = or blank of a tag, and before a " or \\ of a text."""
    parameter = Parameter("a b,c=d\\", "3/2", 7, "#/+\n=")
    hostile = value(name='x"\nsis value=1 1\\', unit="\u202e", parameter=parameter)
    assert line(hostile) == (
        "sis,device=7,host=pi,parameter=#/+/n\\=,port=a\\ b\\,c\\=d/,station=3/2 "
        'value=1000.5,name="x\\"\\\\nsis value=1 1\\\\",unit="\\\\u202e" 1773522060025791346'
    )


# -- Beside a recording


class Kept:
    """Takes what is written, and can hang or fail."""

    def __init__(self) -> None:
        self.heard = b""
        self.may_go = threading.Event()
        self.may_go.set()
        self.is_gone = False

    def write(self, data: bytes) -> int:
        assert self.may_go.wait(PATIENCE_S)
        if self.is_gone:
            raise BrokenPipeError(32, "Broken pipe")
        self.heard += data[:100]  # a pipe may take a part
        return min(len(data), 100)

    @property
    def times(self) -> list[int]:
        return [int(line.rpartition(b" ")[2]) for line in self.heard.splitlines()]


def wait_until(is_done: Callable[[], bool]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not is_done():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def test_a_refused_access_has_no_value() -> None:
    kept = Kept()
    values = ValueLines(kept.write)
    values.start(lambda said: pytest.fail(said))
    values.put(1, [access(error="0x8002"), access("", None), access("1 rpm", 1.0)])
    values.close()
    assert kept.heard.decode() == line(Value(1, access("1 rpm", 1.0))) + "\n"


def hanging(monkeypatch: pytest.MonkeyPatch, said: list[str]) -> tuple[Kept, ValueLines]:
    """Return a reader that hangs with the value of time 0, and the values for it: ten can wait."""
    monkeypatch.setattr(values_module, "MOST", 10)
    kept = Kept()
    kept.may_go.clear()
    values = ValueLines(kept.write)
    values.put(0, [access()])
    values.start(said.append)
    wait_until(lambda: bool(values._unwritten) and not values._waiting)
    for number in range(1, 31):
        values.put(number, [access()])
    return kept, values


def test_a_reader_that_hangs_delays_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the end, nobody waits long for it."""
    monkeypatch.setattr(values_module, "PATIENCE_S", 0.1)
    said: list[str] = []
    kept, values = hanging(monkeypatch, said)
    values.close()
    assert not kept.heard  # it hangs still
    assert said == ["31 values could not be written to standard output"]
    kept.may_go.set()


def test_the_oldest_go_and_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    kept, values = hanging(monkeypatch, said)
    kept.may_go.set()
    values.close()
    assert kept.times == [0, *range(21, 31)]
    assert said == ["20 values could not be written to standard output"]


def test_a_reader_that_is_gone_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    kept, values = hanging(monkeypatch, said)
    kept.is_gone = True
    kept.may_go.set()
    wait_until(lambda: bool(said))
    values.put(31, [access()])
    values.close()
    assert said == [
        "no more values are written to standard output: Broken pipe",
        "32 values could not be written to standard output",
    ]


@pytest.fixture(scope="module")
def traffic(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("traffic") / "x.pcapng"
    assert cli.main(["bus", "demo", "--cycles", "12", "-w", str(path)]) == 0
    return path


@pytest.mark.parametrize("keep", ["faults", *(pytest.param(one, marks=thorough) for one in ("nothing", "writes"))])
def test_each_value_is_sent_once(tshark: Tshark, traffic: Path, tmp_path: Path, keep: str) -> None:
    """Also while one tshark takes over from another."""
    fields = ["-T", "fields", "-e", "frame.time_epoch", "-e", "sis.access"]
    told = tshark.output("-r", str(traffic), "-Y", "sis.access", *fields)
    answered = [line for line in told.splitlines() if '"value"' in line]
    kept = Kept()
    values = ValueLines(kept.write)
    deciding = judges(tshark, [keep], LIVE, values)
    wanted = Wanted(tmp_path, deciding, Around(0, 0), 100)
    line_0 = {0: Interface(252, "a line of a test")}
    recorder = Recorder(wanted, tshark, line_0, lambda said: pytest.fail(said), seams=Seams(packets=60))
    values.start(lambda said: pytest.fail(said))
    first, *rest = reading.records(traffic)
    recorder.begin(first)
    for record in rest:
        recorder.write(record)
    recorder.end(rest[-1].time_ns)
    values.close()
    sent = kept.heard.decode().splitlines()
    assert [f"{time_ns // 10**9}.{time_ns % 10**9:09}" for time_ns in kept.times] == [
        told.partition("\t")[0] for told in answered
    ]
    idents = [told.partition(",parameter=")[2].partition(",")[0] for told in sent]
    assert len(sent) > 20 and all(f'"{ident}"' in told for ident, told in zip(idents, answered, strict=True))
    assert any(" value=" in told and ",unit=" in told for told in sent)


@posix("Windows has no descriptor to hand on")
@pytest.mark.parametrize("is_reader_gone", [False, pytest.param(True, marks=thorough)])
def test_lines_on_standard_output(tmp_path: Path, is_reader_gone: bool) -> None:
    """From end to end. A reader that is gone does not end the recording."""
    command = [sys.executable, "-m", "sistap"]
    bus = subprocess.Popen(
        [*command, "bus", "demo", "--fast", "--cycles", "60", "--listen", str(tmp_path / "bus")],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    assert bus.stdout and bus.stdout.readline()
    reader, writer = os.pipe()
    options = ["--keep", "nothing", "--values", "-", "-w", "kept", "-c", "120"]
    recorder = subprocess.Popen(
        [*command, "record", "-i", f"bus://{tmp_path}/bus", *options],
        cwd=tmp_path,
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
    )
    os.close(writer)
    if is_reader_gone:
        os.close(reader)
        lines = []
    else:
        with open(reader) as file:
            lines = file.read().splitlines()
    _, errors = recorder.communicate(timeout=PATIENCE_S)
    bus.send_signal(signal.SIGTERM)
    bus.communicate()
    assert "telegrams, 0 of them damaged" in errors and "0 files kept" in errors
    assert ("could not be written to standard output" in errors) == is_reader_gone
    assert recorder.returncode == 0 and "Traceback" not in errors
    if not is_reader_gone:
        assert lines and all(line.startswith("sis,device=") for line in lines)
        assert any(" value=" in line and 'unit="rpm"' in line for line in lines)


def test_options_that_do_not_fit(tmp_path: Path) -> None:
    for options, words in (
        (["--values", "mqtt://h/x"], "it is - alone"),
        (["--keep", "nothing"], "--keep nothing is for"),
    ):
        refused(run(tmp_path, "record", "-i", "bus://none", "-w", "kept", *options), 2, words)
    assert not (tmp_path / "kept").exists()
