# SPDX-License-Identifier: GPL-2.0-or-later
"""Starts Wireshark, wherever it is: for demo.cmd of the bundle.

python3 -m sistap.dissected.wireshark.window ARGUMENTS
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence

from sistap.dissected.wireshark.tshark import TsharkError, environment, found
from sistap.tap.terminal.console import Console
from sistap.tap.terminal.exits import DONE, FAILED


def main(arguments: Sequence[str]) -> int:
    """Start it; return the exit code."""
    try:
        program = found("wireshark")
        try:
            subprocess.Popen([program, *arguments], env=environment(program))
        except OSError as error:
            raise TsharkError(f"cannot start {program}: {error.strerror}") from error
    except TsharkError as error:
        Console().say(str(error))
        return FAILED
    return DONE


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
