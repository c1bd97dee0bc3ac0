# SPDX-License-Identifier: GPL-2.0-or-later
"""The lines in which an extcap answers Wireshark: `kind {key=value}{key=value}`."""

from __future__ import annotations

from sistap.terminal.visible import visible

_NOT_IN_A_VALUE = str.maketrans("{}\r\n", "()  ")  # Wireshark has no way to quote them


def sentence(kind: str, **values: object) -> str:
    """Return a line; leave out None and empty values, except an empty `value`."""
    said = {key: str(value) for key, value in values.items() if value is not None and (value != "" or key == "value")}
    return f"{kind} " + "".join(f"{{{key}={text}}}" for key, text in said.items())


def plain(text: str) -> str:
    """Make a text from elsewhere safe for a sentence."""
    return visible(text.translate(_NOT_IN_A_VALUE))
