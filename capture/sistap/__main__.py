# SPDX-License-Identifier: GPL-2.0-or-later
"""So that `python3 -m sistap` is the command, as what pip installs is."""

import sys

from sistap.terminal.stop import Stop


def main() -> int:
    """Be the command `sistap` in a process of its own; return the exit code."""
    stop = Stop()
    stop.begin()  # before the imports: they take a third of a second, and Ctrl-C must not show what they are at
    from sistap.cli import main as command

    return command(stop=stop)


if __name__ == "__main__":
    sys.exit(main())
