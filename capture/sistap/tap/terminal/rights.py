# SPDX-License-Identifier: GPL-2.0-or-later
"""How this user types a command that is for root."""

from __future__ import annotations

import os
import re
import shutil

from sistap.tap.terminal.state import is_root

_COMMAND = re.compile(r"`[^`]*`")


def needs_sudo() -> bool:
    """Tell whether this user types sudo: root does not, and not every system has it."""
    return not is_root() and shutil.which("sudo") is not None


def as_typed(text: str) -> str:
    """Return a message with its commands as this user types them, or root for this user."""
    if "sudo" not in text or needs_sudo():
        return text
    text = _COMMAND.sub(_without_sudo, text)
    return text.replace("with sudo", "as root").replace("$USER", os.environ.get("USER", "NAME"))


def _without_sudo(command: re.Match[str]) -> str:
    typed = re.sub(r"\bsudo ", "", command[0])
    return typed if is_root() or typed == command[0] else f"{typed} as root"
