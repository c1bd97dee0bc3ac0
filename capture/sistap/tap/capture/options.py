# SPDX-License-Identifier: GPL-2.0-or-later
"""The options of a capture, from the command line or a dialog of Wireshark, and which of them exclude each other."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple
from urllib.parse import urlsplit

from sistap.tap.capture.filter import Filter
from sistap.tap.capture.rate import AUTO, FORMATS
from sistap.tap.files.output import FileLimits
from sistap.tap.files.pcapng import RTAC, UPPER_PDU
from sistap.tap.line import ports
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.cut import PROCEDURE_3964R, SIS, Cut
from sistap.tap.records.record import LARGEST_RATE
from sistap.tap.sis import limits
from sistap.tap.sis.rates import RATES
from sistap.tap.terminal.console import STANDARD_OUTPUT
from sistap.tap.terminal.exits import Refusal

ONE_LINE, BOTH_LINES = (0,), (1, 2)  # their numbers: a shared bus, the directions of a full-duplex line


@dataclass(frozen=True)
class CaptureOptions:
    """The options of `sistap capture`, each as its help says."""

    ports: Sequence[str]
    file: str | None = None  # None: print text
    baud: int | None = RATES[0]  # None: search for it
    format: str | None = None  # None: that of the specification, or searched for with the rate
    follow_baud: bool = False
    framing: Cut = SIS
    link_type: str = UPPER_PDU
    count: int | None = None
    autostop: Mapping[str, float] = field(default_factory=dict)  # -a: duration, filesize, files
    ring: Mapping[str, float] = field(default_factory=dict)  # -b: the same
    filter: str | None = None
    tza_ms: int | None = None  # limit of a bus that set it before the capture began
    trs_ms: int | None = None
    wait_for_port: bool = False
    quiet: bool = False

    @property
    def lines(self) -> Sequence[int]:
        """Return the number of the line of each port."""
        return BOTH_LINES if len(self.ports) > 1 else ONE_LINE

    @property
    def formats(self) -> Sequence[str]:
        """Return the formats to search with the rate; none if the rate is known."""
        if self.baud:
            return ()
        return (self.format,) if self.format else FORMATS

    @property
    def limits_told(self) -> str:
        """Return the limits of the user as the dissector reads them in the capture; empty if there are none."""
        return limits.told({"tza": self.tza_ms, "trs": self.trs_ms})

    @property
    def output(self) -> str:
        """Return the file that gets all records."""
        return self.file or STANDARD_OUTPUT

    @property
    def limits(self) -> FileLimits:
        """Return the limits of the files: -w, -a and -b mean what they mean in dumpcap. May raise Refusal."""
        _check_limits(self)
        size = _size(self)
        return FileLimits(
            size=int(size) * 1000 if size else None,
            duration_s=self.ring.get("duration"),
            several=bool(self.ring),
            keep=_whole(self.ring.get("files")),
            files=_whole(self.autostop.get("files")),
        )


class Plan(NamedTuple):
    """The result of checked options."""

    settings: LineSettings  # to begin with
    only: Filter | None


def rate(text: str) -> int | None:
    """Parse a rate; None is auto. ValueError says what it must be."""
    if text == AUTO:
        return None
    try:
        if 0 < (baud := int(text)) <= LARGEST_RATE:
            return baud
    except ValueError:
        pass
    raise ValueError(f"'{text}' is neither auto nor a rate from 1 to {LARGEST_RATE} Bd")


def checked(options: CaptureOptions) -> Plan:
    """Check the options that do not concern the output. May raise Refusal."""
    settings = _settings(options)
    if options.framing == PROCEDURE_3964R and options.link_type not in (UPPER_PDU, RTAC):
        raise Refusal(
            f"--link-type {options.link_type} is for SIS telegrams, and has no place for the handshakes of 3964R: "
            f"use {UPPER_PDU} or {RTAC}"
        )
    if options.limits_told and (options.framing != SIS or options.link_type != UPPER_PDU):
        raise Refusal("--tza and --trs are kept only with SIS telegrams and --link-type upper-pdu: leave them out")
    _check_ports(options)
    return Plan(settings, Filter(options.filter) if options.filter else None)


def _settings(options: CaptureOptions) -> LineSettings:
    """Return the settings to begin with."""
    fixed = [port for port in options.ports if port.startswith("socket://")]
    steered = "--baud auto" if options.baud is None else "--follow-baud" if options.follow_baud else ""
    if steered and options.framing != SIS:
        raise Refusal(f"{steered} needs SIS telegrams: leave out --framing or {steered}")
    if steered and fixed:
        raise Refusal(f"{steered} cannot change the rate behind {fixed[0]}: set it there, and leave out {steered}")
    try:
        return LineSettings.parse(options.baud or RATES[0], options.format or FORMATS[0])
    except ValueError as error:
        raise Refusal(str(error)) from error


def _size(options: CaptureOptions) -> float | None:
    """Return how large a file may become, in kB."""
    return options.ring.get("filesize", options.autostop.get("filesize"))


def _whole(number: float | None) -> int | None:
    return None if number is None else int(number)


def _check_limits(options: CaptureOptions) -> None:
    ring, size = options.ring, _size(options)
    if options.file is None and (size or ring or options.link_type != UPPER_PDU):
        raise Refusal("-a filesize:, -b and --link-type need a file: say it with -w")
    if options.file == STANDARD_OUTPUT and ring:
        raise Refusal("-b needs files: standard output is only one")
    if options.file == STANDARD_OUTPUT and os.isatty(1):
        raise Refusal("a terminal cannot show a pcapng file: add | wireshark -C SIS -k -i - or leave out -w")
    if ring and not size and "duration" not in ring:
        raise Refusal("-b files: does not say when a file is full: add -b duration:SECONDS or -b filesize:KB")
    if "files" in options.autostop and not ring:
        raise Refusal("-a files: needs several files: add -b duration:SECONDS or -b filesize:KB")


def _check_ports(options: CaptureOptions) -> None:
    """Refuse a port that something would be written to, and the same port for both lines."""
    for port in options.ports:
        if options.file and ports.is_same_file(options.file, port):
            raise Refusal(f"{options.file} is the port itself, which is never written to: choose a file with -w")
        if ports.is_own_terminal(port):
            raise Refusal(f"{port} is the terminal that sistap itself reads or writes: choose another port with -i")
    first, last = options.ports[0], options.ports[-1]
    if len(options.ports) > 1 and (first == last or ports.is_same_file(first, last)):
        raise Refusal(f"{last} is the same port again: the second one is that of the other direction")
    if _host(first) != _host(last):
        raise Refusal(
            f"{first} and {last} have two clocks, and their times cannot be compared: tap both at one computer"
        )


def _host(port: str) -> str:
    """Return the host whose clock gives a port its times; empty for ports of this computer."""
    try:
        return urlsplit(port).hostname or "" if port.startswith("bus://") else ""
    except ValueError:  # opening it will say so
        return ""
