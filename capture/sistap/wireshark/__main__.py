# SPDX-License-Identifier: GPL-2.0-or-later
"""So that `python3 -m sistap.wireshark ARGUMENTS` is tshark that drops its rights first."""

import sys

from sistap.terminal.exits import DONE, FAILED
from sistap.terminal.stop import Stop, Stopped
from sistap.terminal.visible import visible
from sistap.wireshark.tshark import Tshark, TsharkError


def main() -> int:
    """Be tshark."""
    stop = Stop()
    stop.begin()
    try:
        with stop, Tshark() as tshark:
            return tshark.run(sys.argv[1:], capture=False).returncode
    except Stopped:
        stop.end()
        return DONE
    except (TsharkError, OSError) as error:
        print(f"sistap: {visible(str(error))}", file=sys.stderr)
        return FAILED


if __name__ == "__main__":
    sys.exit(main())
