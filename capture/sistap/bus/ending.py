# SPDX-License-Identifier: GPL-2.0-or-later
"""How a command that plays ends when it cannot go on: the one line for it."""

from __future__ import annotations


class Refusal(Exception):
    """It does not begin or go on; the text is one line that names the cure."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text.replace("\n", "\\n"))  # names of files can have several
        self.code = code
