# SPDX-License-Identifier: GPL-2.0-or-later
"""The exit codes of all commands of sistap; `sistap --help` explains them."""

DONE, FAILED, USAGE, PORT = 0, 1, 2, 3


class UsageError(Exception):
    """Invalid options or files; str() is the line to show, and the command ends with USAGE."""
