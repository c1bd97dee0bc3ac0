# SPDX-License-Identifier: GPL-2.0-or-later
"""The folder of tables: `TABLE/tap=TAP/day=DAY/CAPTURE-ID-NUMBER.parquet`, the partitions of DuckDB, Spark and others.

A capture's files appear when all are complete, and replace its earlier files. A telegram that another capture has
already added is left out.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import suppress
from datetime import date, timedelta
from functools import lru_cache
from operator import itemgetter
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from sistap.commands.tables.rows import Row
from sistap.commands.tables.schema import TABLES
from sistap.tap.common.writing import Beside, make_folder
from sistap.tap.terminal.console import visible
from sistap.tap.terminal.exits import FAILED, Refusal
from sistap.tap.terminal.stop import held
from sistap.tap.terminal.writing import mode_like

_TOGETHER = 1 << 15  # rows of all tables that wait to be written
_OPEN = 32  # files open at a time
_NOTES = "_captures"  # programs ignore names that begin with _
_NS_PER_US = 1000
_DAY_US = 86_400_000_000
_EPOCH = date(1970, 1, 1)  # Windows has no time before it
_LONGEST = 100  # characters of a name or a reason that comes from elsewhere


class Partition(NamedTuple):
    """A partition of a table."""

    table: str
    tap: str
    day: str

    def folder(self, root: Path) -> Path:
        """Return its path."""
        return root / self.table / f"tap={self.tap}" / f"day={self.day}"


class Store:
    """A folder of tables."""

    def __init__(self, root: Path) -> None:
        self._root = root

    def has(self, digest: str) -> bool:
        """Tell whether a capture with these bytes is complete in the tables."""
        try:
            files = json.loads(self._note(digest).read_text("utf-8"))["files"]
            return all((self._root / file).is_file() for file in files)
        except (OSError, ValueError, KeyError, TypeError, RecursionError):  # a damaged note: it is written again
            return False

    def put(self, digest: str, capture: Path, tap: str, rows: Iterable[Row], name: str = "") -> int:
        """Add a capture's rows; return how many are new. `name` is for rows of several captures: they replace earlier
        ones of the same name. Refusal if there is no room.
        """
        incoming = _Incoming(self._root, capture, tap, name)
        try:
            for row in rows:
                incoming.add(row)
            files = incoming.finish()
            self._forget(incoming.id, set(files))
            self._write_note(digest, capture, incoming.id, files)
        except OSError as error:
            reason = f"{error.filename}: {error.strerror}" if error.filename else error.strerror or error
            cure = "move that away" if isinstance(error, FileExistsError | NotADirectoryError) else "make room"
            raise Refusal(f"{self._root} is incomplete: {reason}; {cure}, and run it again", FAILED) from None
        finally:
            incoming.clear()
        return incoming.count

    def _note(self, digest: str) -> Path:
        return self._root / _NOTES / f"{digest}.json"

    def _write_note(self, digest: str, capture: Path, capture_id: str, files: list[str]) -> None:
        note = self._note(digest)
        mode = mode_like([capture])
        make_folder(note.parent, mode)
        new = Beside(note, mode)
        try:
            new.file.write(json.dumps({"id": capture_id, "files": files}).encode())
            new.replace()
        finally:
            new.remove()

    def _forget(self, capture_id: str, files: set[str]) -> None:
        """Remove earlier files of the capture that it no longer has."""
        if not capture_id:
            return
        for file in self._root.glob(f"*/tap=*/day=*/*-{capture_id}-*.parquet"):
            if file.relative_to(self._root).as_posix() not in files:
                file.unlink()


class _Incoming:
    """A capture on its way into the folder."""

    def __init__(self, root: Path, capture: Path, tap: str, name: str) -> None:
        self._root = root
        self._capture = visible(capture.name)
        self._mode = mode_like([capture])
        self._tap = tap
        self._waiting: defaultdict[Partition, list[dict[str, Any]]] = defaultdict(list)
        self._waiting_rows = 0
        self._writers: dict[Partition, tuple[pq.ParquetWriter, BinaryIO]] = {}
        self._numbers: defaultdict[Partition, int] = defaultdict(int)  # files of each partition
        self._files: list[tuple[Beside, Path]] = []  # new files, and their places
        # It stays the same if the capture grows or is dissected again.
        self.id = _id(f"{name}\0{tap}") if name else ""
        self.count = 0

    def add(self, row: Row) -> None:
        values = row.values
        tap = self._tap or slug(values["port"])
        if not self.id:
            self.id = _id(f"{self._capture}\0{tap}\0{values['epoch_ns']}")
        values["time"] = values["epoch_ns"] // _NS_PER_US
        self._waiting[_part(row.table, tap, values["time"] // _DAY_US)].append(values)
        self._waiting_rows += 1
        if self._waiting_rows == _TOGETHER:
            self._write()

    def finish(self) -> list[str]:
        """Rename all files to their final names; return these, relative to the folder."""
        self._write()
        for part in list(self._writers):
            self._close(part)
        for new, _ in self._files:
            new.replace()
        return [file.relative_to(self._root).as_posix() for _, file in self._files]

    def clear(self) -> None:
        """Remove incomplete files."""
        for part in list(self._writers):
            with suppress(OSError):
                self._close(part)
        for new, _ in self._files:
            new.remove()

    def _write(self) -> None:
        for part, values in self._waiting.items():
            table = TABLES[part.table]
            new = list(self._unknown(part, values))
            if new:
                columns = dict(zip(new[0], zip(*map(dict.values, new), strict=True), strict=True))
                self._writer(part).write_table(pa.table(columns, schema=table.schema))
                self.count += len(new)
        self._waiting.clear()
        self._waiting_rows = 0

    def _unknown(self, part: Partition, values: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        """Yield the rows that no other capture has added to this partition."""
        table = TABLES[part.table]
        files = [str(file) for file in part.folder(self._root).glob("*.parquet") if f"-{self.id}-" not in file.name]
        if not files:
            return iter(values)
        times, time = [row["epoch_ns"] for row in values], ds.field("epoch_ns")
        try:
            known = ds.dataset(files, table.schema).to_table([*table.same], (time >= min(times)) & (time <= max(times)))
        except (pa.ArrowException, OSError) as error:
            strange = next((file for file in files if not _is_of(file, table.schema)), part.folder(self._root))
            reason = str(error).partition("\n")[0][:_LONGEST]
            raise Refusal(
                f"{strange}: {reason}: move what is none of the tables away, and run it again", FAILED
            ) from None
        there = set(zip(*known.to_pydict().values(), strict=True))
        key = itemgetter(*table.same)
        return (row for row in values if key(row) not in there)

    def _writer(self, part: Partition) -> pq.ParquetWriter:
        if part not in self._writers:
            if len(self._writers) == _OPEN:
                self._close(next(iter(self._writers)))
            file = self._file(part)
            self._writers[part] = pq.ParquetWriter(file, TABLES[part.table].schema, compression="zstd"), file
        return self._writers[part][0]

    def _file(self, part: Partition) -> BinaryIO:
        folder = part.folder(self._root)
        make_folder(folder, self._mode)
        name = f"{slug(Path(self._capture).stem)}-{self.id}-{self._numbers[part]}.parquet"
        self._numbers[part] += 1
        with held():
            new = Beside(folder / name, self._mode)
            self._files.append((new, folder / name))
        return new.file

    def _close(self, part: Partition) -> None:
        writer, file = self._writers.pop(part)
        writer.close()
        file.close()


def _is_of(file: str, schema: pa.Schema) -> bool:
    """Tell whether a file is one of a table."""
    try:
        return Path(file).is_file() and pq.read_schema(file).equals(schema)  # a pipe would wait for a writer
    except (pa.ArrowException, OSError):
        return False


def _id(name: str) -> str:
    return hashlib.blake2b(name.encode(), digest_size=8).hexdigest()


@lru_cache
def _part(table: str, tap: str, day: int) -> Partition:
    """Return the partition of a day, counted from 1970 on."""
    return Partition(table, tap, (_EPOCH + timedelta(days=day)).isoformat())


@lru_cache
def slug(name: str) -> str:
    """Return a name that is a valid folder on every system and needs no quotes in SQL."""
    return re.sub(r"[^A-Za-z0-9.-]+", "_", name).strip("_.")[:_LONGEST] or "unnamed"
