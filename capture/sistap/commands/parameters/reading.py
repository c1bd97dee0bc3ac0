# SPDX-License-Identifier: GPL-2.0-or-later
"""Reads the accesses of captures from tshark's output, as of one capture."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import NamedTuple

from sistap.dissected.accesses.access import FIELD, Access, accesses
from sistap.dissected.accesses.listing import AccessPlace
from sistap.dissected.captures import portions
from sistap.dissected.captures.portions import Portion
from sistap.dissected.wireshark import rows
from sistap.dissected.wireshark.trouble import damage
from sistap.dissected.wireshark.tshark import Tshark, TsharkError
from sistap.tap.terminal.console import visible

_TOGETHER = 64_000_000  # bytes of captures that are read at once: tshark needs six times as much memory
_COLUMNS = ("frame.number", "frame.time_epoch", "frame.interface_name", FIELD)
_NO_FIELD = (
    f"tshark has no dissector for SIS that knows {FIELD}: `sistap install` puts one where it looks, or name its folder "
    "in WIRESHARK_PLUGIN_DIR"
)


class FoundAccess(NamedTuple):
    """An access, and its place."""

    place: AccessPlace
    access: Access


def found(tshark: Tshark, captures: Iterable[Path], say: Callable[[str], None]) -> Iterator[FoundAccess]:
    """Yield all accesses up to a damage, which is reported. Raise Refusal."""
    for several in portions.as_one(captures):
        with closing(portions.in_turn(several, _TOGETHER, say)) as parts:
            for portion in parts:
                yield from _of_portion(tshark, portion, say)


def _of_portion(tshark: Tshark, portion: Portion, say: Callable[[str], None]) -> Iterator[FoundAccess]:
    came = False
    # The second pass knows attributes that were read after values. The filter gives a script the fields that it needs.
    passes = ["-2", "-R", "frame"]
    try:
        for line in tshark.lines(["-r", str(portion.path), *passes, "-Y", FIELD, *rows.printing(_COLUMNS)]):
            came = True
            columns = rows.columns(_COLUMNS, line)
            number = int(columns["frame.number"])
            if not portion.owns(number):
                continue
            capture, number = portion.place(number)
            place = AccessPlace(visible(capture.name), number, float(columns["frame.time_epoch"] or 0))
            for access in accesses(columns.get("frame.interface_name", ""), columns.get(FIELD, "")):
                yield FoundAccess(place, access)
    except TsharkError as error:
        if FIELD in str(error):
            raise TsharkError(_NO_FIELD) from None
        capture = portion.begins[-1].capture
        say(f"{capture}: only what comes before the damage: {damage(capture, error, came)}")
