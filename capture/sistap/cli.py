# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap`: finds the subcommand, and turns an error into one line and an exit code."""

from __future__ import annotations

import argparse
import errno
import importlib
import os
import re
import sys
from collections.abc import Container, Iterable, Sequence
from contextlib import suppress
from difflib import get_close_matches
from typing import NoReturn

import sistap
from sistap.tap.terminal.console import Console, end_standard_output, is_reader_gone, leave_standard_output, visible
from sistap.tap.terminal.exits import DONE, FAILED, USAGE, Refusal
from sistap.tap.terminal.stop import Stop, Stopped

# The module of each command, imported only when it is called, and its line in the list of commands. It has the options,
# and `run`; or it names a module with `run` as its RUN, which is imported only when the options are right.
COMMANDS = {
    "ports": ("sistap.tap.ports", "list the serial ports of this computer"),
    "capture": ("sistap.tap.capture.command", "record a bus into a pcapng file, or show it as text"),
    "record": (
        "sistap.commands.recorder.command",
        "run for months, and keep only what matters: faults, writes, a filter",
    ),
    "web": ("sistap.commands.web.command", "open Wireshark, sistap and the course in a browser"),
    "report": ("sistap.commands.report.command", "say what happened in a capture, on one page with pictures"),
    "parameters": (
        "sistap.commands.parameters.command",
        "list the parameters that were read and written, and their changes",
    ),
    "compare": ("sistap.commands.compare.command", "show what changed between a good capture and a bad one"),
    "tables": ("sistap.commands.tables.command", "collect captures in tables, to query months of many machines"),
    "annotate": ("sistap.commands.annotate.command", "explain another program's log, telegram by telegram"),
    "log": ("sistap.commands.annotate.log", "write a capture as a log with explanations"),
    "import": ("sistap.commands.imports.command", "convert a recording of another tool into a capture"),
    "install": (
        "sistap.commands.install.command",
        "install the dissector, the interfaces and the profile for Wireshark",
    ),
    "uninstall": ("sistap.commands.install.uninstall", "remove what `sistap install` has installed"),
    "doctor": ("sistap.commands.doctor", "check whether a capture would work, and what is missing"),
    "selftest": ("sistap.commands.selftest", "measure how exact the times of this computer are"),
    "extcap": ("sistap.commands.extcap.command", "serve as an interface of Wireshark; only Wireshark calls this"),
    "bus": ("sisbus.command", "simulate a bus, to try everything without a drive"),
    "help": ("sistap.commands.web.help", "open the handbook in a browser"),
    "replay": ("sisbus.replay", "play a capture again with its original timing"),
}

DESCRIPTION = """\
A passive tap for the SIS serial protocol of Rexroth and Indramat drives. It records every character on the bus with its
time, for Wireshark. It only listens.
"""

EPILOG = """\
`sistap COMMAND --help` describes a command.

examples:
  sistap ports                                                     list the ports
  sistap capture -i /dev/ttyUSB0 -w - | wireshark -C SIS -k -i -   watch a bus live in Wireshark
  sistap bus                                                       start a simulated bus; it prints its port

exit status:
  0  done; also when stopped by Ctrl-C or SIGTERM
  1  failed while running; what came before is saved
  2  wrong usage
  3  a port cannot be opened
"""


# Help texts have the ports of Linux and, in commands, single quotes, which cmd.exe does not know.
_TYPED = "  sistap "
_OF_EXAMPLES = {"win32": {"/dev/ttyUSB0": "COM5", "/dev/ttyUSB1": "COM6", "'": '"'}}


def main(arguments: Sequence[str] | None = None, stop: Stop | None = None) -> int:
    """Run `sistap` with these arguments (default: those of the process); return the exit code.

    `stop` belongs to a process that ends with the command. Without it, main restores the signal handlers on return.
    """
    stop = stop or Stop()
    try:
        _open_standard_streams()
    except OSError as error:
        return _without_null_device(error)
    try:
        return _flushed(sys.argv[1:] if arguments is None else arguments, stop)
    except Stopped:
        return _stopped(stop)
    except Exception as error:
        if stop.asked and stop.at_once:  # C code of libraries may turn Stopped into an ImportError or another error
            return _stopped(stop)
        return _failed(error)


def _without_null_device(error: OSError) -> int:
    """Say how to get it back; return the exit code. All that sistap runs needs it, too."""
    from sistap.tap.terminal.advice import advice

    with suppress(OSError):  # standard error may be closed
        Console().say(f"{os.devnull} cannot be opened ({error.strerror}): {advice().null_device}")
    return FAILED


def _failed(error: Exception) -> int:
    """Report an error in one line and return the exit code. Raise an unexpected error again."""
    if isinstance(error, OSError):
        leave_standard_output()
        if not is_reader_gone(error, is_file=error.filename is not None):
            Console().say(_words(error))
        return FAILED
    if isinstance(error, ModuleNotFoundError) and error.name and error.name.partition(".")[0] == "serial":
        from sistap.tap.common.packages import missing

        Console().say(missing("pyserial"))
        return FAILED
    raise error


def _words(error: OSError) -> str:
    """Describe an error. Commands catch those of their files: one without a name is of what they print."""
    is_of_output = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EBADF) and error.filename is None
    if not is_of_output:
        return str(error)
    from sistap.tap.common.writing import loss

    return loss(error)


def _stopped(stop: Stop) -> int:
    """End the process without a message."""
    stop.end()
    end_standard_output()
    return DONE


def _flushed(arguments: Sequence[str], stop: Stop) -> int:
    """Run, then flush standard output. Do not flush after a stop: flushing may block."""
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
    """An argument parser that makes file names safe to print in its error messages."""

    def error(self, message: str) -> NoReturn:
        """Print the error and exit."""
        super().error(visible(message))


def parser(called: Container[str] = COMMANDS, listed: Iterable[str] = COMMANDS) -> argparse.ArgumentParser:
    """Return the parser of `sistap`. It knows the commands `listed`, each of which takes it half a millisecond.

    Only the commands in `called` get their options: others are not imported.
    """
    whole = _Parser(
        "sistap", description=DESCRIPTION, epilog=examples(EPILOG), formatter_class=argparse.RawDescriptionHelpFormatter
    )
    whole.add_argument("--version", action="version", version=f"sistap {sistap.__version__}")
    commands = whole.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name in listed:
        module_name, text = COMMANDS[name]
        command = commands.add_parser(name, help=text, formatter_class=argparse.RawDescriptionHelpFormatter)
        if name in called:
            module = importlib.import_module(module_name)
            command.description, command.epilog = module.DESCRIPTION, examples(getattr(module, "EPILOG", ""))
            if hasattr(module, "add_arguments"):
                module.add_arguments(command)
            command.set_defaults(run=getattr(module, "RUN", module_name), whole_parser=parser)
    return whole


def _run(arguments: Sequence[str], stop: Stop) -> int:
    if not arguments:
        parser(()).print_help(sys.stderr)
        return USAGE
    called = next((argument for argument in arguments if not argument.startswith("-")), "")
    if called and called not in COMMANDS and (close := get_close_matches(called, COMMANDS, 1)):
        Console().say(f"there is no command '{visible(called)}': did you mean `sistap {close[0]}`?")
        return USAGE
    args = parser({called}, [called] if arguments[0] in COMMANDS else COMMANDS).parse_args(arguments)
    run = importlib.import_module(args.run).run
    with stop:
        try:
            code: int = run(args)
        except Refusal as refusal:
            code = _refused(refusal)
        sys.stdout.flush()  # while a signal can still interrupt waiting for a slow reader
    return code


def _refused(refusal: Refusal) -> int:
    """Say why a command ends; return its exit code."""
    console = Console()
    console.progress("")  # that of the command may still be there
    console.say(str(refusal))
    return refusal.code


def _open_standard_streams() -> None:
    """Open closed standard streams, so that no port gets the descriptor of one and receives what is printed.

    They are opened for reading only, so writing to them still fails.
    """
    while (descriptor := os.open(os.devnull, os.O_RDONLY)) <= 2:
        pass
    os.close(descriptor)
    if sys.stdout is None:  # programs with windows have none on Windows
        sys.stdout = open(1 if sys.platform != "win32" else os.devnull, "w")  # noqa: SIM115 - while the process lives
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115 - the same


def examples(text: str, system: str = "") -> str:
    """Return a help text with the ports of a system; text after two blanks keeps its column."""
    words = _OF_EXAMPLES.get(system or sys.platform, {})
    return "".join(_translated(line, words) for line in text.splitlines(keepends=True))


def _translated(line: str, words: dict[str, str]) -> str:
    new = line
    for word, other in words.items():
        if len(word) > 1 or line.startswith(_TYPED):
            new = new.replace(word, other)
    return re.sub(r"(?<=\S)  ", " " * (2 + len(line) - len(new)), new, count=1)
