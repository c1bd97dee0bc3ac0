# SPDX-License-Identifier: GPL-2.0-or-later
"""Make `python3 -m sistap` the same command as the one that pip installs."""

import os
import sys


def main() -> int:
    """Run the command `sistap` in a process of its own; return the exit code."""
    from sistap.tap.terminal.stop import Stop

    stop = Stop()
    stop.begin()  # before the imports: they take a third of a second, and Ctrl-C in that time must not show a traceback
    from sistap.cli import main as command

    return command(stop=stop)


def _leave_current_folder() -> None:
    """Import nothing from the current folder, unless sistap is there, as -P does: it may be anybody's."""
    own = os.path.realpath(os.path.join(__file__, "../.."))  # noqa: PTH118 - pathlib could be of that folder
    if not sys.flags.safe_path and sys.path and os.path.realpath(sys.path[0]) != own:
        del sys.path[0]


if __name__ == "__main__":
    _leave_current_folder()
    sys.exit(main())
