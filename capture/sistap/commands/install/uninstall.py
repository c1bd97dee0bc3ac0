# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap uninstall`: removes what `sistap install` has installed, and nothing else."""

from __future__ import annotations

import argparse
from pathlib import Path

from sistap.commands.install import command, personal
from sistap.commands.install.ledger import ElsewhereError, Ledger
from sistap.commands.install.turn import alone
from sistap.dissected.wireshark import folders, profile
from sistap.dissected.wireshark.tshark import TsharkError
from sistap.tap.line import measurement
from sistap.tap.terminal import programs
from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.console import Console, visible
from sistap.tap.terminal.exits import DONE, FAILED
from sistap.tap.terminal.rights import as_typed
from sistap.tap.terminal.state import is_root
from sistap.tap.terminal.stop import held

DESCRIPTION = """\
Remove what `sistap install` has installed on this computer, and the folders that it made. As root, remove what was
installed for all users. sistap prints one line for each file. It keeps files that somebody has changed or added.
Wireshark writes files of the profile anew when somebody changes a setting: the last line says how to remove them.
sistap touches only Wireshark's own folders, as tshark names them, and those of the command `sistap` and its completion.
The results of self-tests go, too.
"""

EPILOG = """\
exit status:
  0  done, also if nothing was installed
  1  something could not be removed, or tshark is missing
  2  wrong usage
"""


OF_PACKAGE = Path("/usr/share/sistap")


def run(args: argparse.Namespace) -> int:
    """Remove; print a line for each file; return the exit code."""
    console = Console()
    try:
        named = _named()
        with alone(for_all=is_root()) as ledger:
            removed = _uninstall(ledger, named, console)
    except TsharkError as error:
        console.say(f"nothing is removed, as only tshark knows which folders are Wireshark's: {error}")
        return FAILED
    except (RuntimeError, OSError) as error:
        console.say(str(error))
        return FAILED
    return DONE if removed else FAILED


def _named() -> str | TsharkError:
    """Ask tshark for the folders, which can take long: nobody waits for his turn meanwhile."""
    try:
        return command.named_folders()
    except TsharkError as error:
        return error  # which matters only if there is something to remove


def _uninstall(ledger: Ledger, named: str | TsharkError, console: Console) -> bool:
    """Remove all; return whether that was possible. TsharkError, RuntimeError, OSError."""
    profiles = None if is_root() else _adopt_profile(ledger, named)
    if not ledger.files:
        whose = "all users" if is_root() else "this user"
        print(f"nothing to remove: nothing was installed for {whose}")
    removed = ledger.is_empty or _remove(ledger, command.own_folders(_known(named), for_all=is_root()), console)
    if profiles:
        personal.forget(profiles.parent)
        for line in personal.left(profiles / profile.NAME, ledger):
            print(visible(line))
    if removed:
        programs.forget()
        measurement.forget()
    if Path(__file__).is_relative_to(OF_PACKAGE) and (package := as_typed(advice().package)):
        print(package)
    return removed


def _adopt_profile(ledger: Ledger, named: str | TsharkError) -> Path | None:
    """Put the user's copy of the profile on the list; return the folder of profiles, if Wireshark is there."""
    try:
        profiles = folders.parse(_known(named), for_all=False).profiles
    except TsharkError:
        return None
    personal.adopt(ledger, profiles / profile.NAME)
    return profiles


def _known(named: str | TsharkError) -> str:
    if isinstance(named, TsharkError):
        raise named
    return named


def _remove(ledger: Ledger, own: folders.Own, console: Console) -> bool:
    """Remove what is on the list; return whether all of it could be removed. OSError if the list cannot be written."""
    lines: list[str] = []
    troubles: list[str] = []
    with held():  # so that the list stays true, whenever a signal comes
        for file in ledger.files:
            try:
                lines.append(ledger.remove(file, own))
            except (ElsewhereError, OSError) as error:
                troubles.append(str(error))
        lines += ledger.remove_folders(own)
        ledger.save()
    for line in lines:
        print(visible(line))
    for trouble in troubles:
        console.say(trouble)
    return not troubles
