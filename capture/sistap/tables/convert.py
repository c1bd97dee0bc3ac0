# SPDX-License-Identifier: GPL-2.0-or-later
"""Puts a capture into a folder of tables."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import sistap
from sistap.common.garbage import uncollected
from sistap.episodes.engine import Engine
from sistap.packets.dissection import Dissection
from sistap.tables.rows import FIELDS, Row, of_episode, rows
from sistap.tables.store import Store
from sistap.terminal.console import Console
from sistap.wireshark.tshark import Tshark

_PROGRESS_EVERY = 5000  # packets


def put(tshark: Tshark, capture: Path, store: Store, tap: str, console: Console) -> None:
    """Add a capture to the tables, and report the result. Raise NotACapture, TsharkError, Incomplete or NoSuchTime."""
    digest = _digest(capture, tap)
    if store.has(digest):
        console.say(f"{capture}: is in the tables")
        return
    with Dissection(tshark, capture, FIELDS, keeps=False) as dissection, uncollected():
        count = store.put(digest, capture, tap, _rows(dissection, capture, console))
    if dissection.warning:
        console.say(f"{capture}: only what comes before the damage: {dissection.warning}")
    if dissection.missing:
        console.say(f"left empty, as the installed dissector does not know it: {', '.join(dissection.missing)}")
    console.say(f"{capture}: {count} rows")


def _rows(dissection: Dissection, capture: Path, console: Console) -> Iterator[Row]:
    engine = Engine()
    for count, packet in enumerate(dissection.packets(), 1):
        yield from rows(packet, capture.name)
        engine.add(packet)
        if count % _PROGRESS_EVERY == 0 and console.shows_progress:
            console.progress(f"{capture}: {count} packets read, {packet.time_s:.0f} s of it")
    yield from (of_episode(episode, capture.name) for episode in engine.finish())


def _digest(capture: Path, tap: str) -> str:
    """Return a name for these bytes, as this version converts them."""
    with capture.open("rb") as file:
        whole = hashlib.file_digest(file, "blake2b")
    whole.update(f"{tap}\0{sistap.__version__}".encode())
    return whole.hexdigest()[:32]
