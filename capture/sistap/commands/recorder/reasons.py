# SPDX-License-Identifier: GPL-2.0-or-later
"""Who decides what is kept: the episodes, and display filters. Each reason has a word for the name of its file."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from typing import NamedTuple

from sistap.dissected.episodes.machine import WRITTEN
from sistap.dissected.explain.relay import Judged
from sistap.dissected.wireshark import rows
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.sis.faults import WRITE
from sistap.tap.terminal.exits import Refusal

FAULTS = "faults"  # by the episodes
NOTHING = "nothing"  # the full ring is enough
_CYCLIC = ", ".join(f'"{ident}"' for ident in sorted(WRITTEN))
# Ready-made ones. A master control word is written in every cycle: that is no news.
FILTERS = {"writes": f"({WRITE.filter}) && !(sis.parameter in {{{_CYCLIC}}})"}
_MARK = ("frame.number", "data.data")
_LONGEST = 40  # characters of the word


class Reason(NamedTuple):
    """Why something is kept."""

    word: str
    from_ns: int | None = None  # when it began, if that was earlier


class ByFilter:
    """Keeps what a display filter finds."""

    finds = True  # tshark prints only matches, and marks

    def __init__(self, tshark: Tshark, keep: str) -> None:
        """Check the filter with tshark. Refusal."""
        if not keep.strip():
            raise Refusal(f"--keep needs a filter, or {' or '.join([FAULTS, *FILTERS])}")
        self._filter = FILTERS.get(keep, keep)
        self._word = WRITE.name if keep in FILTERS else word(keep)
        with tempfile.TemporaryFile() as empty:
            empty.write(pcapng.section_header("sistap", "") + pcapng.interface_description(pcapng.Interface(252, "x")))
            empty.seek(0)
            done = tshark.run(["-r", "-", *self.arguments(None)], stdin=empty)
        if done.returncode:
            said = (done.stderr.strip().splitlines() or ["tshark refuses it"])[0].removeprefix("tshark: ")
            raise Refusal(f"--keep '{keep}': {said}")

    def arguments(self, token: bytes | None) -> Sequence[str]:
        """Return the arguments for tshark: print matches and marks."""
        mark = f" || data.data == {token.hex(':')}" if token else ""
        return ["-Y", f"({self._filter}){mark}", *rows.printing(_MARK)]

    def columns(self, line: str) -> dict[str, str]:
        """Split what tshark prints."""
        return rows.columns(_MARK, line)

    def reason(self, judged: Judged) -> Reason | None:
        """Return why a packet is kept; None: it is not."""
        return Reason(self._word) if judged.columns else None

    def silent(self, _: int) -> Reason | None:
        """Return why a silence is kept: no filter finds one."""
        return None


def word(filter_: str) -> str:
    """Convert a filter into a word for a file name."""
    return re.sub(r"[^A-Za-z0-9.]+", "-", filter_)[:_LONGEST].strip("-.") or "found"
