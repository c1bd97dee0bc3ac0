# SPDX-License-Identifier: GPL-2.0-or-later
"""How every command of sistap ends; `sistap --help` says what the codes mean."""

DONE, FAILED, USAGE, PORT = 0, 1, 2, 3


class UsageError(Exception):
    """Options or files that cannot be right; str() is the one line to show, and the command ends with USAGE."""
