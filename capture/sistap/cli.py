# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap`: finds the subcommand, and turns what went wrong into one line and an exit code."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Container, Sequence
from difflib import get_close_matches
from typing import NoReturn

import sistap
from sistap.line.reader import PortError, PortLost
from sistap.terminal.advice import advice, examples
from sistap.terminal.console import Console
from sistap.terminal.exits import DONE, FAILED, PORT, USAGE
from sistap.terminal.stop import Stop, Stopped
from sistap.terminal.streams import end_standard_output, is_reader_gone, leave_standard_output
from sistap.terminal.visible import visible

# The module of each command, imported only when it is called, and its line in the list.
COMMANDS = {
    "ports": ("sistap.line.ports", "list the serial ports of this machine"),
    "capture": ("sistap.capture.command", "record a line into a pcapng file, or show it as text"),
    "serve": ("sistap.serve.command", "let other computers hear a line of this one"),
    "report": ("sistap.report.command", "put a whole capture on one page, with pictures and the worst moments"),
    "parameters": ("sistap.parameters.command", "list what was read and written of parameters, and what has changed"),
    "annotate": ("sistap.annotate.command", "explain a log of another program, telegram by telegram"),
    "log": ("sistap.annotate.log", "write a capture as such a log, explained"),
    "import": ("sistap.imports.command", "make a capture of what another tool has recorded"),
    "install": ("sistap.install.command", "put the dissector, the interfaces and the profile where Wireshark looks"),
    "uninstall": ("sistap.install.uninstall", "remove what install has put there"),
    "doctor": ("sistap.doctor", "say whether a capture would work, and what is missing"),
    "selftest": ("sistap.selftest", "measure how exactly this machine tells when a character came"),
    "extcap": ("sistap.extcap.command", "be an interface of Wireshark, which calls this itself"),
    "bus": ("sistap.bus.command", "play a bus in software, to try everything without a drive"),
    "replay": ("sistap.bus.replay", "play a capture again, with its own timing"),
}

DESCRIPTION = """\
A passive tap for the SIS serial protocol of Rexroth and Indramat drives: records every character on the line with its
time, for Wireshark. It only listens.
"""

EPILOG = """\
`sistap COMMAND --help` describes a command.

examples:
  sistap ports                                             which ports there are
  sistap capture -i /dev/ttyUSB0 -w - | wireshark -k -i -  watch a line live in Wireshark
  sistap bus                                               a bus on the desk: listen to the port that it prints

exit status:
  0  done; also when stopped by Ctrl-C or SIGTERM
  1  failed while running: what came before is saved
  2  wrong usage
  3  a port cannot be opened
"""


def main(arguments: Sequence[str] | None = None, stop: Stop | None = None) -> int:
    """Run `sistap` with these arguments (those of the process); return the exit code.

    `stop` is that of a process that ends with the command. Without it, signals are as before when this returns.
    """
    stop = stop or Stop()
    _open_standard_streams()
    try:
        return _flushed(sys.argv[1:] if arguments is None else arguments, stop)
    except Stopped:
        return _stopped(stop)
    except Exception as error:
        if stop.asked and stop.at_once:  # C code of libraries makes an ImportError and the like of Stopped
            return _stopped(stop)
        return _failed(error)


def _failed(error: Exception) -> int:
    """Say in one line what went wrong; return the exit code. Raise it again if that is nothing to be expected."""
    if isinstance(error, OSError):
        leave_standard_output()
        if not is_reader_gone(error, is_file=error.filename is not None):
            Console().say(str(error))
        return FAILED
    if isinstance(error, ModuleNotFoundError) and error.name and error.name.partition(".")[0] == "serial":
        Console().say(
            f"pyserial is missing for {sys.executable}: `{sys.executable} -m pip install pyserial`, "
            f"{advice().pyserial}"
        )
        return FAILED
    raise error


def _stopped(stop: Stop) -> int:
    """End it without another word; return the exit code."""
    stop.end()
    end_standard_output()
    return DONE


def _flushed(arguments: Sequence[str], stop: Stop) -> int:
    """Run, then write what is left in the buffer of standard output, unless it was stopped: that may not wait."""
    try:
        code = _run(arguments, stop)
    except Stopped:
        raise
    except BaseException:
        sys.stdout.flush()
        raise
    sys.stdout.flush()
    return code


class _Parser(argparse.ArgumentParser):
    """Refuses in lines that a file with whatever name cannot change."""

    def error(self, message: str) -> NoReturn:
        """Say it and end."""
        super().error(visible(message))


def parser(called: Container[str] = COMMANDS) -> argparse.ArgumentParser:
    """Return the parser of `sistap`. Only the commands in `called` have their options: their modules are imported."""
    whole = _Parser(
        "sistap", description=DESCRIPTION, epilog=examples(EPILOG), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    whole.add_argument("--version", action="version", version=f"sistap {sistap.__version__}")
    commands = whole.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, (module_name, text) in COMMANDS.items():
        command = commands.add_parser(name, help=text, formatter_class=argparse.RawDescriptionHelpFormatter)
        if name in called:
            module = importlib.import_module(module_name)
            module.add_arguments(command)
            command.set_defaults(run=module.run, whole_parser=parser)
            command.epilog = examples(command.epilog or "")
    return whole


def _run(arguments: Sequence[str], stop: Stop) -> int:
    called = next((argument for argument in arguments if not argument.startswith("-")), "")
    if called and called not in COMMANDS and (close := get_close_matches(called, COMMANDS, 1)):
        Console().say(f"there is no command '{visible(called)}': did you mean `sistap {close[0]}`?")
        return USAGE
    args = parser({called}).parse_args(arguments)
    try:
        with stop:
            code: int = args.run(args)
            sys.stdout.flush()  # while a signal can still end the waiting for whoever reads
    except (PortError, PortLost) as error:
        Console().say(str(error))
        code = PORT if isinstance(error, PortError) else FAILED
    return code


def _open_standard_streams() -> None:
    """Let no port get the number of a closed standard stream: what is printed would be written to it.

    Only for reading: so it still cannot be written to.
    """
    while (descriptor := os.open(os.devnull, os.O_RDONLY)) <= 2:
        pass
    os.close(descriptor)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w"))  # noqa: SIM115 - for as long as the process lives
