# SPDX-License-Identifier: GPL-2.0-or-later
"""`python3 -m sistap.dissected.wireshark ARGUMENTS`: tshark without root's rights."""

import sys

from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import DONE, FAILED
from sistap.tap.terminal.stop import Stop, Stopped


def main() -> int:
    """Run tshark with the arguments of this process."""
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
