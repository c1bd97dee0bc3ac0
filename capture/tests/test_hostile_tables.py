# SPDX-License-Identifier: GPL-2.0-or-later
"""A folder of tables that others, a kill or a full disk have left their marks in."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable
from pathlib import Path

import pytest
from commands import refused, run

pa = pytest.importorskip("pyarrow", reason="pyarrow writes the tables: pip install pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

CAPTURE = Path(__file__).parents[2] / "test-captures/parameters.pcapng"
NOTES = ["[]", "null", "3", '"x"', '{"files":3}', '{"files":[1]}', f'{{"files":["{"a" * 5000}"]}}', "[" * 100_000, ""]


def put(folder: Path) -> str:
    done = run(folder, "tables", CAPTURE, "-o", "t")
    assert done.returncode == 0, done.stderr
    return done.stderr


@pytest.mark.thorough
@pytest.mark.attack("a damaged note of what is in the tables", "the capture is added again")
def test_damaged_notes(tmp_path: Path) -> None:
    added = put(tmp_path)
    for note in NOTES:
        for file in (tmp_path / "t/_captures").iterdir():
            file.write_text(note)
        assert put(tmp_path) == added, note


@pytest.mark.parametrize("name", ["telegrams", "_captures", "telegrams/tap=parameters"])
def test_a_file_in_the_place_of_a_folder(tmp_path: Path, name: str) -> None:
    place = tmp_path / "t" / name
    place.parent.mkdir(parents=True)
    place.touch()
    refused(run(tmp_path, "tables", CAPTURE, "-o", "t"), 1, f"t/{name}", "move that away, and run it again")
    place.unlink()
    put(tmp_path)
    assert not [*(tmp_path / "t").rglob(".sistap-*")]


def table(**columns: object) -> Callable[[Path], None]:
    return lambda path: pq.write_table(pa.table({name: [value] for name, value in columns.items()}), path)


TIME_NS = 1_700_000_000_000_000_005  # within the capture
STRANGE: dict[str, Callable[[Path], None]] = {
    "a text in place of a time": table(epoch_ns="a"),
    "a list in place of a time": table(epoch_ns=[1]),
    "a station too large": table(epoch_ns=TIME_NS, sender=1 << 40),
    "an object in place of a station": table(epoch_ns=TIME_NS, sender={"a": 1}),
    "an empty file": Path.touch,
    "a folder": Path.mkdir,
    "a link to nowhere": lambda path: path.symlink_to("nowhere"),
}
if hasattr(os, "mkfifo"):
    STRANGE["a pipe"] = os.mkfifo


@pytest.mark.attack("a foreign file among the tables: other columns, a pipe, a folder", "a line names it and the cure")
@pytest.mark.parametrize("kind", [pytest.param(kind, marks=pytest.mark.thorough) for kind in STRANGE])
def test_foreign_files(tmp_path: Path, kind: str) -> None:
    put(tmp_path)
    whole = CAPTURE.read_bytes()
    (size,) = struct.unpack_from("<I", whole, 4)
    (tmp_path / "copy.pcapng").write_bytes(whole + whole[:size])  # an empty section behind it, so it is another one
    [folder] = (tmp_path / "t/telegrams").glob("*/*")
    STRANGE[kind](folder / "strange.parquet")
    done = run(tmp_path, "tables", "copy.pcapng", "-o", "t")
    refused(done, 1, "/strange.parquet: ", "move what is none of the tables away")
    assert not [*(tmp_path / "t").rglob(".sistap-*")]
