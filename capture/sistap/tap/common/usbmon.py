# SPDX-License-Identifier: GPL-2.0-or-later
"""A line of usbmon's text, told from the lines of a log. Its tags and lengths look like bytes, and are none."""

from __future__ import annotations

import re

# Tag, time in us, event, and the address: type and direction, bus (not in the oldest form), device, endpoint.
LINE = re.compile(
    r"(?P<id>[0-9a-f]+) (?P<us>\d{1,12}) (?P<event>[SCE]) "
    r"(?P<type>[CBIZ])(?P<way>[io]):(?:(?P<bus>\d{1,5}):)?(?P<device>\d{1,3}):(?P<endpoint>\d{1,2})"
)


_HEAD = 4096  # characters


def is_usbmon(text: str) -> bool:
    """Tell whether one of the first lines is of usbmon; others may stand above it."""
    return re.search(rf"(?m)^\s*{LINE.pattern}", text[:_HEAD]) is not None
