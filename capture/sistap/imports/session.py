# SPDX-License-Identifier: GPL-2.0-or-later
"""Sessions of sigrok-cli and PulseView (.sr): the samples of a logic analyser, which this module decodes.

A session is a zip. Its text `metadata` has the sample rate, the names of the channels and the bytes of a sample; the
samples are in `logic-1-1`, `logic-1-2` and so on, bit n - 1 of each being channel n.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from configparser import ConfigParser
from configparser import Error as ConfigError
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple
from zipfile import BadZipFile, ZipFile, is_zipfile

from sistap.analyser.probe import hertz
from sistap.analyser.uart import FEWEST_SAMPLES, HIGH, LOW, Uart, rate_of
from sistap.imports.sampled import Row, SampledLine
from sistap.imports.source import NS, Told, need_rate
from sistap.sis.rates import RATES
from sistap.terminal.exits import UsageError

NAME = "sessions of sigrok-cli and PulseView (.sr)"

_PIECE = 1 << 20  # bytes read at once
_MOST_METADATA = 1 << 20  # bytes
_MEASURED = 1 << 21  # samples with edges by which the rate is measured
_ALIKE = 0.03  # rates that differ by less are the same


class Session(NamedTuple):
    """What the metadata of a session say."""

    samplerate: int  # Hz
    size: int  # bytes of a sample
    channels: dict[str, int]  # their bits, by name
    parts: list[str]  # the files with samples, in their order


def is_session(path: Path) -> bool:
    """Tell whether a file is a session."""
    if not is_zipfile(path):
        return False
    try:
        with ZipFile(path) as archive:
            return {"metadata", "version"} <= set(archive.namelist())
    except (BadZipFile, OSError):
        return False


def opened(path: Path, told: Told) -> SampledLine:
    """Open a session: the channel that changes, or the two. May raise UsageError."""
    try:
        with ZipFile(path) as archive:
            session = _session(archive, path, told)
            names = _chosen(archive, session, path, told)
            baud = told.baud or _measured(archive, session, names)
            settings = told.settings._replace(baud=baud)
            need_rate(settings, path, "" if told.baud else "its pulses are those of no usual rate")
            if baud * FEWEST_SAMPLES > session.samplerate:
                raise UsageError(f"{path} has {session.samplerate} samples a second, too few for {baud} Bd")
            uarts = {name: Uart(session.samplerate, settings) for name in names}
            rows = [row for name, uart in uarts.items() for row in _rows(archive, session, name, uart)]
            line = SampledLine(path, rows, told._replace(baud=baud, samplerate=session.samplerate))
    except (BadZipFile, OSError, EOFError, NotImplementedError, RuntimeError) as error:
        raise UsageError(f"{path} cannot be read ({error}): save it again") from None
    if not told.baud:
        line.settings_from = "the rate as measured"
    return line


def _session(archive: ZipFile, path: Path, told: Told) -> Session:
    config = ConfigParser(interpolation=None, strict=False)
    try:
        with archive.open("metadata") as file:
            config.read_string(file.read(_MOST_METADATA).decode("utf-8", "replace"))
        device = config["device 1"]
        size = int(device.get("unitsize", "1"))
        rate = device.get("samplerate") or (str(told.samplerate) if told.samplerate else "")
        samplerate = hertz(rate) if rate else 0
    except (ConfigError, KeyError, ValueError) as error:
        raise UsageError(f"{path} is no session of sigrok with samples of logic ({error})") from None
    if not samplerate:
        raise UsageError(f"{path} does not say how many samples a second has: add --samplerate HZ")
    bits = {name: int(key[5:]) - 1 for key, name in device.items() if re.fullmatch(r"probe[1-9]\d{0,2}", key)}
    channels = {name: bit for name, bit in bits.items() if bit < 8 * size}
    begin = device.get("capturefile", "logic-1")
    numbers = re.compile(re.escape(begin) + r"(?:-(\d{1,9}))?")
    parts = [(int(match[1] or 0), name) for name in archive.namelist() if (match := numbers.fullmatch(name))]
    if not 0 < size <= 64 or not channels or not parts:
        raise UsageError(f"{path} has no samples of logic channels: save them from sigrok-cli or PulseView")
    return Session(samplerate, size, channels, [name for _, name in sorted(parts)])


def _chosen(archive: ZipFile, session: Session, path: Path, told: Told) -> list[str]:
    """Return the channels that are named, else those that change. UsageError if these are not one or two."""
    if told.device:
        names = told.device.split(",")
        if unknown := [name for name in names if name not in session.channels]:
            listed = ", ".join(session.channels)
            raise UsageError(f"{path} has no channel {', '.join(unknown)}: --device names one or two of {listed}")
    else:
        masks = int.from_bytes(_changing(archive, session), "little")
        names = [name for name, bit in session.channels.items() if masks >> bit & 1]
    if len(names) in (1, 2):
        return names
    if not names:
        raise UsageError(f"{path} has no channel that changes: nothing was received")
    raise UsageError(
        f"{path} has {len(names)} channels that change ({', '.join(names)}): name those of the bus, such as "
        f"--device {names[0]} or --device {names[0]},{names[1]}"
    )


def _changing(archive: ZipFile, session: Session) -> bytes:
    """Return which bits of a sample are not always the same."""
    seen: list[set[int]] = [set() for _ in range(session.size)]
    for piece in _pieces(archive, session):
        for place, values in enumerate(seen):
            values.update(piece[place :: session.size])
    changing = bytearray()
    for values in seen:
        ones = zeros = 0
        for value in values:
            ones, zeros = ones | value, zeros | ~value
        changing.append(ones & zeros & 0xFF)
    return bytes(changing)


def _pieces(archive: ZipFile, session: Session) -> Iterator[bytes]:
    """Yield whole samples."""
    rest = b""
    for part in session.parts:
        with archive.open(part) as file:
            while data := file.read(_PIECE):
                data = rest + data
                whole = len(data) - len(data) % session.size
                rest = data[whole:]
                yield data[:whole]


def _levels(archive: ZipFile, session: Session, name: str) -> Iterator[bytes]:
    """Yield the samples of a channel, one in each byte, as a UART takes them."""
    place, bit = divmod(session.channels[name], 8)
    table = bytes((HIGH if value >> bit & 1 else LOW)[0] for value in range(256))
    for piece in _pieces(archive, session):
        yield piece[place :: session.size].translate(table)


def _measured(archive: ZipFile, session: Session, names: list[str]) -> int:
    """Return the usual rate that the shortest pulses mean; 0: none."""
    for name in names:
        heard = bytearray()
        for samples in _levels(archive, session, name):
            if HIGH in samples and LOW in samples:
                heard += samples
            if len(heard) >= _MEASURED:
                break
        rate = rate_of(bytes(heard), session.samplerate)
        for usual in RATES:
            if rate and abs(rate / usual - 1) <= _ALIKE:
                return usual
    return 0


def _rows(archive: ZipFile, session: Session, name: str, uart: Uart) -> Iterator[Row]:
    to_stop = Fraction(uart.stop_ns, NS)
    for samples in _levels(archive, session, name):
        for start, value, flag in uart.feed(samples):
            yield Row(name, Fraction(start, session.samplerate) + to_stop, value, flag)
