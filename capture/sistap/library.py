# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap as a library: records and telegrams of a port, of a file or of the virtual bus, and a capture to write to.

    import sistap

    with sistap.Tap("/dev/ttyUSB0", baud=19200) as tap, sistap.Writer("night.pcapng") as capture:
        for record in tap:
            capture.write(record)
            print(record.telegram)

A `Record` is a telegram, other characters, or an event of the tap. `Record.characters()` has the time and the flags of
each character, `Record.telegram` what a telegram says. Times are ns since 1970. Nothing is ever written to a port. All
errors are an `Error`, but a wrong argument is a TypeError or ValueError, and a missing file an OSError.
"""

from __future__ import annotations

import functools
import importlib
import inspect
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, closing, contextmanager
from os import PathLike, fspath
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, ParamSpec, Self, TypeVar

from sistap.dissected.captures import reading
from sistap.dissected.captures.stream import Stream
from sistap.dissected.telegrams.interpreter import Interpreter, Record, Telegram
from sistap.tap.capture.options import CaptureOptions, checked, rate
from sistap.tap.capture.running import Ports, conditions
from sistap.tap.capture.session import READ_TIMEOUT_S, Capture
from sistap.tap.files.output import Output, OutputError, OutputRefused
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, SECTION_HEADER, Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.line.reader import PortError, PortLost
from sistap.tap.line.settings import Flag, LineSettings
from sistap.tap.records.counters import Counters
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.record import Character, Event, Framing, Type
from sistap.tap.records.record import Record as BareRecord
from sistap.tap.sis.limits import milliseconds
from sistap.tap.sis.rates import RATES
from sistap.tap.terminal.exits import NotCaptured, Refusal
from sistap.tap.terminal.exits import Refusal as Error

if TYPE_CHECKING:
    from sisbus.library import Live
    from sistap.commands.annotate.sources import SourceError
    from sistap.dissected.packets.dissection import Packet
    from sistap.dissected.wireshark.tshark import TsharkError

__all__ = [
    "Character",
    "Error",
    "Event",
    "Flag",
    "Framing",
    "LineSettings",
    "NotCaptured",
    "OutputError",
    "OutputRefused",
    "Packet",
    "PortError",
    "PortLost",
    "Record",
    "SourceError",
    "Tap",
    "Telegram",
    "TsharkError",
    "Type",
    "Writer",
    "dissect",
    "play",
    "read",
]

# Names of rooms that take long to load, and that few programs need.
_LATE = {
    "SourceError": "sistap.commands.annotate.sources",
    "Packet": "sistap.dissected.packets.dissection",
    "TsharkError": "sistap.dissected.wireshark.tshark",
}
_LOG = logging.getLogger("sistap")
_GZIP = b"\x1f\x8b"
_PCAPNG = SECTION_HEADER.to_bytes(4)  # it reads the same from both ends
_SHORTEST_S = 0.001  # of a read: in no time at all, a reader gives up looking where a line error belongs

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


def __getattr__(name: str) -> object:
    if name in _LATE:
        return getattr(importlib.import_module(_LATE[name]), name)
    raise AttributeError(f"module 'sistap.library' has no attribute '{name}'")


def _naming(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """Make the TypeError of an unknown keyword name those that there are."""
    parameters = inspect.signature(function).parameters.values()
    names = [one.name for one in parameters if one.kind != one.VAR_POSITIONAL and one.name != "self"]
    what = function.__qualname__.removesuffix(".__init__")

    @functools.wraps(function)
    def named(*arguments: _Parameters.args, **keywords: _Parameters.kwargs) -> _Result:
        if unknown := [name for name in keywords if name not in names]:
            raise TypeError(f"{what} has no {unknown[0]}=; it has {', '.join(f'{name}=' for name in names)}")
        return function(*arguments, **keywords)

    return named


def _check(name: str, value: object, kinds: type | UnionType, right: str) -> None:
    """Refuse an argument of another type."""
    if not isinstance(value, kinds):
        raise TypeError(f"{name} is {right}, not {value!r}")


def _path(name: str, value: str | PathLike[str], more: str = "") -> str:
    """Return a path as text."""
    _check(name, value, str | PathLike, f"a text or a Path{more}")
    if not (path := fspath(value)):
        raise ValueError(f"{name} is empty")
    return path


def _seconds(name: str, value: float | None) -> float | None:
    _check(name, value, int | float | None, "a number of seconds")
    if value is not None and not value >= 0:
        raise ValueError(f"{name}={value!r} is neither None nor a number of seconds from 0 on")
    return value


def _limit(name: str, value: int | None) -> int | None:
    try:
        return None if value is None else milliseconds(str(value))
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


class _Collector:
    """A sink that keeps records until they are taken."""

    def __init__(self) -> None:
        self.records: deque[BareRecord] = deque()

    def begin(self, *started: BareRecord) -> None:
        self.records.extend(started)

    def write(self, record: BareRecord) -> bool:
        self.records.append(record)
        return True

    def look(self, time_ns: int) -> None:
        """Do nothing: there are no files."""

    def end(self, time_ns: int) -> None:
        """Do nothing: there are no files."""


class _Messages:
    """Messages for people go to the logger `sistap`; the reason of an end is kept."""

    alarms = ""

    def say(self, text: str) -> None:
        _LOG.info(text)

    def alarm(self, text: str) -> None:
        self.alarms = text

    def progress(self, text: str) -> None:
        """Show nothing."""


class Tap:
    """One port, or the two of a full-duplex line. Iterate over it, or read(). Each record comes once.

    It reads the port only then: the time of what waited is less exact, and the system keeps only some 4096 characters.
    One thread reads; any thread, or a signal handler, may close() it. A loop over a closed tap ends.
    """

    timeout: float | None  # s, of a read() that is not told another

    @_naming
    def __init__(  # noqa: PLR0913 - as `sistap capture`
        self,
        *ports: str | PathLike[str],
        baud: int | str = RATES[0],
        format: str | None = None,  # noqa: A002 - the word of the command
        framing: str = "sis",
        follow_baud: bool = False,
        tza_ms: int | None = None,
        trs_ms: int | None = None,
        timeout: float | None = None,
        duration_s: float | None = None,
    ) -> None:
        """Open one or two ports: a device, "bus://HOST:PORT", or "sigrok:DRIVER". PortError says what to do.

        The keywords are options of `sistap capture`, and a ValueError speaks of these: `baud` in Bd, or "auto";
        `format` as "8E1"; `framing` as sis, 3964r, ascii or silence:MS; the limits `tza_ms` and `trs_ms` of the bus.
        `timeout`: s that a read() waits; None: until something comes. After `duration_s` it ends by itself.
        """
        paths = [_path("a port", port, ' such as "/dev/ttyUSB0" (the rate is baud=9600)') for port in ports]
        _check("format", format, str | None, 'a text such as "8E1"')
        _check("framing", framing, str, 'a text such as "sis"')
        if len(paths) not in {1, 2}:
            raise ValueError(f"a tap has one port, or the two of a full-duplex line, not {len(ports)}")
        self.timeout = _seconds("timeout", timeout)
        options = CaptureOptions(
            paths,
            baud=rate(str(baud)),
            format=format,
            follow_baud=follow_baud,
            framing=Cut.parse(framing),
            tza_ms=_limit("tza_ms", tza_ms),
            trs_ms=_limit("trs_ms", trs_ms),
            autostop={} if duration_s is None else {"duration": _seconds("duration_s", duration_s) or 0.0},
        )
        try:
            plan = checked(options)
        except Refusal as error:
            raise ValueError(str(error)) from None
        self._sink, self._messages, self._interpreter = _Collector(), _Messages(), Interpreter()
        self._lock = threading.RLock()  # of whoever uses the capture
        self._holder = 0  # that thread
        self._is_closed = self._has_ended = False  # by close(); or by itself, and then records may wait to be read
        with ExitStack() as opened:
            readers = opened.enter_context(closing(Ports(options))).open(plan.settings, self._messages.say)
            self._capture = Capture(
                readers, self._sink, Stream(), Counters(), self._messages, conditions(options, plan.only)
            )
            self._capture.begin()
            opened.enter_context(self._capture.reading())
            self._opened = opened.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        self.close()

    @property
    def is_open(self) -> bool:
        """Tell whether records may still come: nobody has closed it, and it has not ended and been read to its end."""
        return not self._is_closed

    def close(self) -> None:
        """Close the ports; again, do nothing. A read() or loop of another thread ends within 0.1 s."""
        self._is_closed = True
        if self._holder != threading.get_ident():  # a signal handler: then the read that it interrupts ends
            self._look(0.0)

    def read(self, timeout: float | None = None) -> Record | None:
        """Return the next record; None if none came in `timeout` s (by default self.timeout), or the tap has ended.

        PortLost if the port has gone, PortError if the tap was closed before.
        """
        if self._is_closed and not self._sink.records:
            raise PortError("the tap is closed: open a new one, or ask is_open before read()")
        return self._next(_seconds("timeout", self.timeout if timeout is None else timeout))

    def __iter__(self) -> Iterator[Record]:
        """Yield records until the tap is closed or its time is over. PortLost if the port has gone."""
        while record := self._next(None):
            yield record

    def _next(self, timeout_s: float | None) -> Record | None:
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            left_s = READ_TIMEOUT_S if end_s is None else end_s - time.monotonic()
            self._look(left_s)
            if record := self._taken():
                return record
            if self._has_ended or left_s <= 0:
                return None

    def _look(self, most_s: float) -> None:
        """Read for so long at most, if nothing waits."""
        with self._lock, self._held():
            if not (self._has_ended or self._is_closed or self._sink.records):
                self._capture.turn(min(max(most_s, _SHORTEST_S), READ_TIMEOUT_S))
            if not self._has_ended and (self._is_closed or self._capture.is_over):
                self._has_ended = True
                self._capture.end()
                self._opened.close()

    @contextmanager
    def _held(self) -> Iterator[None]:
        self._holder = threading.get_ident()
        try:
            yield
        finally:
            self._holder = 0

    def _taken(self) -> Record | None:
        """Take the next record that waits. After the last one, PortLost if a port has gone, once."""
        if self._sink.records:
            return self._interpreter.take(self._sink.records.popleft())
        if self._has_ended:
            self._is_closed = True
            lost, self._messages.alarms = self._messages.alarms, ""
            if lost:
                raise PortLost(lost)
        return None


class Writer:
    """A capture that Wireshark opens."""

    @_naming
    def __init__(self, path: str | Path, *, description: str = "sistap", force: bool = False) -> None:
        """Begin a file. OutputRefused if it cannot be written, or has data and `force` is not set.

        `description` is what Wireshark calls the interface.
        """
        try:
            self._output = Output(_path("path", path), force=force)
        except OutputRefused as refused:
            raise OutputRefused(refused.what, "; choose another path, or overwrite it with force=True") from None
        self._counters = Counters()
        interface = Interface(LINKTYPE_WIRESHARK_UPPER_PDU, description)
        self._writer = PcapngWriter(self._output, {0: interface}, self._counters)
        self._writer.begin()
        self._end_ns = 0
        self._is_open = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        self.close()

    def write(self, record: BareRecord) -> None:
        """Write a record at once: a file that ends here is whole. OutputError if the disk takes no more."""
        if not self._is_open:
            raise OutputError("the file is closed: open another Writer")
        _check("what a Writer writes", record, BareRecord, "a Record")
        self._writer.write(record)
        self._counters.add_record(record)
        self._end_ns = record.end_ns

    def close(self) -> None:
        """End the file; again, do nothing."""
        if self._is_open:
            self._is_open = False
            self._writer.end(self._end_ns)
            self._output.close()


def read(path: str | Path) -> Iterator[Record]:
    """Yield the records of a capture of sistap, or the telegrams of a log of another program.

    NotCaptured or SourceError says what is wrong with the file, OSError that it cannot be read. The logger `sistap`
    says if it is cut off, or a log without telegrams.
    """
    with Path(path).open("rb") as file:
        begin = file.read(len(_PCAPNG))
    is_capture = begin == _PCAPNG or (begin.startswith(_GZIP) and str(path).endswith(".pcapng.gz"))
    yield from map(Interpreter().take, reading.records(Path(path), _LOG.warning) if is_capture else _of_log(path))


def _of_log(path: str | Path) -> Iterator[BareRecord]:
    from sistap.commands.annotate import sources
    from sistap.commands.annotate.annotating import Passage

    source = sources.look(str(path), SIS)
    passage = Passage(source.reader)
    for batch in source.lines(SIS, lambda _: None):
        for line in batch:
            yield from (cut.record for cut in passage.feed(line).cuts)
    yield from (cut.record for cut in passage.end())
    if not passage.telegrams:
        _LOG.warning(f"{path} has no telegram of SIS; bytes found in it: {passage.bytes}")


def dissect(source: str | Path | Iterable[BareRecord], *fields: str) -> Iterator[Packet]:
    """Yield the packets of a capture, of any that tshark reads, as Wireshark's dissector sees them. Times in s.

    `Packet` is what `sistap report` uses; `packet.columns` has the text of these fields of Wireshark, too. Of records,
    all are taken first: a Tap needs a duration_s. It runs the installed tshark: TsharkError if it cannot. NotCaptured
    if it is no capture, OSError if it cannot be read. A file that is cut off ends early; the logger `sistap` says so.
    """
    from sistap.dissected.captures.portions import TOGETHER, in_turn
    from sistap.dissected.packets.dissection import Dissection
    from sistap.dissected.wireshark.tshark import Tshark
    from sistap.tap.common import temporary

    with ExitStack() as stack:
        if isinstance(source, str | Path):
            path = Path(source)
            path.open("rb").close()
        else:
            path = stack.enter_context(temporary.folder()) / "records.pcapng"
            with Writer(path) as capture:
                for record in source:
                    capture.write(record)
        captures = stack.enter_context(closing(in_turn([path], TOGETHER, _LOG.warning)))
        dissection = Dissection(stack.enter_context(Tshark()), captures, fields, keeps=False)
        for packet in stack.enter_context(dissection).packets():
            if unknown := [field for field in fields if field in dissection.missing]:
                raise ValueError(f"tshark knows no field {unknown[0]}")
            yield packet
        if dissection.warning:
            _LOG.warning(f"{path}: {dissection.warning}")


@_naming
def play(name: str, *, duration_s: float, seed: int = 1) -> Iterator[Record]:
    """Yield what a tap records of a scenario (`sistap bus --list`, or FILE.toml). ValueError for an unknown one."""
    from sisbus.library import Live

    _check("duration_s", duration_s, int | float, "a number of seconds")
    _check("seed", seed, int, "a whole number")
    _seconds("duration_s", duration_s)
    records: deque[BareRecord] = deque()
    live = Live(_path("name", name), seed, Stream(), records.append, duration_s * 1e9)
    records.extend(live.tap.started)
    return _played(live, records)


def _played(live: Live, records: deque[BareRecord]) -> Iterator[Record]:
    interpreter = Interpreter()
    while not live.is_over:
        live.play_next()
        while records:
            yield interpreter.take(records.popleft())
    live.tap.close()
    yield from map(interpreter.take, records)
