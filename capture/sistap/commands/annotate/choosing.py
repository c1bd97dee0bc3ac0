# SPDX-License-Identifier: GPL-2.0-or-later
"""Chooses how a log writes bytes: by its first megabyte, not by a line.

Notations, and the places where a few bytes stand, are chosen if they make telegrams with a right checksum: the one test
that no text passes by chance. A log without such a telegram is read in all plain notations.
"""

from __future__ import annotations

import re
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from sistap.commands.annotate.cutting import RecordCutter
from sistap.commands.annotate.notations import NOTATIONS, PAIRS, Numbers
from sistap.commands.annotate.reading import ANYTHING, ANYWHERE, Choice, ChosenReader, Contents, Prepared, places_of
from sistap.commands.annotate.textlog import LogLine
from sistap.tap.records.cut import SIS, Cut
from sistap.tap.records.record import Framing, Type
from sistap.tap.sis.telegram import STATIC_LENGTH, checksum_good

LONGEST = 1 << 20  # bytes of a file by which it is chosen
_LINES = 1000  # enough for a choice
_SEVERAL = 100  # bytes of telegrams that are none by chance, among ten times as many others: a dump of whole packets
_PLACES = 8  # of a notation are tried: those with most bytes
_JUDGED = (Framing.SIS, Framing.PROCEDURE_3964R)  # their frames have a checksum
_BEGINNING = re.compile(rb"(?=\x02.(.)\1)", re.DOTALL)  # of a telegram: start, checksum, equal lengths


class Score(NamedTuple):
    """How good a choice is: bytes of right telegrams, and other bytes, which are negative."""

    telegrams: int = 0
    others: int = 0


_NOTHING = Score(0, -LONGEST)


class AnyReader:
    """Reads the lines of a log in the notation that is right for it."""

    def __init__(self, sample: Sequence[LogLine] | None = None, framing: Cut = SIS) -> None:
        """Choose by the beginning of a file. Without it, choose as the lines come; those before stay as they are."""
        self._framing = framing
        self._kept: deque[LogLine] = deque(maxlen=_LINES)  # the last doubtful lines
        self._tried = len(sample or ())  # lines by which it was chosen before they are read
        self._doubtful = min(self._tried, _LINES)  # lines that were read without a choice, or have numbers only
        self._reader = ChosenReader(ANYTHING)
        self._is_chosen = False
        self._is_alone = True  # nearly all bytes are of damaged telegrams
        if sample is not None:
            self._choose(sample)
            self._reader.marks.note("\n".join(line.text for line in sample))

    @property
    def notation(self) -> str:
        """Name the notation if it is not the usual one."""
        return self._reader.choice.name

    @property
    def is_trusted(self) -> bool:
        """Whether a damaged telegram is one: the log has right ones, too, or hardly anything else."""
        return self._is_chosen or self._is_alone

    def contents(self, line: LogLine) -> Contents:
        """Find the bytes of a line."""
        if self._is_chosen or line.number <= self._tried:
            contents = self._reader.contents(line)
            is_doubtful = self._is_chosen and not contents.pieces and any(map(str.isdigit, line.text))
            if not is_doubtful or not self._doubt(line):
                return contents
        else:
            self._doubt(line)
        return self._reader.contents(line)

    def _doubt(self, line: LogLine) -> bool:
        """Choose again after one doubtful line, two, four, eight ...; tell whether that changed anything."""
        self._kept.append(line)
        self._doubtful += 1
        return not self._doubtful & (self._doubtful - 1) and self._choose(self._kept)

    def _choose(self, lines: Iterable[LogLine]) -> bool:
        before = self._reader.choice
        if choice := choose(lines, self._framing):
            self._reader.choice = before.joined(choice) if self._is_chosen else choice
            self._is_chosen = True
        elif not self._is_chosen:
            frames, others, widest = _sizes([*lines][-_LINES:], self._framing)
            self._is_alone = frames >= 2 * others
            # Of a pipe, nobody knows what comes.
            reads_few = not self._tried or bool(frames) or widest >= PAIRS.enough
            self._reader.choice = ANYTHING._replace(reads_few=reads_few)
        return self._reader.choice != before


def choose(lines: Iterable[LogLine], framing: Cut = SIS) -> Choice | None:
    """Choose by these lines; None if nothing makes a telegram."""
    if framing.framing not in _JUDGED:
        return None
    reader = ChosenReader(ANYTHING)
    prepared = [one for line in lines if (one := reader.prepare(line))]
    return next((choice for some in _windows(prepared) if (choice := _Chooser(some, framing).choose())), None)


def _windows(prepared: list[Prepared]) -> Iterator[list[Prepared]]:
    """Return all parts, in order: one with telegrams is enough for a choice."""
    return (prepared[at : at + _LINES] for at in range(0, len(prepared), _LINES))


def _sizes(lines: Iterable[LogLine], framing: Cut) -> tuple[int, int, int]:
    """Count, of a log without right telegrams, the bytes of damaged ones, other bytes, and the most side by side."""
    reader, cutter = ChosenReader(ANYTHING), RecordCutter(framing)
    pieces = [piece for line in lines for piece in reader.contents(line).pieces]
    records = [cut.record for cut in [cut for piece in pieces for cut in cutter.feed(piece)] + cutter.end()]
    frames = sum(len(record.data) for record in records if record.type == Type.FRAME)
    sizes = [len(piece.run.data) for piece in pieces]
    return frames, sum(sizes) - frames, max(sizes, default=0)


class _Chooser:
    """Tries choices on a part of a log."""

    def __init__(self, prepared: list[Prepared], framing: Cut) -> None:
        self._prepared = prepared
        self._framing = framing
        self._is_all_read = False  # by the last choice that was tried

    def choose(self) -> Choice | None:
        """Return what makes most telegrams, with as little as possible; None if nothing makes any."""
        score, best = self._tried(Choice((PAIRS,)))
        if not score.telegrams or not self._is_all_read:
            best = self._longer()
        return best._replace(name=self._name(best)) if best.notations else None

    def _longer(self) -> Choice:
        """Try all notations and places; add to the best as long as that makes more of telegrams than of others."""
        best, score = Choice(()), _NOTHING
        likely, unlikely = self._candidates()
        candidates = likely
        while True:
            tried = [self._tried(best.joined(candidate)) for candidate in candidates]
            better, choice = max(tried, key=lambda one: sum(one[0]), default=(score, best))
            if sum(better) <= sum(score):
                return best
            best, score = choice, better
            candidates = likely + [one for one in unlikely if one.notations[0] in best.notations or not one.places]

    def _candidates(self) -> tuple[list[Choice], list[Choice]]:
        """Return notations and places, those whose bytes have the beginning of a telegram apart."""
        text = "\n".join(one.masked for one in self._prepared)
        found: tuple[list[Choice], list[Choice]] = [], []
        for notation in NOTATIONS:
            at: defaultdict[str, bytearray] = defaultdict(bytearray)
            everything = bytearray()
            for one in self._prepared if notation.hint.search(text) else ():
                runs, _ = notation.runs(one.masked)
                wide = [notation.is_wide(run, one.masked) for run in runs]
                for run, place in zip(runs, places_of(one.masked, runs, wide), strict=True):
                    at[place] += run.data
                    everything += run.data
            most = sorted(filter(None, at), key=lambda place: -len(at[place]))[:_PLACES]
            for where, data in [("", everything), *((place, at[place]) for place in most), (ANYWHERE, everything)]:
                places = frozenset({(notation.name, where)} if where else ())
                if data:
                    found[not self._may_be(data)].append(Choice((notation,), places))
        return found

    def _may_be(self, data: bytes) -> bool:
        """Tell whether bytes have a right telegram, if that is quick to tell."""
        ends = ((one.start(), one.start() + STATIC_LENGTH + one[1][0]) for one in _BEGINNING.finditer(data))
        return self._framing != SIS or any(end <= len(data) and checksum_good(data[at:end]) for at, end in ends)

    def _tried(self, choice: Choice) -> tuple[Score, Choice]:
        """Return the score of a choice: nothing if it makes mostly other bytes, unless there are several telegrams."""
        score = self._score(choice)
        return (score if score.telegrams > min(-score.others, _SEVERAL - score.others // 10) else _NOTHING), choice

    def _score(self, choice: Choice) -> Score:
        reader, cutter = ChosenReader(choice), RecordCutter(self._framing)
        cuts = []
        self._is_all_read = True
        for one in self._prepared:
            pieces = reader.read(one).pieces
            self._is_all_read &= bool(pieces) or not any(map(str.isdigit, one.masked))
            for piece in pieces:
                cuts += cutter.feed(piece)
        sizes = [0, 0]
        for record, _ in cuts + cutter.end():
            sizes[record.is_good_frame and not record.is_handshake] += len(record.data)
        return Score(sizes[True], -sizes[False])

    def _name(self, choice: Choice) -> str:
        """Name the notations; nothing for hexadecimal numbers, as usual."""
        names = []
        for notation in choice.notations:
            if isinstance(notation, Numbers) and notation.is_plain:
                continue
            runs = (run for one in self._prepared for run in notation.runs(one.masked)[0] if len(run.data) > 1)
            wide = max(runs, key=lambda run: len(run.data), default=None)
            names.append(notation.name + (notation.separated(wide) if wide and isinstance(notation, Numbers) else ""))
        return "; ".join(names)
