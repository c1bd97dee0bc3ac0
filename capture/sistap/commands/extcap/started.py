# SPDX-License-Identifier: GPL-2.0-or-later
"""A capture that Wireshark started: records go into its pipe, with the settings of the dialog."""

from __future__ import annotations

import argparse
import io
from contextlib import closing, redirect_stdout
from urllib.parse import urlencode

from sisbus import library
from sistap.commands import selftest
from sistap.commands.extcap import dialog
from sistap.commands.extcap.interfaces import ANALYSER, DEMO, port_of
from sistap.commands.extcap.toolbar import Toolbar
from sistap.tap.analyser import probe
from sistap.tap.capture.options import CaptureOptions, checked, rate
from sistap.tap.capture.running import begin_in_vain, record
from sistap.tap.files.output import Output, OutputRefused
from sistap.tap.records.cut import Cut
from sistap.tap.sis.limits import milliseconds
from sistap.tap.sis.rates import RATES
from sistap.tap.terminal.exits import USAGE, Refusal
from sistap.tap.terminal.stop import Stop


def run(args: argparse.Namespace, toolbar: Toolbar) -> int:
    """Capture until Wireshark ends it; return the exit code."""
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
            return record(options, checked(options), output, stop, toolbar, toolbar.attend)
        except Refusal as refusal:
            code, trouble = refusal.code, str(refusal)
        except ValueError as error:
            code, trouble = USAGE, str(error)
        toolbar.alarm(trouble)
        begin_in_vain(output, args.extcap_interface, trouble)
        return code


def _options(args: argparse.Namespace) -> CaptureOptions:
    """Return the options of the capture; ValueError says what is wrong with those of the dialog."""
    demo_bus = args.extcap_interface == DEMO
    ports = [_port(args)]
    if args.second_port:
        ports.append(port_of(args.second_port))
    return CaptureOptions(
        ports=ports,
        file=args.fifo,
        baud=_rate(args.other_baud or args.baud),
        format=args.format or None,
        follow_baud=args.follow_baud,
        framing=library.framing(args.scenario) if demo_bus else Cut.parse(args.framing or "sis"),
        filter=args.extcap_capture_filter or None,
        tza_ms=milliseconds(args.tza) if args.tza else None,
        trs_ms=milliseconds(args.trs) if args.trs else None,
    )


def _port(args: argparse.Namespace) -> str:
    """Return the port to capture from. ValueError says what is wrong."""
    if args.extcap_interface == DEMO:
        return library.demo(args.scenario, args.faults)
    if args.extcap_interface == ANALYSER:
        return _analyser(args)
    return port_of(args.extcap_interface)


def _analyser(args: argparse.Namespace) -> str:
    """Return the address of the analyser in the dialog."""
    said = {
        "rx": args.channel or probe.CHANNEL,
        "tx": args.second_channel,
        "samplerate": args.samplerate,
        "invert": args.invert,
    }
    query = urlencode({key: value for key, value in said.items() if value})
    return f"{probe.PREFIX}{args.driver or probe.DRIVER}?{query}"


def _rate(text: str) -> int | None:
    try:
        return rate(text) if text else RATES[0]
    except ValueError as error:
        raise ValueError(f"argument --baud: {error}") from None


def _measure(toolbar: Toolbar) -> None:
    """Run a self-test; the event that starts the capture reports its result."""
    parser = argparse.ArgumentParser()
    selftest.add_arguments(parser)
    options = parser.parse_args([])
    toolbar.say(f"a self-test of {options.duration:g} s, then the capture begins")
    with redirect_stdout(io.StringIO()):
        selftest.run(options)
