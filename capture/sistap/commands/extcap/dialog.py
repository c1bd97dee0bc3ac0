# SPDX-License-Identifier: GPL-2.0-or-later
"""The options of an interface: how Wireshark's dialog shows them."""

from __future__ import annotations

import enum
from collections.abc import Callable, Sequence
from typing import NamedTuple

from sistap.commands.extcap import interfaces
from sistap.commands.extcap.interfaces import ANALYSER, DEMO, sentence
from sistap.tap.analyser import probe
from sistap.tap.capture.rate import AUTO, FORMATS
from sistap.tap.sis.rates import RATES

SELFTEST = "selftest"

Choice = tuple[str, str]  # a value, and its text


class Of(enum.Flag):
    """A kind of interface."""

    PORT = enum.auto()
    ANALYSER = enum.auto()
    DEMO = enum.auto()


class Option(NamedTuple):
    """One field of the dialog, and one option of the command."""

    call: str
    type: str  # the name of the type in Wireshark
    display: str
    tooltip: str
    group: str  # fields of a group are shown together, on a page of their own if there are several groups
    of: Of = Of.PORT | Of.DEMO | Of.ANALYSER  # which interfaces have it
    choices: Callable[[str], Sequence[Choice]] | None = None  # for an interface; the first is the default
    reload: bool = False  # with a button that asks for the choices again
    placeholder: str = ""
    validation: str = ""

    @property
    def key(self) -> str:
        """Return the name of its value."""
        return self.call.removeprefix("--").replace("-", "_")


def _rates(_: str) -> Sequence[Choice]:
    return [*((str(rate), f"{rate} Bd") for rate in RATES), (AUTO, "Look for it")]


def _formats(_: str) -> Sequence[Choice]:
    return [("", f"{FORMATS[0]}, or found together with the rate"), *((text, text) for text in FORMATS)]


def _framings(_: str) -> Sequence[Choice]:
    return [("sis", "SIS telegrams"), ("3964r", "3964R: handshakes and blocks"), ("ascii", "ASCII: lines")]


def _other_ports(name: str) -> Sequence[Choice]:
    others = [(other.name, other.display) for other in interfaces.found() if other.name not in (name, ANALYSER, DEMO)]
    return [("", "None: a bus"), *others]


def _uncertainties(_: str) -> Sequence[Choice]:
    return [("", "From the last self-test, or measured at the start"), (SELFTEST, "From a self-test now (5 s)")]


def _scenarios(_: str) -> Sequence[Choice]:
    from sisbus.library import DEFAULT, complete  # imported only when the dialog is shown

    found = complete()
    return [(name, f"{name}: {found[name].title}") for name in sorted(found, key=lambda name: name != DEFAULT)]


def _inverted(_: str) -> Sequence[Choice]:
    words = {"no": "No: high while nothing is sent", "rx": "Line 1", "tx": "Line 2", "both": "Both lines"}
    return list(words.items())


_MILLISECONDS = "^[1-9][0-9]{0,4}$"

LINE, TIMES, BUS, PROBE = "Line", "Times", "Bus", "Analyser"

OPTIONS = (
    Option("--baud", "selector", "Rate", "Rate of the bus. SIS starts at 9600 Bd after power-on", LINE, choices=_rates),
    Option(
        "--other-baud",
        "string",
        "Another rate",
        "Rate of the bus in Bd, instead of the one above",
        LINE,
        placeholder="none",
        validation="^[1-9][0-9]*$",
    ),
    Option("--format", "selector", "Format", "Data bits, parity, stop bits. SIS uses 8E1", LINE, choices=_formats),
    Option(
        "--follow-baud",
        "boolflag",
        "Follow rate changes on the bus",
        "Rate changes by service 0x03, including timed tests",
        LINE,
    ),
    Option(
        "--framing",
        "selector",
        "Framing",
        "The protocol on the bus: SIS, procedure 3964R between a control and a PPC, or lines of the ASCII protocol",
        LINE,
        of=Of.PORT | Of.ANALYSER,  # the scenario of the demo bus decides it
        choices=_framings,
    ),
    Option(
        "--second-port",
        "selector",
        "Port of the other direction",
        "RS422 and RS232 have wires for each direction: use one port for each",
        LINE,
        of=Of.PORT,
        choices=_other_ports,
        reload=True,
    ),
    Option(
        "--uncertainty",
        "selector",
        "Uncertainty",
        "How late this computer may see a character. sistap keeps the result of a self-test for later captures",
        TIMES,
        of=Of.PORT,
        choices=_uncertainties,
    ),
    Option(
        "--tza",
        "string",
        "TzA in ms",
        "Longest interval allowed between two characters of a telegram, until the bus itself sets it",
        TIMES,
        of=Of.PORT | Of.ANALYSER,  # the demo bus says it
        placeholder="as set on the bus",
        validation=_MILLISECONDS,
    ),
    Option(
        "--trs",
        "string",
        "TrS in ms",
        "Longest reaction time allowed, until the bus itself sets it",
        TIMES,
        of=Of.PORT | Of.ANALYSER,
        placeholder="as set on the bus",
        validation=_MILLISECONDS,
    ),
    Option(
        "--scenario",
        "selector",
        "Scenario",
        "Stations, traffic and faults of the bus, as listed by sistap bus --list",
        BUS,
        of=Of.DEMO,
        choices=_scenarios,
    ),
    Option(
        "--faults",
        "string",
        "Faults",
        "Probability of each fault: parity, break, loss or pause of a character, checksum of a telegram. "
        "The scenario demo has a few of them; checksum=0 means none",
        BUS,
        of=Of.DEMO,
        placeholder="for example checksum=0.02,pause=0.001",
        validation="^[a-z]+=[0-9.]+(,[a-z]+=[0-9.]+)*$",
    ),
    Option(
        "--driver",
        "string",
        "Driver",
        "Driver name in sigrok; sigrok-cli --scan lists it. For several alike: fx2lafw:conn=BUS.ADDRESS",
        PROBE,
        of=Of.ANALYSER,
        placeholder=probe.DRIVER,
    ),
    Option(
        "--channel",
        "string",
        "Channel",
        "Channel that the bus is connected to",
        PROBE,
        of=Of.ANALYSER,
        placeholder=probe.CHANNEL,
    ),
    Option(
        "--second-channel",
        "string",
        "Channel of the other direction",
        "RS422 and RS232 have wires for each direction",
        PROBE,
        of=Of.ANALYSER,
        placeholder="none: a bus",
    ),
    Option(
        "--samplerate",
        "string",
        "Samples a second",
        "More samples give more exact times. Use at least 20 times the rate of the bus",
        PROBE,
        of=Of.ANALYSER,
        placeholder="4m, or more if the rate needs it",
        validation="^[0-9.]+[kKmM]?$",
    ),
    Option(
        "--invert",
        "selector",
        "Inverted",
        "RS232 without a receiver chip is low while idle",
        PROBE,
        of=Of.ANALYSER,
        choices=_inverted,
    ),
)


def config(name: str) -> list[str]:
    """Describe the dialog of an interface."""
    lines = []
    for number, option in _options_of(name):
        lines.append(
            sentence(
                "arg",
                number=number,
                call=option.call,
                type=option.type,
                display=option.display,
                tooltip=option.tooltip,
                group=option.group,
                reload="true" if option.reload else None,
                placeholder=option.placeholder,
                validation=option.validation,
            )
        )
        lines += _values(name, number, option)
    return lines


def choices(name: str, called: str) -> list[str]:
    """Return the choices of an option again. Wireshark gives its name with or without hyphens."""
    return [
        line
        for number, option in _options_of(name)
        if option.call.removeprefix("--") == called.removeprefix("--")
        for line in _values(name, number, option)
    ]


def _options_of(name: str) -> list[tuple[int, Option]]:
    """Return the options of an interface with their numbers. Wireshark shows them in the order of the numbers."""
    kind = {DEMO: Of.DEMO, ANALYSER: Of.ANALYSER}.get(name, Of.PORT)
    return [item for item in enumerate(OPTIONS) if kind in item[1].of]


def _values(name: str, number: int, option: Option) -> list[str]:
    if option.choices is None:
        return []
    first, *others = option.choices(name)
    lines = [sentence("value", arg=number, value=first[0], display=first[1], default="true")]
    return lines + [sentence("value", arg=number, value=value, display=display) for value, display in others]
