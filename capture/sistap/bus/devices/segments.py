# SPDX-License-Identifier: GPL-2.0-or-later
"""Parts of a list, as IndraDrive reads them with 0x11 and 0x1E: the offset counts from the two lengths before the
elements.

IF02 chapter 8.3 counts from the first element, as Parameter does.
"""

from __future__ import annotations

from sistap.bus.devices.parameters import LENGTH_WORDS, Parameter


def read(parameter: Parameter, offset: int, length: int) -> bytes:
    """Return a part, as far as it goes; the lengths are at 0, and elements follow. May raise AccessError."""
    if offset == 0:
        parameter.check_list()
        return parameter.data[:length]
    return parameter.read_segment(offset - LENGTH_WORDS, length)


def write(parameter: Parameter, offset: int, data: bytes, phase: int) -> None:
    """Write a part. The lengths are at 0 and are written alone: they change the length of the list. May raise
    AccessError.
    """
    if offset == 0:
        parameter.resize(data, phase)
    else:
        parameter.write_segment(offset - LENGTH_WORDS, data, phase)
