# SPDX-License-Identifier: GPL-2.0-or-later
"""Make `python3 -m sistap` the same command as the one that pip installs."""

import sys


def main() -> int:
    """Run the command `sistap` in a process of its own; return the exit code."""
    from sistap.tap.terminal.stop import Stop

    stop = Stop()
    stop.begin()  # before the imports: they take a third of a second, and Ctrl-C in that time must not show a traceback
    from sistap.cli import main as command

    return command(stop=stop)


if __name__ == "__main__":
    sys.exit(main())
