# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads the accesses of captures from tshark's output, one capture after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from sistap.accesses.access import FIELD, Access, accesses
from sistap.accesses.listing import Place
from sistap.wireshark import rows
from sistap.wireshark.rows import damage
from sistap.wireshark.tshark import Tshark, TsharkError

_COLUMNS = ("frame.number", "frame.time_epoch", "frame.interface_name", FIELD)
_NO_FIELD = (
    f"tshark has no dissector for SIS that knows {FIELD}: `sistap install` puts one where it looks, or name its folder "
    "in WIRESHARK_PLUGIN_DIR"
)


class Found(NamedTuple):
    """An access, and its place."""

    place: Place
    access: Access


def found(tshark: Tshark, captures: Iterable[Path], say: Callable[[str], None]) -> Iterator[Found]:
    """Yield all accesses up to a damage, which is reported. Raise NotACapture or TsharkError."""
    for capture in captures:
        yield from _of_capture(tshark, capture, say)


def _of_capture(tshark: Tshark, capture: Path, say: Callable[[str], None]) -> Iterator[Found]:
    came = False
    try:
        for line in tshark.lines(["-r", str(capture), "-Y", FIELD, *rows.printing(_COLUMNS)]):
            came = True
            columns = rows.columns(_COLUMNS, line)
            place = Place(capture.name, int(columns["frame.number"]), float(columns["frame.time_epoch"] or 0))
            for access in accesses(columns):
                yield Found(place, access)
    except TsharkError as error:
        if FIELD in str(error):
            raise TsharkError(_NO_FIELD) from None
        say(f"{capture}: only what comes before the damage: {damage(capture, error, came)}")
