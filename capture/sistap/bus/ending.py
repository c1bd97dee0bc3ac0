# SPDX-License-Identifier: GPL-2.0-or-later
"""The error that ends a playing command, with its one line."""

from __future__ import annotations


class Refusal(Exception):
    """The command does not begin or cannot continue; the text is one line with the cure."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text.replace("\n", "\\n"))  # file names can have several lines
        self.code = code
