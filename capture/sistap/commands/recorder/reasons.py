# SPDX-License-Identifier: GPL-2.0-or-later
"""Who decides what is kept: the episodes, as `sistap report` tells them, and display filters; and who passes values on.

Each reason has a word for the name of its file."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from typing import NamedTuple

from sistap.commands.recorder.values import ValueLines
from sistap.dissected.episodes.episode import Hit, severity_of
from sistap.dissected.episodes.live import FIELD, LiveEpisodes
from sistap.dissected.episodes.rules import Thresholds
from sistap.dissected.episodes.standard import FORMS
from sistap.dissected.explain.fields import Fields
from sistap.dissected.explain.relay import JudgedEntry
from sistap.dissected.packets.dissection import FIELDS, packet_of
from sistap.dissected.wireshark import rows
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.sis.faults import WRITE
from sistap.tap.terminal.exits import Refusal

FAULTS = "faults"  # by the episodes
NOTHING = "nothing"  # the full ring is enough
_CYCLIC = ", ".join(f'"{ident}"' for ident, form in sorted(FORMS.items()) if form == "control_word")
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

    def reason(self, judged: JudgedEntry) -> Reason | None:
        """Return why a packet is kept; None: it is not."""
        return Reason(self._word) if judged.columns else None

    def silent(self, _: int) -> Reason | None:
        """Return why a silence is kept: no filter finds one."""
        return None


def word(filter_: str) -> str:
    """Convert a filter into a word for a file name."""
    return re.sub(r"[^A-Za-z0-9.]+", "-", filter_)[:_LONGEST].strip("-.") or "found"


class ByEpisodes:
    """Keeps what begins or goes on, if `keeps`; gives `values` all values of parameters."""

    finds = False  # tshark prints every packet

    def __init__(self, tshark: Tshark, thresholds: Thresholds, values: ValueLines | None, *, keeps: bool) -> None:
        """Ask tshark for its fields. TsharkError if it has no dissector for SIS."""
        self._fields = Fields(tshark, (*FIELDS, FIELD))
        self._live = LiveEpisodes(thresholds) if keeps else None
        self._values = values

    def arguments(self, _: bytes | None) -> Sequence[str]:
        """Return the arguments for tshark."""
        return self._fields.arguments

    def columns(self, line: str) -> dict[str, str]:
        """Split what tshark prints."""
        return self._fields.columns(line)

    def reason(self, judged: JudgedEntry) -> Reason | None:
        """Return why a packet is kept; None: it is not."""
        if judged.is_unjudged and self._live:
            self._live.skip()
        if not judged.columns:
            return None
        packet = packet_of(judged.columns)
        if self._values:
            self._values.put(judged.entry.time_ns, packet.accesses)
        return _worst(self._live.add(packet)) if self._live else None

    def silent(self, now_ns: int) -> Reason | None:
        """Return why the silence is kept that lasts."""
        return _worst(self._live.silent(now_ns / 1e9)) if self._live else None


Judge = ByEpisodes | ByFilter


def judges(
    tshark: Tshark, keep: Sequence[str], thresholds: Thresholds, values: ValueLines | None = None
) -> list[Judge]:
    """Return who decides: one for each value of --keep; and who gives `values` all values.

    Refusal if tshark has no dissector for SIS.
    """
    keeps = FAULTS in keep
    watching: list[Judge] = [ByEpisodes(tshark, thresholds, values, keeps=keeps)] if keeps or values else []
    return watching + [ByFilter(tshark, one) for one in dict.fromkeys(keep) if one not in (FAULTS, NOTHING)]


def _worst(hits: Sequence[Hit]) -> Reason | None:
    """Return the worst as a reason, from the beginning of all."""
    if not hits:
        return None
    kind = max(hits, key=severity_of).kind
    return Reason(kind.replace("_", "-"), round(min(hit.from_s for hit in hits) * 1e9))
