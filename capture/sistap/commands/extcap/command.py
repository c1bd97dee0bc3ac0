# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap extcap`: the questions of Wireshark, and their answers."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable

import sistap
from sistap.commands.extcap import dialog, interfaces
from sistap.commands.extcap.interfaces import sentence
from sistap.commands.extcap.toolbar import Toolbar, controls
from sistap.tap.files.pcapng import LINKTYPE_WIRESHARK_UPPER_PDU
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, USAGE, Refusal

DESCRIPTION = """\
Serve as an interface of Wireshark: every serial port of this computer, and a simulated bus.
Wireshark runs this command itself, through a launcher in its extcap folder, with the options below. The options of a
capture are the fields of its dialog.
"""

EPILOG = """\
Without --capture, a capture filter is only checked. Nothing is printed if the filter is valid.

examples of what Wireshark asks:
  sistap extcap --extcap-interfaces
  sistap extcap --extcap-config --extcap-interface sistap-ttyS0
  sistap extcap --extcap-capture-filter 'link[5] == 0x1f'

exit status:
  0  done; also when Wireshark ended the capture
  1  failed while running (port lost); what came before is in Wireshark
  2  wrong usage, filter or option
  3  the port cannot be opened
"""


Answer = Callable[[argparse.Namespace], int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.set_defaults(answer=_check_filter)
    asked = parser.add_argument_group("questions").add_mutually_exclusive_group()
    for option, (answer, text) in _ANSWERS.items():
        asked.add_argument(option, dest="answer", action="store_const", const=answer, help=text)
    about = parser.add_argument_group("about what").add_argument
    about("--extcap-version", metavar="VERSION", help="the version of Wireshark")
    about("--extcap-interface", default="", metavar="NAME", help="an interface, by its name in the list")
    about("--extcap-reload-option", metavar="OPTION", help="with --extcap-config: list only the choices of this option")
    about("--extcap-capture-filter", metavar="FILTER", help="as for `sistap capture -f`")
    about("--fifo", metavar="PIPE", help="the pipe that receives the capture")
    about("--extcap-control-in", metavar="PIPE", help="the pipe from the toolbar")
    about("--extcap-control-out", metavar="PIPE", help="the pipe to the toolbar")
    fields = parser.add_argument_group("the dialog")
    for field in dialog.OPTIONS:
        if field.type == "boolflag":
            fields.add_argument(field.call, action="store_true", help=field.tooltip)
        else:
            fields.add_argument(field.call, default="", metavar="VALUE", help=field.tooltip)


def run(args: argparse.Namespace) -> int:
    """Answer the question; return the exit code."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8")  # Wireshark expects UTF-8, on Windows as well
    answer: Answer = args.answer
    return answer(args)


def _interfaces(_: argparse.Namespace) -> int:
    print(sentence("extcap", version=sistap.__version__, display="SIS tap"))
    print(*interfaces.found(), *controls(), sep="\n")
    return DONE


def _dlts(_: argparse.Namespace) -> int:
    print(sentence("dlt", number=LINKTYPE_WIRESHARK_UPPER_PDU, name="WIRESHARK_UPPER_PDU", display="SIS tap"))
    return DONE


def _config(args: argparse.Namespace) -> int:
    name, option = args.extcap_interface, args.extcap_reload_option
    print(*(dialog.choices(name, option) if option else dialog.config(name)), sep="\n")
    return DONE


def _check_filter(args: argparse.Namespace) -> int:
    from sistap.tap.capture.filter import Filter

    if args.extcap_capture_filter is None:
        Console().say(
            "no question given: only Wireshark calls this; `sistap capture` captures, `sistap ports` lists ports"
        )
        return USAGE
    try:
        Filter(args.extcap_capture_filter)
    except Refusal as error:
        # Wireshark takes any output as an error message, and exit code 0 as an answer
        print(str(error).partition("\n")[0])
    return DONE


def _capture(args: argparse.Namespace) -> int:
    if not args.fifo or not args.extcap_interface:
        Console().say("--capture needs --extcap-interface and --fifo, as Wireshark passes them")
        return USAGE
    with Toolbar(args.extcap_control_in, args.extcap_control_out) as toolbar:
        from sistap.commands.extcap import started  # imported late: Wireshark waits for the toolbar until here

        return started.run(args, toolbar)


_ANSWERS: dict[str, tuple[Answer, str]] = {
    "--extcap-interfaces": (_interfaces, "list the interfaces and the controls of their toolbar"),
    "--extcap-dlts": (_dlts, "print the link type of the interface"),
    "--extcap-config": (_config, "list the fields of its dialog"),
    "--capture": (_capture, "capture"),
}
