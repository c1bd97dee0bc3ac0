# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of a list, counted from the two lengths before its elements on, as IndraDrive is read with 0x11 and 0x1E.

IF02 chapter 8.3 counts from the first element: that is what a parameter does itself.
"""

from __future__ import annotations

from sistap.bus.devices.parameters import LENGTH_WORDS, Parameter


def read(parameter: Parameter, offset: int, length: int) -> bytes:
    """Return a part, as far as it goes; at 0 are the lengths, and elements follow them. May raise AccessError."""
    if offset == 0:
        parameter.check_list()
        return parameter.data[:length]
    return parameter.read_segment(offset - LENGTH_WORDS, length)


def write(parameter: Parameter, offset: int, data: bytes, phase: int) -> None:
    """Write a part; at 0 are the lengths, alone, and they change how long the list is. May raise AccessError."""
    if offset == 0:
        parameter.resize(data, phase)
    else:
        parameter.write_segment(offset - LENGTH_WORDS, data, phase)
