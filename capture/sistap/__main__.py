# SPDX-License-Identifier: GPL-2.0-or-later
"""So that `python3 -m sistap` is the command."""

import sys

from sistap.cli import main

if __name__ == "__main__":
    sys.exit(main())
