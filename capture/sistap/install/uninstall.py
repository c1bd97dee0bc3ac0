# SPDX-License-Identifier: GPL-2.0-or-later
"""The command `sistap uninstall`: takes away what `sistap install` has put, and nothing else."""

from __future__ import annotations

import argparse

from sistap.console import Console
from sistap.exits import FAILED
from sistap.install.command import is_root
from sistap.install.ledger import Ledger, LedgerError

DESCRIPTION = """\
Remove what `sistap install` has put on this machine, and the folders that it made; as root, what was installed for all
users. Says in a line each what it did. What somebody has changed since, or put beside it, is kept.
"""

EPILOG = """\
exit status:
  0  done, also if nothing was installed
  1  something could not be removed
  2  wrong usage
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG


def run(args: argparse.Namespace) -> int:
    """Remove; print a line for each file; give the exit code."""
    console = Console()
    code = 0
    try:
        ledger = Ledger(for_all=is_root())
        if not ledger.files:
            print(f"nothing to remove: nothing was installed for {'all users' if is_root() else 'this user'}")
        for file in ledger.files:
            try:
                print(ledger.remove(file))
            except OSError as error:
                console.say(str(error))
                code = FAILED
        for line in ledger.remove_folders():
            print(line)
        ledger.save()
    except (LedgerError, RuntimeError, OSError) as error:
        console.say(str(error))
        return FAILED
    return code
