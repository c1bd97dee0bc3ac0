# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says when it fails: that a file is no capture, is cut off, or that it does not know a field."""

from __future__ import annotations

import re
from pathlib import Path

from sistap.tap.common.packed import no_capture
from sistap.tap.terminal.exits import FAILED, NotCaptured, Refusal

_CUT = ("cut short", "damaged")
_NOT_A_CAPTURE = "isn't a capture file"


class TsharkError(Refusal):
    """tshark is missing or failed; the text is the line to show."""

    code = FAILED


def unknown_fields(said: str) -> set[str]:
    """Return the fields that tshark refuses as unknown, from its message."""
    return set(re.findall(r"^\s+(\S+)$", said, re.MULTILINE)) if "fields aren't valid" in said else set()


def is_no_capture(error: TsharkError) -> bool:
    """Tell whether tshark failed because the file is not a capture."""
    return _NOT_A_CAPTURE in str(error)


def is_cut(error: TsharkError) -> bool:
    """Tell whether tshark failed at the end of a capture that is cut off or damaged."""
    return any(words in str(error) for words in _CUT)


def last_words(error: TsharkError, capture: str = "the capture") -> str:
    """Return the last line of tshark's message, with `capture` as its name: as root, tshark reads a copy."""
    return re.sub(r'The file "[^"]*"', capture, str(error).splitlines()[-1].removeprefix("tshark: "))


def damage(capture: Path, error: TsharkError, came: bool) -> str:
    """Describe the damage of a capture at whose end tshark failed; `came`: tshark printed something before.

    NotCaptured if it is none, TsharkError if tshark failed for another reason.
    """
    if is_no_capture(error):
        raise NotCaptured(no_capture(capture)) from None
    last = last_words(error)
    if not came and not is_cut(error):
        raise TsharkError(f"tshark: {last}") from None
    return last
