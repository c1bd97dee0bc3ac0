# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads a logic analyser, which samples the line: sigrok-cli delivers the samples, and this module decodes them.

sigrok-cli has a decoder of its own. At 115200 Bd it needs 1.4 s of processor time for each second of a busy line, and
it must be restarted for another rate. So only the tests use it, as a reference.
"""

from __future__ import annotations

import re
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from queue import Empty, Queue
from typing import NamedTuple

from sistap.tap.analyser.finding import Trace, find
from sistap.tap.analyser.probe import MISSING, PROGRAM, Probe, hertz, program
from sistap.tap.analyser.uart import ENOUGH_SAMPLES, FEWEST_SAMPLES, HIGH, LOW, Edges, Uart
from sistap.tap.common.complaints import Complaints
from sistap.tap.line.clock import CLOCK, monotonic_ns
from sistap.tap.line.reader.contract import PortError, PortLost
from sistap.tap.line.settings import Flag, LineSettings, Read

START_S = 10  # for a device: an FX2 first gets its firmware, and then is a new device
END_S = 2
CRYSTAL_PPM = 100  # as USB requires of an FX2

_NS = 1_000_000_000
_CHUNK = 1 << 20
_CHUNKS = 1 << 10  # chunks kept; if sistap is later than that, sigrok-cli must wait, and the analyser stops
_WIDTH = 2048  # samples in a line of sigrok-cli
_PIPE_BYTES = 1 << 20  # as much as an ordinary user may set
_HEADER = re.compile(rb"^Acquisition with .*channels(?: at (?P<rate>.+))?\n", re.MULTILINE)
_NOT_BITS = bytes(set(range(256)) - set(b"01"))
_SWAPPED = bytes.maketrans(HIGH + LOW, LOW + HIGH)
_HEARD = 1 << 9  # edges by which the rate of the line is found


class SigrokReader:
    """Reads the lines of one analyser, one or both directions. Each character is a read of its own."""

    def __init__(self, port: str, settings: LineSettings, line: int = 0) -> None:
        """Start sigrok-cli, and wait until samples come. May raise PortError."""
        try:
            probe = Probe.parse(port)
        except ValueError as error:
            raise PortError(str(error)) from error
        if line and len(probe.channels) > 1:
            raise PortError(f"{port} has both directions: remove the other -i, or &tx=")
        self.name = port
        self.adapter = f"logic analyser {probe.driver}, {' and '.join(probe.channels)}, by sigrok-cli"
        self.settings = settings
        self.line = line or int(len(probe.channels) > 1)
        self._reads: deque[Read] = deque()
        self._text = b""  # the beginning of a line
        self._samplerate = probe.samplerate_for(settings.baud)
        _check(port, settings, self._samplerate)
        self._process = _Process(probe, self._samplerate)
        try:
            self._begin(probe)
            _check(port, settings, self._samplerate)
        except PortError:
            self.close()
            raise
        self.timing = (
            f"times count samples of {self._samplerate} Hz, to one; the crystal of the analyser may be off by "
            f"{CRYSTAL_PPM} ppm of an interval; a character's is the middle of its stop bit"
        )
        few = self._samplerate < ENOUGH_SAMPLES * settings.baud
        cure = f"{port}: {self._samplerate / settings.baud:.1f} samples a bit are few: set &samplerate="
        self.notes: tuple[str, ...] = (f"{cure}{ENOUGH_SAMPLES * settings.baud} or more",) if few else ()

    def read(self, timeout_s: float) -> Read | None:
        """Return what arrived; None if nothing arrived in that time. May raise PortLost."""
        end_ns = monotonic_ns() + int(timeout_s * 1e9)
        while not self._reads:
            chunk = self._process.chunk(max(0.0, (end_ns - monotonic_ns()) / 1e9))
            if chunk is None:
                return None
            if not chunk.data:
                words = self._process.words() or "without a message"
                raise PortLost(
                    f"{self.name}: {PROGRAM} has ended ({words}): the analyser was unplugged, or could not "
                    "pass its samples on in time: use another USB port, or a lower &samplerate=",
                    self.line,
                )
            self._take(chunk)
        return self._reads.popleft()

    def change(self, settings: LineSettings) -> None:
        """Read with other settings from the next character on."""
        _check(self.name, settings, self._samplerate)
        self.settings = settings
        for channel in self._channels:
            channel.uart.set(settings)

    def measured_baud(self) -> float | None:
        """Return the rate according to the pulses on the line; None if there were too few."""
        readings = [reading for channel in self._channels if (reading := find(channel.heard(), self._samplerate))]
        return max(readings, key=lambda one: one.score).settings.baud if readings else None

    def close(self) -> None:
        """Release the analyser."""
        self._process.end()

    def _begin(self, probe: Probe) -> None:
        """Wait for the first samples, and for the messages of sigrok-cli before them."""
        until = time.monotonic() + START_S
        text = b""
        arrived_ns = 0
        while not (match := _HEADER.search(text)):
            chunk = self._process.chunk(max(0.0, until - time.monotonic()))
            if chunk is None or not chunk.data:
                why = f"silent for {START_S} s" if chunk is None else self._process.words() or "it has ended"
                raise PortError(
                    f"{self.name}: {PROGRAM} brings no samples ({why}): `sistap doctor -i '{self.name}'` says "
                    "what is missing"
                )
            text += chunk.data
            arrived_ns = chunk.time_ns
        with suppress(ValueError):  # for a rate that it does not state
            self._samplerate = hertz((match["rate"] or b"").decode(errors="replace"))
        # The first sample is at least as old as the data that came with it.
        self._clock = SampleClock(arrived_ns, self._samplerate)
        self._channels = [
            _Channel(name, Uart(self._samplerate, self.settings), inverted, number)
            for name, inverted, number in zip(probe.channels, probe.inverted, self._numbers(probe), strict=False)
        ]
        self._take(_Chunk(arrived_ns, text[match.end() :]))

    def _numbers(self, probe: Probe) -> Iterable[int]:
        return (1, 2) if len(probe.channels) > 1 else (self.line,)

    def _take(self, chunk: _Chunk) -> None:
        """Decode the complete lines: for each channel in turn its name, a colon, and its samples in groups."""
        *lines, self._text = (self._text + chunk.data).split(b"\n")
        found: list[Read] = []
        for channel in self._channels:
            begin = channel.begin
            texts = b"".join(text[len(begin) :] for text in lines if text.startswith(begin))
            samples = texts.translate(None, _NOT_BITS)
            found += self._characters(channel, samples.translate(_SWAPPED) if channel.inverted else samples)
        if len(self._channels) > 1:
            found.sort(key=lambda read: read.time_ns)
        self._reads.extend(found)
        if lost_ns := self._clock.lost_ns(chunk.time_ns, self._channels[0].edges.now):
            self._clock.skip(lost_ns)
            for channel in self._channels:
                channel.lost = Flag.LOST_BEFORE

    def _characters(self, channel: _Channel, samples: bytes) -> Iterable[Read]:
        uart, clock = channel.uart, self._clock
        uncertainty_ns = clock.uncertainty_ns
        for start, value, flag in uart.feed(channel.hear(samples), channel.edges.now):
            flags = bytes([flag | channel.lost])
            channel.lost = Flag(0)
            time_ns = clock.time_ns(start) + uart.stop_ns
            yield Read(channel.line, time_ns, bytes([value]), flags, uncertainty_ns, self.settings)


def _check(port: str, settings: LineSettings, samplerate: int) -> None:
    """Refuse a rate if the sample rate is too low for it. Raise PortError."""
    if settings.baud * FEWEST_SAMPLES > samplerate:
        raise PortError(
            f"{port} cannot do {settings.baud} Bd with {samplerate} samples a second: "
            f"set &samplerate={settings.baud * ENOUGH_SAMPLES} or more"
        )


class _Channel:
    """One line, and what is heard on it."""

    def __init__(self, name: str, uart: Uart, inverted: bool, line: int) -> None:
        self.begin = name.encode() + b":"
        self.uart = uart
        self.inverted = inverted
        self.line = line
        self.lost = Flag(0)  # flags of the next character
        self.edges = Edges()
        self._heard: deque[int] = deque(maxlen=_HEARD)

    def hear(self, samples: bytes) -> list[int]:
        """Return the edges in these samples."""
        edges = self.edges.feed(samples)
        self._heard.extend(edges)
        return edges

    def heard(self) -> Trace:
        """Return the newest edges."""
        is_high = self.edges.is_high == (len(self._heard) % 2 == 0)
        return Trace(tuple(self._heard), is_high, self.edges.now)


class SampleClock:
    """The wall time of each sample, and whether samples are missing."""

    _LOST_NS = 50_000_000  # samples that are permanently later than this are lost
    _LOOK_NS = _NS
    _LOOKS = 3  # consecutive looks that count as permanent

    def __init__(self, now_ns: int, samplerate: int) -> None:
        self._samplerate = samplerate
        self._begin_ns = CLOCK.wall_ns(now_ns)
        self.uncertainty_ns = -(-2 * _NS // samplerate)
        self._monotonic_ns = now_ns
        self._looked_ns = now_ns
        self._least_ns: int | None = None  # smallest delay of samples since the last look
        self._late_ns: deque[int] = deque(maxlen=self._LOOKS + 1)  # the same for each look

    def time_ns(self, sample: int) -> int:
        """Return the wall time of a sample."""
        return self._begin_ns + sample * _NS // self._samplerate

    def lost_ns(self, now_ns: int, samples: int) -> int:
        """Return for how long nothing was sampled, given the number of samples so far; 0: none are missing.

        Delayed samples arrive in the end. So samples are missing if none in the last looks was as early as before. The
        crystal's drift is far slower.
        """
        late_ns = now_ns - self._monotonic_ns - samples * _NS // self._samplerate
        self._least_ns = late_ns if self._least_ns is None else min(self._least_ns, late_ns)
        if now_ns - self._looked_ns < self._LOOK_NS:
            return 0
        self._looked_ns = now_ns
        self._late_ns.append(self._least_ns)
        self._least_ns = None
        before, *since = self._late_ns
        lost_ns = min(since, default=before) - before
        return lost_ns if len(since) == self._LOOKS and lost_ns > self._LOST_NS else 0

    def skip(self, lost_ns: int) -> None:
        """Shift the times of the next samples by that much."""
        self._begin_ns += lost_ns
        self._monotonic_ns += lost_ns
        self._late_ns.clear()
        self._least_ns = None


class _Chunk(NamedTuple):
    """What came at once; without data: the end."""

    time_ns: int  # on the monotonic clock
    data: bytes


class _Process:
    """sigrok-cli, and a thread that reads its output: the analyser must not wait while a disk is slow."""

    def __init__(self, probe: Probe, samplerate: int) -> None:
        """Start it. PortError if it is not installed."""
        path = program()
        if not path:
            raise PortError(MISSING)
        with Complaints() as self._complaints:
            self._process = subprocess.Popen(
                [
                    *(path, "-d", probe.driver, "--config", f"samplerate={samplerate}", "--continuous"),
                    *("-C", ",".join(probe.channels), "-O", f"bits:width={_WIDTH}"),
                ],
                stdin=subprocess.PIPE,  # it runs until this closes
                stdout=subprocess.PIPE,
                stderr=self._complaints.stream,
                start_new_session=True,  # Ctrl-C is for sistap alone
            )
        _widen(self._process)
        self._chunks: Queue[_Chunk] = Queue(_CHUNKS)
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def chunk(self, timeout_s: float) -> _Chunk | None:
        """Return what came; None if nothing came in that time."""
        try:
            return self._chunks.get(timeout=timeout_s) if timeout_s else self._chunks.get_nowait()
        except Empty:
            return None

    def words(self) -> str:
        """Return the last line of its error output."""
        lines = self._complaints.text().split("\n")
        said = [line.strip().rstrip(".") for line in lines if line.strip()]
        return said[-1] if said else ""

    def end(self) -> None:
        """End it; the analyser stops first."""
        with suppress(OSError):
            assert self._process.stdin
            with self._process.stdin as key:
                key.write(b"\n")  # any key ends it
        try:
            self._process.wait(END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        while self._thread.is_alive():  # the thread may wait for room in the queue
            self.chunk(0.01)

    def _listen(self) -> None:
        assert self._process.stdout
        with self._process.stdout as stream:
            while data := stream.read1(_CHUNK):  # type: ignore[attr-defined]
                self._chunks.put(_Chunk(monotonic_ns(), data))
        self._chunks.put(_Chunk(monotonic_ns(), b""))


def _widen(process: subprocess.Popen[bytes]) -> None:
    """Enlarge the buffer of the pipe, if the system can."""
    if sys.platform == "linux":
        import fcntl

        assert process.stdout
        with suppress(OSError):
            fcntl.fcntl(process.stdout, fcntl.F_SETPIPE_SZ, _PIPE_BYTES)
