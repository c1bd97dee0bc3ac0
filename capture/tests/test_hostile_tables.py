# SPDX-License-Identifier: GPL-2.0-or-later
"""A folder of tables that others, a kill or a full disk have left their marks in."""

from __future__ import annotations

from pathlib import Path

import pytest
from commands import refused, run

pytest.importorskip("pyarrow", reason="pyarrow writes the tables: pip install pyarrow")

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
