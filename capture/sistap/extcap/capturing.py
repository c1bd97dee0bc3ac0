# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture that Wireshark started: `sistap capture` into its pipe, with what was set in the dialog."""

from __future__ import annotations

import argparse
import io
from contextlib import closing, redirect_stdout
from typing import NoReturn

from sistap import selftest
from sistap.capture import command as capture
from sistap.capture.filter import FilterError
from sistap.extcap import demo, dialog
from sistap.extcap.interfaces import DEMO, port_of
from sistap.extcap.toolbar import Toolbar
from sistap.files.output import Output, OutputRefused
from sistap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU, Interface
from sistap.files.writer import PcapngWriter
from sistap.line.reader import PortError
from sistap.records.counters import Counters
from sistap.terminal.exits import PORT, USAGE
from sistap.terminal.stop import Stop


def run(args: argparse.Namespace, toolbar: Toolbar) -> int:
    """Capture until Wireshark ends it; give the exit code."""
    if args.uncertainty == dialog.SELFTEST and args.extcap_interface != DEMO:
        _measure(toolbar)
    stop = Stop.current()
    toolbar.when_left(stop.ask)
    try:
        output = Output(args.fifo, stopped=lambda: stop.asked)
    except OutputRefused as error:
        toolbar.alarm(str(error))
        return USAGE
    with closing(output):
        try:
            options = _options(args)
            return capture.record(options, capture.checked(options), output, stop, toolbar, toolbar)
        except (ValueError, capture.Refused, FilterError) as error:
            code, trouble = USAGE, str(error)
        except PortError as error:
            code, trouble = PORT, str(error)
        toolbar.alarm(trouble)
        # An empty capture: where there is none, Wireshark blames the pipe.
        interface = Interface(LINKTYPE_WIRESHARK_UPPER_PDU, args.extcap_interface)
        PcapngWriter(output, {0: interface}, Counters()).begin()
        return code


class _Parser(argparse.ArgumentParser):
    """Has one line to say what is wrong."""

    def error(self, message: str) -> NoReturn:
        """Raise ValueError."""
        raise ValueError(message)


def _options(args: argparse.Namespace) -> argparse.Namespace:
    """Give the options of `sistap capture`; ValueError says what is wrong with those of the dialog."""
    parser = _Parser(allow_abbrev=False)
    capture.add_arguments(parser)
    demo_bus = args.extcap_interface == DEMO
    ports = ["-i", demo.start(args.faults, args.scenario) if demo_bus else port_of(args.extcap_interface)]
    if args.second_port:
        ports += ["-i", port_of(args.second_port)]
    if args.extcap_capture_filter:
        ports += ["-f", args.extcap_capture_filter]
    return parser.parse_args([*ports, "-w", args.fifo, *dialog.capture_options(args)])


def _measure(toolbar: Toolbar) -> None:
    """Make a self-test; the event that starts the capture will say what it found."""
    parser = argparse.ArgumentParser()
    selftest.add_arguments(parser)
    options = parser.parse_args([])
    toolbar.say(f"a self-test, for {options.duration:g} s, before the capture begins")
    with redirect_stdout(io.StringIO()):
        selftest.run(options)
