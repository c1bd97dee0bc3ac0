# SPDX-License-Identifier: GPL-2.0-or-later
"""Hours and a day of capture in simulated time: a bus over its socket, real framer, session, clock, writer and ring.

The clocks are simulated: the monotonic one follows the bus, the wall clock drifts away from it.
"""

from __future__ import annotations

import itertools
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from independent import blocks, packets
from pcapng.blocks import InterfaceStatistics
from test_bus import TIMEOUT_S
from test_stations import drive

from sisbus.playing.characters import NO_FAULTS, Played, reads
from sisbus.playing.conducting import Rate
from sisbus.playing.player import Player
from sisbus.scenarios.demo import read_parameter
from sisbus.wires.taps import Taps
from sisbus.wires.wire import Pace
from sistap.tap.capture import session
from sistap.tap.files.output import FileLimits, Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.clock import Clock
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Event, Type
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.stop import Stop
from sistap.tap.wire.connection import WireReader

# python-pcapng warns of itself.
pytestmark = pytest.mark.filterwarnings("ignore:Field type should not be:DeprecationWarning")

LINE = LineSettings()
EVERY_S = 10
READ = 16  # characters, of an adapter with a FIFO
EPOCH = 1_700_000_000_000_000_000
SECOND = 1_000_000_000
DRIFT_PPM = 80  # a poor quartz: 6.9 s a day


def exchanges(hours: int) -> Iterator[Played]:
    """A master that reads a value every ten seconds."""
    player = Player(LINE, NO_FAULTS, 1, [drive(3)])
    for _ in range(hours * 3600 // EVERY_S):
        player.change(Rate(LINE.baud, EVERY_S * 1000))
        yield from player.exchange(read_parameter(3, "S-0-0040"))


def play(path: str, hours: int) -> None:
    taps = Taps(Pace(simulated=True), path, 1, READ)
    print(taps.name, flush=True)
    taps.wait_for_listener()
    for played in exchanges(hours):
        taps.deliver(played)
    taps.close()


class Machine:
    """A computer whose monotonic clock is the time of the bus, and whose wall clock is too fast."""

    def __init__(self) -> None:
        self.monotonic = 0
        self.clock = Clock(lambda: self.monotonic, lambda: wall(self.monotonic))


def wall(monotonic_ns: int) -> int:
    return EPOCH + monotonic_ns + monotonic_ns * DRIFT_PPM // 1_000_000


class StampingReader(WireReader):
    """Stamps what comes with the clock of the machine, as the reader of a device does; now and then counts memory."""

    def __init__(self, port: str, machine: Machine) -> None:
        super().__init__(port, LINE)
        self.blocks: list[int] = []  # of memory, at the end of each hour
        self._machine = machine
        self._zero: int | None = None

    def now_ns(self) -> int:
        return self._machine.clock.now_ns()

    def read(self, timeout_s: float) -> Read | None:
        read = super().read(timeout_s)
        if read is None:
            return None
        self._zero = self._zero or read.time_ns - SECOND  # the first that it hears is the first second
        machine = self._machine
        machine.monotonic = read.time_ns - self._zero
        if machine.monotonic // SECOND >= 3600 * (1 + len(self.blocks)):
            self.blocks.append(sys.getallocatedblocks())
        return read._replace(time_ns=machine.clock.wall_ns(machine.monotonic))


@pytest.mark.parametrize("hours", [2, pytest.param(24, marks=pytest.mark.thorough)])
def test_hours(hours: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    command = [sys.executable, __file__, "127.0.0.1:0", str(hours)]
    bus = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert bus.stdout
        machine = Machine()
        reader = StampingReader(bus.stdout.readline().strip(), machine)
        monkeypatch.setattr("sistap.tap.capture.tap.CLOCK", machine.clock)
        folder = tmp_path / "files"
        folder.mkdir()
        with monkeypatch.context() as patched:
            patched.setattr("sistap.tap.files.output.time.monotonic", lambda: machine.monotonic / 1e9)
            output = Output(str(folder / "x"), FileLimits(duration_s=3600, several=True))
            counters = Counters()
            sink = PcapngWriter(output, {0: Interface(252, "x")}, counters)
            capture = session.Capture([reader], sink, output, counters, Console(), clock_ns=lambda: machine.monotonic)
            assert capture.run(Stop()) == 1  # the bus has ended
            output.close()
        reader.close()
        assert bus.wait(TIMEOUT_S) == 0
    finally:
        bus.kill()
        bus.communicate()
    expect_hourly_files(sorted(folder.iterdir()), hours)
    expect_every_telegram_at_its_time(sorted(folder.iterdir()), hours)
    # Once everything has been used, the same hour after hour: 3600 seconds, 720 telegrams, a file leave nothing behind
    # but what Python itself keeps for later.
    assert len(reader.blocks) >= hours - 1
    assert max(reader.blocks[1:]) - reader.blocks[1] < 240


def expect_hourly_files(files: list[Path], hours: int) -> None:
    assert len(files) in (hours, hours + 1)
    for number, file in enumerate(files):
        records = [packet.record for packet in packets(file)]
        assert records[0].event == Event.CAPTURE_STARTED
        times = [record.time_ns for record in records]
        assert times == sorted(times)
        assert times[-1] - times[0] <= (3600 + EVERY_S) * SECOND
        if number < hours:
            count = sum(record.type == Type.FRAME for record in records)  # a file ends with a whole exchange
            assert 3590 * 2 // EVERY_S <= count <= (3600 + EVERY_S) * 2 // EVERY_S
        assert isinstance(blocks(file)[-1], InterfaceStatistics)


def expect_every_telegram_at_its_time(files: list[Path], hours: int) -> None:
    """Check all of them, once, in order. No interval is off by more than 500 ppm, no time by more than a
    millisecond.
    """
    frames = [packet.record for file in files for packet in packets(file) if packet.record.type == Type.FRAME]
    sent = list(exchanges(hours))
    assert [frame.data for frame in frames] == [played.sent for played in sent]
    assert len(frames) == 2 * hours * 3600 // EVERY_S
    heard = [next(iter(reads(played.characters, READ, LINE.character_ns)))[-1].time_ns for played in sent]
    zero = heard[0] - (frames[0].time_ns - EPOCH)
    for frame, true_ns in zip(frames, heard, strict=True):
        assert abs(frame.time_ns - wall(true_ns - zero)) < 1_000_000
    for (frame, later), (true_ns, later_ns) in zip(itertools.pairwise(frames), itertools.pairwise(heard), strict=True):
        assert abs((later.time_ns - frame.time_ns) - (later_ns - true_ns)) <= (later_ns - true_ns) // 2000 + 1


if __name__ == "__main__":
    play(sys.argv[1], int(sys.argv[2]))
