# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report --since`: several files are one night, and only what happened from then on is told."""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import planted
import pytest

from sistap import cli
from sistap.dissected.captures import reading, since
from sistap.tap.files import pcapng
from sistap.tap.sis.faults import FAULTS

END = datetime(2026, 3, 14, 7, 30).astimezone()
HALVES_S = 150  # of the night, in two files


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("06:00", datetime(2026, 3, 14, 6)),
        ("7:30", datetime(2026, 3, 14, 7, 30)),
        ("22:00", datetime(2026, 3, 13, 22)),
        ("90m", datetime(2026, 3, 14, 6)),
        ("8h", datetime(2026, 3, 13, 23, 30)),
        ("1.5d", datetime(2026, 3, 12, 19, 30)),
        ("2026-03-01", datetime(2026, 3, 1)),
    ],
)
def test_the_time_is_counted_back_from_the_end(text: str, expected: datetime) -> None:
    assert since.parse(text)(END) == expected.astimezone()


def test_a_log_without_dates_is_of_1970_01_01() -> None:
    """Windows has no time before, and converts none of that day without a zone."""
    assert since.parse("1970-01-01T00:30")(END).replace(tzinfo=None) == datetime(1970, 1, 1, 0, 30)
    noon = datetime.fromtimestamp(12 * 3600, UTC).astimezone()
    assert since.parse(f"{noon + timedelta(hours=1):%H:%M}")(noon) < noon


@pytest.mark.parametrize("text", ["999999d", "738500d"])
def test_longer_than_there_are_years_is_all(text: str) -> None:
    assert since.parse(text)(END).timestamp() < 0


@pytest.mark.parametrize("text", ["", "8", "24:00", "6:0", "-8h", "8w", "yesterday", "99999999d"])
def test_what_is_no_time(text: str) -> None:
    with pytest.raises(ValueError, match="06:00 or a date"):
        since.parse(text)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a recorder: the ring, and a file of what it has kept."""
    folder = tmp_path_factory.mktemp("recorder")
    night = planted.play(folder / "night.pcapng")
    packets = list(reading.packets(night))
    heading = [pcapng.section_header("", ""), pcapng.interface_description(pcapng.Interface(252, "bus"))]
    for number, is_late in enumerate((False, True), 1):
        own = [one for one in packets if ((one.time_ns or 0) >= (planted.BEGIN_S + HALVES_S) * 1e9) == is_late]
        blocks = [pcapng.enhanced_packet(0, one.time_ns or 0, one.data) for one in own]
        (folder / f"ring_{number:05}_2026031421{number:04}.pcapng").write_bytes(b"".join([*heading, *blocks]))
    night.rename(folder / f"kept_20260314210000.000_{FAULTS[0].name}.pcapng")
    return folder


def told(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> dict[str, Any]:
    capsys.readouterr()
    assert cli.main(["report", "--format", "json", *map(str, arguments)]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def seconds(report: dict[str, Any]) -> list[float]:
    return [datetime.fromisoformat(one["from"]).timestamp() - planted.BEGIN_S for one in report["episodes"]]


def test_a_folder_is_its_ring(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """What was kept is not told twice, and the seam is not told at all."""
    report = told(capsys, folder)
    assert report["capture"].startswith("2 files, ring_00001_")
    assert len(report["episodes"]) == len(planted.PLANTED) + 1


def test_what_came_before_only_says_what_is_usual(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    """Who asks from the beginning on is no new master, and a silence that ends later is told."""
    whole, late = told(capsys, folder), told(capsys, "--since", "2026-03-14T21:01:50Z", folder)
    assert late["episodes"] == [
        one for one, second in zip(whole["episodes"], seconds(whole), strict=True) if second > 110
    ]
    assert late["began_epoch_s"] == pytest.approx(planted.BEGIN_S + 110, abs=1)
    assert late["duration_s"] == pytest.approx(whole["duration_s"] - 110, abs=1)
    assert all(window["start_s"] >= 0 and window["packets"] for window in late["windows"])


def test_what_begins_before_and_ends_later_is_told(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    def lasts_s(one: dict[str, Any]) -> float:
        return (datetime.fromisoformat(one["to"]) - datetime.fromisoformat(one["from"])).total_seconds()

    long = max((one for one in told(capsys, folder)["episodes"] if one["kind"] == "silent"), key=lasts_s)
    began = datetime.fromisoformat(long["from"])
    middle = began + timedelta(seconds=lasts_s(long) / 2)
    late = told(capsys, "--since", f"{middle:%Y-%m-%dT%H:%M:%SZ}", folder)
    assert ("silent", long["from"]) in [(one["kind"], one["from"]) for one in late["episodes"]]


def test_files_that_end_before_are_not_read(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    report = told(capsys, "--since", "2026-03-14T21:05:00Z", folder)
    assert report["capture"].startswith("ring_00002_")
    assert min(seconds(report)) > 259


def test_a_filter_of_several_files_finds_the_time(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    capsys.readouterr()
    assert cli.main(["report", "--format", "text", str(folder)]) == 0
    text = capsys.readouterr().out
    assert "frame.number" not in text.partition("What was captured")[0]
    assert "frame.time_epoch >= " in text
    answer = text.partition("\n\n")[0].splitlines()
    assert answer[0].startswith("NOT OK") and max(map(len, answer)) <= 72
