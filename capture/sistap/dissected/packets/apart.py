# SPDX-License-Identifier: GPL-2.0-or-later
"""Takes the columns of a packet with several telegrams apart: tshark prints all values of a field together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from sistap.dissected.wireshark.rows import JOINT, NECESSARY

PACKED = "sis.packed"  # of each telegram but the first: its fields, with the number of values of each
_OF_TELEGRAMS = "sis."

Counts = Mapping[str, int]


def apart(columns: Mapping[str, str], telegrams: int) -> Sequence[Mapping[str, str]]:
    """Return the columns of each telegram. What is in the place of one, such as noise, is none."""
    values = {name: text.split(JOINT) for name, text in columns.items() if text and name.startswith(_OF_TELEGRAMS)}
    said = values.pop(PACKED, None)
    if said is None:
        return _alike(values, telegrams)
    parts = _of(values, [_counts(text) for text in said])
    return [part for part in parts if part.get(NECESSARY)]


def beside(columns: Mapping[str, str]) -> Mapping[str, str]:
    """Return the columns that are of no telegram."""
    return {name: text for name, text in columns.items() if not name.startswith(_OF_TELEGRAMS)}


def _counts(text: str) -> Counts:
    """Return what a telegram says: `sis.service=1 sis.start=1`."""
    return {name: int(count) for name, _, count in (one.partition("=") for one in text.split())}


def _of(values: Mapping[str, Sequence[str]], later: Sequence[Counts]) -> list[dict[str, str]]:
    """Deal the values out: what the later telegrams do not say is of the first."""
    parts: list[dict[str, str]] = [{} for _ in range(len(later) + 1)]
    for name, texts in values.items():
        counts = [one.get(name, 0) for one in later]
        places = [0, len(texts) - sum(counts)]
        for count in counts:
            places.append(places[-1] + count)
        if places[1] < 0:
            continue  # an empty text is not printed: nobody knows whose the others are
        for part, (begin, end) in zip(parts, pairwise(places), strict=True):
            if begin < end:
                part[name] = JOINT.join(texts[begin:end])
    return parts


def _alike(values: Mapping[str, Sequence[str]], telegrams: int) -> list[dict[str, str]]:
    """Deal the values out as an older dissector lets us: only fields of which each telegram has one."""
    certain = {name: texts for name, texts in values.items() if len(texts) == telegrams}
    return [{name: texts[place] for name, texts in certain.items()} for place in range(telegrams)]
