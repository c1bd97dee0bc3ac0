# SPDX-License-Identifier: GPL-2.0-or-later
"""From reads to records in a sink: which, when, in which order and with which times. All clocks are simulated."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest
from specification import TELEGRAMS

from sistap.tap.capture import session
from sistap.tap.capture.session import Capture
from sistap.tap.capture.tap import Conditions
from sistap.tap.files.output import FileLimits, Output
from sistap.tap.line.reader import PortLost, Reader
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.counters import Counters
from sistap.tap.records.cut import Cut
from sistap.tap.records.record import Event, Framing, Record, Type
from sistap.tap.terminal.stop import Stop

pytestmark = pytest.mark.tap

MS = 1_000_000
SECOND = 1000 * MS
EPOCH = 1_700_000_000 * SECOND  # when a capture begins, by the clock of its line ...
BOOTED = 77 * SECOND  # ... and by its own
SETTINGS = LineSettings()
GOOD, OTHER_GOOD = TELEGRAMS["8-20"], TELEGRAMS["8-21"]
BEGINNING = b"\x02\x00\xff\xff"  # what may become a telegram, and holds back what follows


Came = tuple[int, Read]  # how long the capture has been running, and what it reads then


class Clock:
    """The monotonic one of a capture; `ns` counts from its beginning."""

    def __init__(self) -> None:
        self.ns = 0

    def __call__(self) -> int:
        return BOOTED + self.ns


class ScriptedReader:
    """Returns each read when its time has come; then the port is lost."""

    name, adapter, timing = "/dev/ttyTEST", "adapter of a test", "uncertainty 1 us"
    notes: tuple[str, ...] = ()

    def __init__(self, clock: Clock, script: Sequence[Came], line: int = 0, end_ns: int = 0) -> None:
        self.settings = SETTINGS
        self.line = line
        self._clock = clock
        self._script = list(script)
        self._end_ns = end_ns or (script[-1][0] if script else 0)

    def read(self, timeout_s: float) -> Read | None:
        due_ns = self._script[0][0] if self._script else self._end_ns
        waited_ns = max(due_ns, self._clock.ns)
        self._clock.ns = min(waited_ns, self._clock.ns + int(timeout_s * 1e9))
        if self._clock.ns < due_ns:
            return None
        if not self._script:
            raise PortLost("it is gone", self.line)
        return self._script.pop(0)[1]

    def change(self, settings: LineSettings) -> None:
        self.settings = settings

    def close(self) -> None:
        pass


class Sink:
    """Remembers its records, and how long the capture had been running."""

    def __init__(self, clock: Clock) -> None:
        self.written: list[tuple[int, Record]] = []
        self.looked: list[tuple[int, int]] = []
        self.ended_ns = -1
        self._clock = clock

    def begin(self, *started: Record) -> None:
        pass

    def write(self, record: Record) -> bool:
        self.written.append((self._clock.ns, record))
        return True

    def look(self, time_ns: int) -> None:
        self.looked.append((self._clock.ns, time_ns))

    def end(self, time_ns: int) -> None:
        self.ended_ns = time_ns

    @property
    def records(self) -> list[Record]:
        """Return the records without that of the lost port, which ends it."""
        return [record for _, record in self.written if record.event != Event.ADAPTER_LOST]

    @property
    def data(self) -> list[tuple[int, bytes]]:
        return [(record.line, record.data) for record in self.records if record.type != Type.EVENT]


class Told:
    """Remembers the messages to the user, and how long the capture had been running."""

    def __init__(self, clock: Clock) -> None:
        self.said: list[tuple[int, str]] = []
        self.alarms: list[str] = []
        self.progress_at: list[int] = []
        self._clock = clock

    def say(self, text: str) -> None:
        self.said.append((self._clock.ns, text))

    def alarm(self, text: str) -> None:
        self.alarms.append(text)

    def progress(self, text: str) -> None:
        self.progress_at.append(self._clock.ns)


class Running:
    """A capture, of one port by default."""

    def __init__(
        self,
        folder: Path,
        conditions: Conditions,
        *,
        output: Output | None = None,
        remote: Callable[[Capture], None] | None = None,
    ) -> None:
        self.clock = Clock()
        self.sink, self.console, self.counters = Sink(self.clock), Told(self.clock), Counters()
        self._output = output or Output(str(folder / "x"))
        self._conditions = conditions
        self._remote = remote
        self.stop = Stop()

    def run(self, script: Sequence[Came], *, end_ns: int = 0, readers: Sequence[Reader] = ()) -> int:
        """Run until something ends it, at the latest the loss of the port; return its exit code."""
        capture = Capture(
            readers or [ScriptedReader(self.clock, script, end_ns=end_ns)],
            self.sink,
            self._output,
            self.counters,
            self.console,
            self._conditions,
            quiet=True,
            progress=True,
            remote=self._remote,
            clock_ns=self.clock,
        )
        code = capture.run(self.stop)
        self._output.close()
        return code


def came(at_ns: int, data: bytes, line: int = 0, settings: LineSettings | None = None) -> Came:
    """Return a read and its time; the line's clock is another one."""
    return at_ns, Read(line, EPOCH + at_ns, data, bytes(len(data)), 1000, settings)


def take(folder: Path, *script: Came, end_ns: int = 0, conditions: Conditions | None = None) -> Running:
    """Capture until the port is lost."""
    running = Running(folder, conditions or Conditions())
    assert running.run(script, end_ns=end_ns) == 1
    return running


# -- When ------------------------------------------------------------------------------------------------------------


def test_a_telegram_is_written_with_its_last_character(tmp_path: Path) -> None:
    taken = take(tmp_path, came(10 * MS, GOOD[:3]), came(20 * MS, GOOD[3:]), end_ns=SECOND)
    at_ns, record = taken.sink.written[0]
    assert (at_ns, record.time_ns, record.data) == (20 * MS, EPOCH + 10 * MS, GOOD)


def test_what_is_unfinished_is_written_after_a_second_of_silence(tmp_path: Path) -> None:
    taken = take(tmp_path, came(50 * MS, GOOD[:3]), end_ns=3 * SECOND)
    at_ns, record = taken.sink.written[0]
    assert record.data == GOOD[:3]
    assert 1050 * MS <= at_ns <= 1150 * MS


def test_the_time_of_an_event_goes_on_from_the_last_character(tmp_path: Path) -> None:
    """By the clock of its line, which is not the test's."""
    script = [came(1 * SECOND, GOOD, line=1), came(2 * SECOND, GOOD, line=2)]
    taken = take(tmp_path, *script, end_ns=5 * SECOND)
    lost = taken.sink.written[-1][1]
    assert (lost.event, lost.time_ns) == (Event.ADAPTER_LOST, EPOCH + 5 * SECOND)
    assert taken.sink.ended_ns == EPOCH + 5 * SECOND


def test_before_the_first_character_the_time_is_that_of_this_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class WallClock:
        def now_ns(self) -> int:
            return EPOCH

        def step_ns(self) -> int:
            return 0

    monkeypatch.setattr("sistap.tap.capture.tap.CLOCK", WallClock())
    assert take(tmp_path, end_ns=SECOND).sink.ended_ns == EPOCH


def test_a_file_may_end_only_where_nothing_is_held_back(tmp_path: Path) -> None:
    script = [came(500 * MS, GOOD[:3]), came(900 * MS, GOOD[3:])]
    taken = take(tmp_path, *script, end_ns=1500 * MS)
    looked = [at_ns for at_ns, _ in taken.sink.looked]
    assert looked and not [at_ns for at_ns in looked if 500 * MS <= at_ns < 900 * MS]
    assert all(time_ns == EPOCH + at_ns for at_ns, time_ns in taken.sink.looked if at_ns > 900 * MS)


def test_a_file_does_not_end_while_a_record_waits_for_the_other_line(tmp_path: Path) -> None:
    script = [came(100 * MS, GOOD[:3], line=1), came(110 * MS, GOOD, line=2)]
    taken = take(tmp_path, *script, end_ns=450 * MS)
    assert not [at_ns for at_ns, _ in taken.sink.looked if 100 * MS <= at_ns < 450 * MS]


def test_the_other_line_does_not_keep_a_silent_one_waiting(tmp_path: Path) -> None:
    waiting = came(100 * MS, BEGINNING + GOOD, line=1)
    busy = [came(at_ns, b"x", line=2) for at_ns in range(150 * MS, 4000 * MS, 50 * MS)]
    taken = take(tmp_path, waiting, *busy)
    at_ns = next(at_ns for at_ns, record in taken.sink.written if record.data == GOOD)
    assert 1100 * MS <= at_ns <= 2100 * MS  # a second of silence, and at most one until it is looked at


# -- In which order --------------------------------------------------------------------------------------------------


def test_what_began_first_is_written_first_but_waits_no_longer_than_half_a_second(tmp_path: Path) -> None:
    script = [
        came(100 * MS, GOOD[:3], line=1),
        came(110 * MS, OTHER_GOOD, line=2),
        came(300 * MS, GOOD[3:], line=1),
        came(2000 * MS, GOOD[:3], line=1),
        came(2010 * MS, OTHER_GOOD, line=2),
        came(2900 * MS, GOOD[3:], line=1),
    ]
    taken = take(tmp_path, *script, end_ns=5 * SECOND)
    assert taken.sink.data == [(1, GOOD), (2, OTHER_GOOD), (2, OTHER_GOOD), (1, GOOD)]
    written = [at_ns for at_ns, record in taken.sink.written if record.line == 2]
    assert written[0] == 300 * MS
    assert 2510 * MS <= written[1] <= 2610 * MS


def test_at_the_end_everything_is_written(tmp_path: Path) -> None:
    script = [came(100 * MS, BEGINNING + GOOD, line=1), came(110 * MS, OTHER_GOOD[:4], line=2)]
    taken = take(tmp_path, *script)
    assert taken.sink.data == [(1, BEGINNING), (1, GOOD), (2, OTHER_GOOD[:4])]


# -- Which -----------------------------------------------------------------------------------------------------------


class OnlyReactions:
    """As a compiled filter."""

    def matches(self, data: bytes) -> bool:
        return bool(data[4] & 0x10)


def test_a_filter_leaves_out_frames_only_and_all_are_counted(tmp_path: Path) -> None:
    conditions = Conditions(only=OnlyReactions())  # type: ignore[arg-type]
    taken = take(tmp_path, came(MS, b"text" + GOOD + OTHER_GOOD), conditions=conditions)
    assert taken.sink.data == [(0, b"text"), (0, OTHER_GOOD)]
    assert (taken.counters.received[0], taken.counters.accepted[0]) == (3, 2)


def test_a_count_ends_it_within_a_read_and_all_are_counted(tmp_path: Path) -> None:
    running = Running(tmp_path, Conditions(count=2))
    assert running.run([came(MS, GOOD * 3)], end_ns=SECOND) == 0
    assert running.sink.data == [(0, GOOD)] * 2
    counters = running.counters
    assert (counters.received[0], counters.accepted[0], counters.characters) == (3, 2, 3 * len(GOOD))


def test_a_stop_takes_what_waits_for_no_longer_than_a_tenth_of_a_second(tmp_path: Path) -> None:
    """However fast characters come."""
    running = Running(tmp_path, Conditions())

    class Flood(ScriptedReader):
        def read(self, timeout_s: float) -> Read | None:
            if timeout_s:
                running.stop.ask()
                return None
            running.clock.ns += 10 * MS
            return came(running.clock.ns, GOOD)[1]

    assert running.run([], readers=[Flood(running.clock, [])]) == 0
    assert running.clock.ns == 100 * MS
    assert running.sink.data == [(0, GOOD)] * 10


def test_lines_of_one_port_have_framers_of_their_own(tmp_path: Path) -> None:
    conditions = Conditions(Cut(Framing.SILENCE, 5))
    taken = take(tmp_path, came(MS, b"ab", line=1), came(2 * MS, b"cd", line=2), conditions=conditions)
    assert [(record.framing, record.data) for record in taken.sink.records] == [
        (Framing.SILENCE, b"ab"),
        (Framing.SILENCE, b"cd"),
    ]


def test_a_duration_ends_it_to_the_moment(tmp_path: Path) -> None:
    running = Running(tmp_path, Conditions(duration_s=1))
    assert running.run([], end_ns=5 * SECOND) == 0
    assert running.clock.ns == SECOND


def test_a_full_file_ends_it(tmp_path: Path) -> None:
    running = Running(tmp_path, Conditions(), output=Output(str(tmp_path / "x"), FileLimits(size=0)))
    assert running.run([came(MS, GOOD)]) == 0
    assert running.sink.data == []


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no pipes that are files")
def test_a_reader_of_the_output_who_goes_ends_it_though_nothing_comes(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    running = Running(tmp_path, Conditions(), output=Output(str(tmp_path / "pipe")))
    os.close(reader)
    assert running.run([], end_ns=5 * SECOND) == 1
    assert running.console.alarms == [f"the reader of {tmp_path}/pipe is gone; the capture has ended"]


# -- With which settings ---------------------------------------------------------------------------------------------


def test_characters_with_other_settings_follow_an_event_and_never_join_those_before(tmp_path: Path) -> None:
    fast = LineSettings(57600)
    script = [
        came(10 * MS, GOOD[:3], settings=SETTINGS),
        came(20 * MS, b"", settings=fast),  # nothing was read with them yet
        came(30 * MS, GOOD, settings=fast),
        came(40 * MS, GOOD, settings=fast),
    ]
    taken = take(tmp_path, *script)
    found = [(record.time_ns - EPOCH, record.type, record.event, record.settings) for record in taken.sink.records]
    assert found == [
        (10 * MS, Type.OTHER, Event.NONE, SETTINGS),
        (30 * MS, Type.EVENT, Event.SETTINGS_CHANGED, fast),
        (30 * MS, Type.FRAME, Event.NONE, fast),
        (40 * MS, Type.FRAME, Event.NONE, fast),
    ]
    assert taken.sink.records[1].data.startswith(b"57600 Bd 8E1: ")


# All shall have 57600 Bd, and accept it (checksums by hand).
TOLD = bytes.fromhex("02 DB 03 03 00 03 10 FF 00 07 04")
ACCEPT = TELEGRAMS["6-24"]


@pytest.mark.parametrize("held_back", [b"", BEGINNING])
def test_what_the_bus_is_told_is_followed_also_when_only_silence_completes_it(tmp_path: Path, held_back: bytes) -> None:
    taken = take(
        tmp_path,
        came(10 * MS, held_back + TOLD + ACCEPT),
        came(3 * SECOND, GOOD, settings=LineSettings(57600)),
        conditions=Conditions(follow=True),
    )
    changed = [record for record in taken.sink.records if record.event == Event.SETTINGS_CHANGED]
    assert [record.data for record in changed] == [b"57600 Bd 8E1: 16 let all accept 57600 Bd"]
    assert [text for _, text in taken.console.said] == ["57600 Bd 8E1: 16 let all accept 57600 Bd"]


def test_settings_that_are_only_tried_are_noted_but_not_told(tmp_path: Path) -> None:
    running = Running(tmp_path, Conditions(formats=("8E1", "8N1")))
    running.run([came(10 * MS, b"x"), came(20 * MS, b"x", settings=LineSettings(19200))])
    assert [record.event for record in running.sink.records if record.data != b"x"] == [Event.SETTINGS_CHANGED]
    assert running.console.said == []


# -- What people and programs are told, and ask for ------------------------------------------------------------------


class Listener:
    """A program that controls the capture, and asks for a marker at once."""

    asked = False

    def __call__(self, capture: Capture) -> None:
        if not self.asked:
            capture.mark("the axis stopped")
        self.asked = True


def test_a_marker_is_an_event(tmp_path: Path) -> None:
    running = Running(tmp_path, Conditions(), remote=Listener())
    running.run([came(10 * MS, GOOD)])
    assert [(record.event, record.data) for record in running.sink.records if record.type == Type.EVENT] == [
        (Event.MARKER, b"the axis stopped")
    ]


def test_progress_comes_every_second_and_a_hint_when_nothing_has_come_for_five(tmp_path: Path) -> None:
    running = Running(tmp_path, Conditions())
    running.run([], end_ns=7500 * MS)
    assert running.console.progress_at == [second * SECOND for second in range(1, 8)]
    ((at_ns, hint),) = running.console.said
    assert at_ns == 5 * SECOND
    assert hint.startswith("nothing received for 5 s")


# -- Two ports -------------------------------------------------------------------------------------------------------


class Either:
    """Two readers as one: of waiting reads, the earlier comes first."""

    def __init__(self, clock: Clock, script: Sequence[Came], end_ns: int) -> None:
        self.read = ScriptedReader(clock, script, line=1, end_ns=end_ns).read


def test_each_of_two_ports_is_counted_and_told_of_by_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    running = Running(tmp_path, Conditions(duration_s=7.5))
    readers = [ScriptedReader(running.clock, [], line) for line in (1, 2)]
    script = [came(i * 100 * MS, GOOD + b"text" * 10, line=2) for i in range(1, 70)]

    @contextmanager
    def together(readers: object, *, may_change: bool) -> Iterator[Either]:
        yield Either(running.clock, script, 8 * SECOND)

    monkeypatch.setattr(session, "together", together)
    assert running.run([], readers=readers) == 0
    # Line 2 has characters, and among them telegrams: there is nothing to say of it.
    assert [text.partition(":")[0] for _, text in running.console.said] == ["line 1"]
    assert running.counters.characters == 69 * (len(GOOD) + 40)
    assert running.counters.telegrams == 69
