# SPDX-License-Identifier: GPL-2.0-or-later
"""The channels of a logic analyser: which are the lines of the bus, with which settings, and their characters."""

from __future__ import annotations

from array import array
from bisect import bisect
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from sistap.commands.imports.sampled import Row, SampledLine
from sistap.commands.imports.source import NS, Stated
from sistap.tap.analyser.finding import BAUDS, FORMATS, Reading, Trace, find, read_as
from sistap.tap.analyser.uart import FEWEST_SAMPLES, Uart
from sistap.tap.line.settings import LineSettings
from sistap.tap.terminal.advice import shell_word
from sistap.tap.terminal.exits import Refusal

HEAD = 4000  # edges of a channel by which it is judged
_MOST_CHANNELS = 64  # of an analyser; simulations have more signals
NO_END = "its end cannot be read, and is left out"
_WRONG = "these are not the settings of this line"
_MOST = 0.9  # a channel is what it is for this share of the time


class Wave(NamedTuple):
    """A recording. Its times are counts; before the first one, each channel counts as low."""

    rate: int  # counts in a second
    channels: Mapping[str, array[int]]  # the times of the edges, by name
    end: int
    samplerate: int | None = None  # Hz; None: unknown
    warning: str = ""  # what could not be read


class _Channel(NamedTuple):
    """A channel that changes, read with the settings of the bus; judged by its beginning."""

    name: str
    head: Trace
    reading: Reading
    length: int  # counts of a character

    @property
    def starts(self) -> list[int]:
        """Return when its characters begin."""
        return [character.start for character in self.reading.characters]

    @property
    def is_read(self) -> bool:
        """Tell whether its characters are right."""
        return self.reading.is_clean or self.reading.in_telegrams > 0

    def repeats(self, other: _Channel) -> bool:
        """Tell whether another channel has the same characters at the same time."""
        near = self.length // 20 or 1
        theirs = {(one.value, one.start // near + late) for one in other.reading.characters for late in (-1, 0, 1)}
        mine = [one for one in self.reading.characters if one.start <= other.starts[-1]]
        return len(mine) > 0 and sum((one.value, one.start // near) in theirs for one in mine) >= _MOST * len(mine)

    def enables(self, other: _Channel) -> bool:
        """Tell whether it changes only between the characters of another channel, with some in each of its pulses."""
        starts = other.starts
        edges = [time for time in self.head.edges if time <= starts[-1] + self.length]
        before = [bisect(starts, time) for time in edges]
        late = (time - starts[place - 1] for time, place in zip(edges, before, strict=True) if place)
        pulses = [list(zip(before[at::2], before[at + 1 :: 2], strict=False)) for at in (0, 1)]
        return sum(time < self.length * _MOST for time in late) <= (1 - _MOST) * len(edges) and any(
            pulse and all(first < last for first, last in pulse) for pulse in pulses
        )

    def said(self, lines: Sequence[_Channel]) -> str:
        """Say what it is, beside the lines of the bus."""
        if self in lines:
            is_inverted = self.is_read and self.reading.is_inverted
            return f"channel {self.name}" + (", idle low (inverted)" if is_inverted else "")
        if copied := next((line.name for line in lines if self.repeats(line)), None):
            return f"channel {self.name} is a copy of {copied}"
        if any(self.enables(line) for line in lines):
            return f"channel {self.name} is a driver enable"
        if self.head.is_clock:
            return f"channel {self.name} is a clock"
        return f"channel {self.name} " + ("has few characters" if self.reading.is_clean else "makes no characters")


def opened(path: Path, wave: Wave, stated: Stated) -> SampledLine:
    """Find the lines of the bus, and their characters. May raise Refusal."""
    heads = _heads(path, wave, stated)
    settings = _settings(path, wave, heads, stated)
    length = settings.character_ns * wave.rate // NS
    channels = [_Channel(name, head, read_as(head, wave.rate, settings), length) for name, head in heads.items()]
    lines = channels if stated.device else _lines(channels)
    if len(lines) > 2:
        listed = ", ".join(line.name for line in lines)
        first, second, *_ = lines
        raise Refusal(
            f"{path} has {len(lines)} channels that can be lines of the bus ({listed}): name those that are, such as "
            f"--device {shell_word(first.name)} or --device {shell_word(f'{first.name},{second.name}')}"
        )
    source = SampledLine(
        path,
        (row for line in lines for row in _rows(wave, line)),
        stated._replace(baud=settings.baud, format=settings.format, samplerate=stated.samplerate or wave.samplerate),
        "the settings change in the file: import it once more with --baud and --format of the other part",
    )
    given = (
        f"the {'rate' if stated.baud else 'format'} as given" if stated.baud or stated.format else "found by the pulses"
    )
    how = "as given" if stated.baud and stated.format else given
    source.warning = source.warning or wave.warning
    is_read, better = any(line.is_read for line in lines), ""
    if not any(line.reading.in_telegrams for line in lines):
        how += ", without a telegram of SIS"
        better = _better(wave, heads, is_read=is_read) if stated.baud or stated.format else ""
    source.settings_from = "; ".join([how, *(channel.said(lines) for channel in channels)])
    if better or not is_read:
        source.warning = better or (
            f"{_WRONG}: try another --baud, another --format such as 8N1, or another channel with --device"
        )
    return source


def _heads(path: Path, wave: Wave, stated: Stated) -> dict[str, Trace]:
    """Return the beginnings of the channels that are named, else of those that change."""
    names = list(wave.channels)
    if stated.device:
        names = [stated.device] if stated.device in wave.channels else stated.device.split(",")
    if unknown := [name for name in names if name not in wave.channels]:
        listed = ", ".join(wave.channels)
        raise Refusal(f"{path} has no channel {', '.join(unknown)}: --device names one or two of {listed}")
    heads = {}
    for name in names:
        edges = wave.channels[name]
        if len(edges) > 1:
            heads[name] = Trace(edges[:HEAD], is_high=False, end=edges[HEAD] if len(edges) > HEAD else wave.end)
    if not heads:
        raise Refusal(f"{path} has no channel that changes: nothing was received")
    if len(heads) > _MOST_CHANNELS:
        raise Refusal(f"{path} has {len(heads)} channels that change: name those of the bus with --device")
    return heads


def _settings(path: Path, wave: Wave, heads: Mapping[str, Trace], stated: Stated) -> LineSettings:
    """Return what is given, and find the rest."""
    samplerate = stated.samplerate or wave.samplerate or wave.rate
    bauds = [baud for baud in ([stated.baud] if stated.baud else BAUDS) if baud * FEWEST_SAMPLES <= samplerate]
    if not bauds:
        raise Refusal(f"{path} has {samplerate} samples a second, too few for {stated.baud or BAUDS[0]} Bd")
    formats = [stated.format] if stated.format else FORMATS
    found = [reading for head in heads.values() if (reading := find(head, wave.rate, bauds, formats))]
    if found:
        return max(found, key=lambda reading: reading.score).settings
    if stated.baud:
        return stated.settings
    if better := _better(wave, heads, is_read=False):
        raise Refusal(f"{path}: {better}")
    listed = ", ".join(f"{name} is a clock" if head.is_clock else name for name, head in heads.items())
    raise Refusal(
        f"{path} has no channel with characters at a usual rate ({listed}): if one of them is a line of the bus, add "
        f"--device {shell_word(next(iter(heads)))}, --baud and --format"
    )


def _lines(channels: list[_Channel]) -> list[_Channel]:
    """Return the lines of the bus. If one has telegrams, more than a pulse is asked of the others."""
    has_telegrams = any(channel.reading.in_telegrams for channel in channels)
    lines: list[_Channel] = []
    for channel in sorted(channels, key=lambda channel: -channel.reading.good):
        reading = channel.reading
        makes = reading.is_sound if has_telegrams else reading.is_clean
        is_clock = channel.head.is_clock and not reading.in_telegrams
        if makes and not is_clock and not any(channel.repeats(line) for line in lines):
            lines.append(channel)
    return lines or channels


def _rows(wave: Wave, line: _Channel) -> Iterator[Row]:
    uart = Uart(wave.rate, line.reading.settings, is_high=line.reading.is_inverted)
    to_stop = Fraction(uart.stop_ns, NS)
    for start, value, flag in uart.feed(wave.channels[line.name], wave.end):
        yield Row(line.name, Fraction(start, wave.rate) + to_stop, value, flag)


def _better(wave: Wave, heads: Mapping[str, Trace], *, is_read: bool) -> str:
    """Return how to import it, if other settings make telegrams of SIS, or if these make no characters at all."""
    for name, head in heads.items():
        if (found := find(head, wave.rate)) and (found.in_telegrams or not is_read):
            return f"{_WRONG}: {name} has {found.settings}, so leave out --baud and --format"
    return ""
