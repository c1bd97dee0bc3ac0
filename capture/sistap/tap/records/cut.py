# SPDX-License-Identifier: GPL-2.0-or-later
"""How characters are cut into frames: the option --framing, and its framers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sistap.tap.line.settings import LineSettings
from sistap.tap.records.framer import AsciiFramer, Framer, SilenceFramer, SisFramer
from sistap.tap.records.framer_3964r import Framer3964R
from sistap.tap.records.record import Framing

WORDS = "sis|3964r|ascii|silence:MS"
HELP = (
    "what to look for: SIS telegrams (the default), blocks of procedure 3964R, lines of the ASCII protocol of drives "
    "with SIS telegrams between them, or frames between silences of MS ms"
)
LONGEST_MS = 1e12  # more than 30 years


@dataclass(frozen=True)
class Cut:
    """A way of cutting."""

    framing: Framing = Framing.SIS
    silence_ms: float = 0  # for Framing.SILENCE

    @classmethod
    def parse(cls, text: str) -> Cut:
        """Parse the option. ValueError says what is expected."""
        if text in _BY_NAME:
            return _BY_NAME[text]
        name, _, value = text.partition(":")
        try:
            if name == "silence" and 0 < (silence_ms := float(value)) <= LONGEST_MS:
                return cls(Framing.SILENCE, silence_ms)
        except ValueError:
            pass
        raise ValueError(f"'{text}' is not {', '.join(_BY_NAME)} or silence:MILLISECONDS")

    def framer(self, line: int, settings: LineSettings) -> Framer:
        """Return the framer of a line."""
        if self.framing == Framing.SILENCE:
            return SilenceFramer(line, settings, int(self.silence_ms * 1e6))
        return _FRAMERS[self.framing](line, settings)

    @property
    def said(self) -> str:
        """Return its part in the description of a capture; empty for SIS."""
        if self.framing == Framing.SILENCE:
            return f"; frames cut by {self.silence_ms:g} ms of silence"
        return _SAID[self.framing]


SIS = Cut()
PROCEDURE_3964R = Cut(Framing.PROCEDURE_3964R)
ASCII = Cut(Framing.ASCII)
_BY_NAME = {"sis": SIS, "3964r": PROCEDURE_3964R, "ascii": ASCII}
_SAID = {Framing.SIS: "", Framing.PROCEDURE_3964R: "; blocks of procedure 3964R", Framing.ASCII: "; lines of text"}
_FRAMERS: dict[Framing, Callable[[int, LineSettings], Framer]] = {
    Framing.SIS: SisFramer,
    Framing.PROCEDURE_3964R: Framer3964R,
    Framing.ASCII: AsciiFramer,
}
