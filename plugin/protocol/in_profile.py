# SPDX-License-Identifier: GPL-2.0-or-later
"""The description in Wireshark's profile: the colouring rules, the filter buttons, and the I/O graphs of faults."""

from __future__ import annotations

from collections.abc import Sequence

from description import Description, Rule

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


def io_graphs(description: Description) -> str:
    """Return the rows of the I/O graphs that count faults, each in the colour of its rule."""
    graphs: dict[str, list[Rule]] = {}
    for rule in description.rules:
        if rule.graph:
            graphs.setdefault(rule.graph, []).append(rule)
    lines = []
    for name, rules in graphs.items():
        found = " || ".join(rule.filter for rule in rules)
        colour = "".join(f"{part >> 8:02x}" for part in rules[0].back)
        lines.append(f'"Enabled","{name}","{found}","#{colour}","Stacked Bar","Packets","","None","1"')
    return "\n".join([*lines, ""])


def dfilter_buttons(description: Description) -> str:
    """Return the file with the filter buttons."""
    lines = [f"# This file is the list of filter buttons of the profile. {MADE}"]
    lines += [f'"TRUE","{button.label}","{button.filter}","{button.says}"' for button in description.buttons]
    return "\n".join([*lines, ""])
