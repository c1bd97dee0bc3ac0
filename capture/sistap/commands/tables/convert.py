# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts captures into a folder of tables."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from pathlib import Path

import sistap
from sistap.commands.tables.judging import Judging
from sistap.commands.tables.rows import FIELDS, Row, Rows
from sistap.commands.tables.store import Store
from sistap.dissected.captures import portions
from sistap.dissected.episodes.rules import Thresholds
from sistap.dissected.packets.dissection import Dissection, Packet
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common.garbage import uncollected
from sistap.tap.terminal.console import Console, visible

_PROGRESS_EVERY = 5000  # packets


def put(  # noqa: PLR0913 - each comes from another part
    tshark: Tshark, captures: Sequence[Path], store: Store, tap: str, thresholds: Thresholds, console: Console
) -> None:
    """Add captures to the tables, in the order of their time, and report the results.

    What happened is judged over all of them, so known ones are read again if one is new. Raise Refusal.
    """
    digests = [_digest(capture, tap) for capture in captures]
    judged = hashlib.blake2b("".join([*digests, str(thresholds)]).encode()).hexdigest()[:32]
    is_judged = store.has(judged)
    judging = Judging(thresholds)
    for capture, digest in zip(captures, digests, strict=True):
        is_known = store.has(digest)
        if is_known:
            console.say(f"{capture}: is in the tables")
        if is_known and is_judged:
            continue
        with (
            closing(portions.in_turn([capture], portions.TOGETHER, console.say)) as parts,
            Dissection(tshark, parts, FIELDS, keeps=False) as dissection,
            uncollected(),
        ):
            packets = judging.packets(_told(dissection, capture, console), visible(capture.name))
            if is_known:
                deque(packets, maxlen=0)
                continue
            count = store.put(digest, capture, tap, _rows(packets, capture))
        _report(dissection, capture, count, console)
    if not is_judged:
        count = store.put(judged, captures[0], tap, judging.rows(), judging.name)
        console.say(f"what happened: {count} rows")


def _report(dissection: Dissection, capture: Path, count: int, console: Console) -> None:
    if dissection.warning:
        console.say(f"{capture}: only what comes before the damage: {dissection.warning}")
    if dissection.missing:
        console.say(f"left empty, as the installed dissector does not know it: {', '.join(dissection.missing)}")
    console.say(f"{capture}: {count} rows")


def _told(dissection: Dissection, capture: Path, console: Console) -> Iterator[Packet]:
    """Yield all packets, and tell how far it is."""
    for count, packet in enumerate(dissection.packets(), 1):
        yield packet
        if count % _PROGRESS_EVERY == 0:
            console.progress(f"{capture}: {count} packets read, {packet.time_s:.0f} s of it")


def _rows(packets: Iterable[Packet], capture: Path) -> Iterator[Row]:
    made = Rows(visible(capture.name))
    return (row for packet in packets for row in made.of(packet))


def _digest(capture: Path, tap: str) -> str:
    """Return a name for these bytes, as this version converts them."""
    with capture.open("rb") as file:
        whole = hashlib.file_digest(file, "blake2b")
    whole.update(f"{tap}\0{sistap.__version__}".encode())
    return whole.hexdigest()[:32]
