# SPDX-License-Identifier: GPL-2.0-or-later
"""The description in Wireshark's profile: the colouring rules and the filter buttons."""

from __future__ import annotations

from collections.abc import Sequence

from description import Description

MADE = "Made by plugin/protocol/generate.py from faults.toml: edit there."


def _colour(colour: Sequence[int]) -> str:
    return f"[{','.join(map(str, colour))}]"


def colorfilters(description: Description) -> str:
    """Return the file with the colouring rules."""
    lines = [
        "# Colours of the rules; the first that holds is taken. Both are fixed, so that a dark theme changes neither.",
        f"# {MADE}",
    ]
    lines += [f"@{rule.name}@{rule.filter}@{_colour(rule.back)}{_colour(rule.fore)}" for rule in description.rules]
    return "\n".join([*lines, ""])


def dfilter_buttons(description: Description) -> str:
    """Return the file with the filter buttons."""
    lines = [f"# This file is the list of filter buttons of the profile. {MADE}"]
    lines += [f'"TRUE","{button.label}","{button.filter}","{button.says}"' for button in description.buttons]
    return "\n".join([*lines, ""])
