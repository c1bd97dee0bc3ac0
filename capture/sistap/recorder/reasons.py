# SPDX-License-Identifier: GPL-2.0-or-later
"""What is kept: the presets, and the user's own filters; each with the word in the name of its files."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence

from sistap.files import pcapng
from sistap.sis.faults import FAULTS, WRITE, Fault
from sistap.terminal.exits import UsageError
from sistap.wireshark import rows
from sistap.wireshark.rows import NO_DISSECTOR, unknown_fields
from sistap.wireshark.tshark import Tshark, TsharkError

# The worst first: of a packet with several reasons, that is its word.
PRESETS: Mapping[str, Sequence[Fault]] = {"faults": FAULTS, "writes": [WRITE]}
_MARK = ("frame.number", "data.data")
_LONGEST = 40  # characters of the word


class Reasons:
    """The filters of --keep: names of presets, and at most one filter of the user's own."""

    def __init__(self, keep: Sequence[str]) -> None:
        """Parse the filters. UsageError if there are several own ones: tshark does not tell which of them matched."""
        self._faults = [fault for preset, faults in PRESETS.items() if preset in keep for fault in faults]
        self._tests = [test for fault in self._faults for test in fault.live_tests]
        own = [filter_ for filter_ in keep if filter_ not in PRESETS]
        if not all(filter_.strip() for filter_ in own):
            raise UsageError(f"--keep needs a filter, or {' or '.join(PRESETS)}")
        if len(own) > 1:
            raise UsageError(f"--keep takes one filter beside {' and '.join(PRESETS)}: join them with 'or'")
        self._own = own[0] if own else ""
        self._names = [*_MARK, *rows.tested(self._tests)]

    def arguments(self, token: bytes | None) -> list[str]:
        """Return the arguments for tshark: print matches and marks."""
        found = [*self._tests, *([f"({self._own})"] if self._own else [])]
        marks = [f"data.data == {token.hex(':')}"] if token else []
        return ["-Y", " || ".join(found + marks), *rows.printing(self._names)]

    def columns(self, line: str) -> dict[str, str]:
        """Split what tshark prints."""
        return rows.columns(self._names, line)

    def word(self, columns: Mapping[str, str]) -> str:
        """Return the word for the reason of a packet, for the name of a file."""
        words = (fault.word for fault in self._faults if rows.passes(fault.live_tests, columns))
        return next(words, "") or word(self._own)

    def check(self, tshark: Tshark) -> None:
        """Check the filter with tshark. UsageError, or TsharkError without a dissector for SIS."""
        with tempfile.TemporaryFile() as empty:
            empty.write(pcapng.section_header("sistap", "") + pcapng.interface_description(pcapng.Interface(252, "x")))
            empty.seek(0)
            done = tshark.run(["-r", "-", *self.arguments(None), "-e", rows.NECESSARY], stdin=empty)
        if done.returncode == 0:
            return
        if rows.NECESSARY in unknown_fields(done.stderr) or not self._own:
            raise TsharkError(NO_DISSECTOR)
        said = (done.stderr.strip().splitlines() or ["tshark refuses it"])[0].removeprefix("tshark: ")
        raise UsageError(f"--keep '{self._own}': {said}")


def word(filter_: str) -> str:
    """Convert a filter into a word for a file name."""
    return re.sub(r"[^A-Za-z0-9.]+", "-", filter_)[:_LONGEST].strip("-.") or "found"
