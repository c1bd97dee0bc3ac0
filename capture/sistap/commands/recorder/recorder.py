# SPDX-License-Identifier: GPL-2.0-or-later
"""The recorder beside a capture: a thread, so that neither tshark nor the disk ever delays a reader."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from sistap.commands.recorder import retention
from sistap.commands.recorder.keeper import Around, Beginning, Keeper, KeptFile
from sistap.commands.recorder.notifier import Notifier
from sistap.commands.recorder.reasons import Judge, Reason
from sistap.commands.recorder.retention import pack
from sistap.dissected.explain.relay import Entry, JudgedEntry, Relay, Seams
from sistap.dissected.explain.running import Running
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files.output import Output, OutputError, OutputRefused
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import Blocks, PcapngWriter
from sistap.tap.line import priority
from sistap.tap.records.before import Heard, heard
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import KEPT, Event, Record
from sistap.tap.sis import telegram
from sistap.tap.sis.initialization import INITIALIZATION, SET_LIMITS, certain
from sistap.tap.sis.limits import NAMES

PATIENCE_S = 30.0  # at the end, for tshark
MOST_WAITING = 200_000  # records; above this, the disk does not answer
_TURN_S = 0.05  # pause of the thread, in which records gather
_TURN = 20  # records at a time; then a reader can have its turn
_TIDY_S = 60.0  # interval between looks at the files of the full ring
_ENOUGH = 100  # telegrams; a master that starts the bus sets its limits earlier
_NO_LIMIT = (
    "No limit is known: late reactions and slow characters are not kept. The master set the limits before. "
    "If you know them, give --tza MS --trs MS"
)


@dataclass(frozen=True)
class Wanted:
    """The settings of a recorder."""

    folder: Path
    judges: Sequence[Judge]
    around: Around
    at_most: int
    command: str | None = None
    ring_files: int | None = None  # files of the full ring, if there is one; None: all
    compress: bool = False  # complete files


class Recorder:
    """A sink that keeps what matters; `ring` is an optional sink of all records."""

    def __init__(  # noqa: PLR0913 - it puts the parts together
        self,
        wanted: Wanted,
        tshark: Tshark,
        interfaces: Mapping[int, Interface],
        say: Callable[[str], None],
        *,
        ring: PcapngWriter | None = None,
        seams: Seams = Seams(),  # noqa: B008 - the default is frozen
    ) -> None:
        self._wanted = wanted
        self._tshark = tshark
        self._blocks = Blocks(interfaces)
        self._say = say
        self._ring = ring
        self._newest = ""  # name of the kept file that is written, or was last
        self._rings = (
            retention.ring(wanted.folder, wanted.ring_files, say, lambda: ring.output.open_names) if ring else None
        )
        self._kept_files = retention.kept(wanted.folder, wanted.at_most, say, lambda: [self._newest])
        self._notifier = Notifier(wanted.command, say)
        self._unlimited = Unlimited(say)
        self._started: tuple[Record, ...] = ()
        self._queue: queue.SimpleQueue[Entry | int | None] = queue.SimpleQueue()  # an int: nothing came until then
        self._left_out = 0
        self._tidy_s = 0.0  # time of the next look
        self._trouble = ""
        self.disk_trouble, self._not_packed, self._untidy = _TroubleOnce(say), _TroubleOnce(say), _TroubleOnce(say)
        self.kept = 0  # files
        self.relays = [
            Relay(partial(self._start, judge), judge.columns, say, finds=judge.finds, seams=seams)
            for judge in wanted.judges
        ]
        self._judged: list[deque[JudgedEntry]] = [deque() for _ in self.relays]  # what not all have judged
        self._thread: threading.Thread | None = None

    def summary(self, counters: Counters) -> str:
        """Return what was heard, and what was kept."""
        count = max((relay.unjudged for relay in self.relays), default=0)
        unjudged = f"; {count} records were not tested with the filter" if count else ""
        return f"{counters}; {self.kept} file{'' if self.kept == 1 else 's'} kept in {self._wanted.folder}{unjudged}"

    # -- In the thread of the capture

    def begin(self, *started: Record) -> None:
        """Begin with events that describe how the capture is taken."""
        if self._ring:
            self._ring.begin(*started)
        self._started = started
        for record in started:
            self._unlimited.take(heard(record))
        heading = self._blocks.section()
        self._keeper = Keeper(self._wanted.around, self._begin, heading, self._say)
        for relay in self.relays:
            relay.begin(self._blocks, heading, started)
        self._thread = threading.Thread(target=self._run, args=(priority.is_real_time(),), daemon=True)
        self._thread.start()

    def write(self, record: Record) -> bool:
        """Take a record."""
        if self._ring:
            self._ring.write(record)
        self._check()
        if self._trouble:
            return True
        if not self.relays:
            return True
        if self._queue.qsize() >= MOST_WAITING:
            self._left_out += 1
            return True
        if interface := self._blocks.interface(record.line):
            self._queue.put(Entry(record.time_ns, interface, is_packet=False))
        said = heard(record)
        self._unlimited.take(said)
        self._queue.put(Entry(record.time_ns, self._blocks.packet(record), said))
        return True

    def look(self, time_ns: int) -> None:
        """Complete records that are due while the line is silent."""
        if self._ring:
            self._ring.look(time_ns)
        self._check()
        if self._queue.empty():
            self._queue.put(time_ns)

    def end(self, time_ns: int) -> None:
        """End all."""
        if self._ring:
            self._ring.end(time_ns)
        self.close()
        self._check()
        if self._trouble:
            raise OutputError(self._trouble)

    def close(self) -> None:
        """End the thread after its remaining work."""
        if self._thread:
            self._queue.put(None)
            self._thread.join(PATIENCE_S * len(self.relays) + 5)
            self._thread = None

    def _check(self) -> None:
        """Without a ring, a recorder that has failed keeps nothing: then the capture must not seem to go on."""
        if self._trouble and not self._ring:
            raise OutputError(self._trouble)
        if self._left_out and self._queue.qsize() < MOST_WAITING // 2:
            left_out, self._left_out = self._left_out, 0
            self._say(f"{self._wanted.folder} is too slow: {left_out} records were not tested with the filter")

    # -- In its own thread

    def _run(self, is_urgent: bool) -> None:
        if is_urgent:  # a reader's thread must not wait for a holder of the lock that other programs delay
            priority.take_real_time()
        try:
            while self._turn():
                if time.monotonic() >= self._tidy_s:
                    self._tidy()
            self._keep_all([relay.finish(PATIENCE_S) for relay in self.relays])
            self._keeper.end()
        except Exception as error:  # noqa: BLE001 - whatever it is, the ring goes on
            self._trouble = f"the recorder has failed: {error!r}"
            if self._ring:
                self._say(f"{self._trouble}; the ring goes on")
        finally:
            for relay in self.relays:
                relay.close()

    def _turn(self) -> bool:
        """Process what has come; return whether to continue."""
        silent_ns = 0
        for _ in range(_TURN):
            try:
                item = self._queue.get_nowait()
            except queue.Empty:
                break
            if item is None:
                return False
            if isinstance(item, Entry):
                for relay in self.relays:
                    relay.put(item)
            else:
                silent_ns = item
        self._keep_all([relay.look() for relay in self.relays])
        self._notifier.reap()
        if silent_ns and all(relay.empty for relay in self.relays):
            self._keep_silence(silent_ns)
        time.sleep(_TURN_S if self._queue.empty() else 0)
        return True

    def _keep_all(self, more: Iterable[Iterable[JudgedEntry]]) -> None:
        """Keep what all have judged by now."""
        for waiting, judged in zip(self._judged, more, strict=True):
            waiting.extend(judged)
        while self._judged and all(self._judged):
            self._keep([waiting.popleft() for waiting in self._judged])

    def _keep(self, same: Sequence[JudgedEntry]) -> None:
        """Keep a block if one of the judges has a reason; the first one counts."""
        told = [judge.reason(judged) for judge, judged in zip(self._wanted.judges, same, strict=True)]
        reason = next(filter(None, told), Reason(""))
        self._keeper.take(same[0].entry, *reason)

    def _keep_silence(self, now_ns: int) -> None:
        for judge in self._wanted.judges:
            if reason := judge.silent(now_ns):
                self._keeper.keep(now_ns, reason.word, reason.from_ns or now_ns)
        self._keeper.look(now_ns)

    def _start(self, judge: Judge, token: bytes | None) -> Running:
        return Running(self._tshark, judge.arguments(token))

    def _begin(self, beginning: Beginning) -> KeptFile:
        time_ns = beginning.time_ns
        path = retention.new_name(self._wanted.folder, time_ns, beginning.reason)
        self._newest = path.name
        when = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(time_ns // 1_000_000_000))
        why = f"{KEPT}{beginning.reason} at {when}.{time_ns // 1_000_000 % 1000:03d}"
        started = [self._again(record, beginning, why) for record in self._started]
        packets = b"".join(map(self._blocks.packet, [*started, *beginning.known]))
        return _RecorderFile(self, path, time_ns, beginning.heading + packets)

    def _again(self, started: Record, beginning: Beginning, why: str) -> Record:
        settings = beginning.known[-1].settings if beginning.known else started.settings
        data = started.data + why.encode() if started.event == Event.CAPTURE_STARTED else started.data
        return started._replace(time_ns=beginning.first_ns, settings=settings, data=data)

    def complete(self, path: Path) -> None:
        """Announce a complete file."""
        self.disk_trouble.end()
        self.kept += 1
        if self._wanted.compress:
            path = self._pack(path)
        self._newest = path.name
        self._tidy()
        self._notifier.notify(path)

    def _pack(self, path: Path) -> Path:
        """Compress a file if that is possible; return its name."""
        try:
            packed = pack(path)
        except OSError as error:
            self._not_packed.tell(path, f" cannot be compressed: {error.strerror}; it stays as it is")
            return path
        self._not_packed.end()
        return packed

    def _tidy(self) -> None:
        self._tidy_s = time.monotonic() + _TIDY_S
        try:
            for files in (self._kept_files, self._rings):
                if files:
                    files.prune()
            if self._rings and self._wanted.compress:
                for path in self._rings.complete():
                    self._pack(path)
            self._untidy.end()
        except OSError as error:
            self._untidy.tell(self._wanted.folder, f": {error.strerror}; nothing can be kept there until it is back")


class _TroubleOnce:
    """Trouble with files that is reported once until it ends, although the next file has another name."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._told = ""

    def tell(self, path: Path, trouble: str) -> None:
        if trouble != self._told:
            self._say(f"{path}{trouble}")
        self._told = trouble

    def end(self) -> None:
        self._told = ""


class _RecorderFile:
    """A file of the recorder. Write errors are reported, and the data left out."""

    def __init__(self, recorder: Recorder, path: Path, time_ns: int, beginning: bytes) -> None:
        self._recorder = recorder
        self._path = path
        self._time_ns = time_ns
        self._output: Output | None = None
        try:
            self._output = Output(str(path), is_new=True)
            self._output.begin()
        except OutputRefused as error:
            self._tell(str(error).removeprefix(str(path)))
        except FileExistsError:
            self._tell(" is there already: nobody else should write to this folder")
        self.write(beginning)

    def write(self, block: bytes) -> None:
        if not self._output:
            return
        try:
            self._output.write(block)
        except OutputError as error:
            self._tell(str(error).removeprefix(str(self._path)))
            self._output.close()
            self._output = None

    def _tell(self, trouble: str) -> None:
        self._recorder.disk_trouble.tell(self._path, trouble)

    def close(self, reasons: Collection[str]) -> None:
        if not self._output:
            return
        self._output.close()
        with suppress(OSError), self._path.open("rb+") as file:  # so that the file survives a power cut
            os.fsync(file.fileno())
        if len(reasons) > 1:  # the first alone would hide a worse one
            with suppress(OSError):
                self._path = self._path.rename(retention.new_name(self._path.parent, self._time_ns, *reasons))
        self._recorder.complete(self._path)


class Unlimited:
    """Looks for a limit in the first telegrams of a capture, and says once that there is none: without it, nothing is
    late, and no file of it is kept.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        """`say` gets the advice."""
        self._say = say
        self._left = _ENOUGH  # telegrams to look at; 0: nothing more to say

    def take(self, heard: Heard) -> None:
        """Take what a record says of its bus."""
        if not self._left:
            return
        if heard.limits or (heard.telegram and _sets_limit(heard.telegram)):
            self._left = 0
        elif heard.telegram:
            self._left -= 1
            if not self._left:
                self._say(_NO_LIMIT)


def _sets_limit(data: bytes) -> bool:
    header = telegram.parse(data)
    return (
        header.service == INITIALIZATION
        and not header.reaction
        and any(SET_LIMITS.get(setting.subservice) in NAMES.values() for setting in certain(header.body))
    )
