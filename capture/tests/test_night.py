# SPDX-License-Identifier: GPL-2.0-or-later
"""What happened last night: a scenario of eight hours, and every tool that has to find it.

At 03:12 master 17 writes 200 rpm where 2000 rpm were meant. From then on drive 4 answers 24 ms later. At 03:40 and
04:35 it does not answer.
"""

from __future__ import annotations

import csv
import io
import json
import signal
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import pytest

from sistap import cli
from sistap.dissected.captures import reading
from sistap.tap.files.output import Limits, Output
from sistap.tap.files.pcapng import Interface
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.records.counters import Counters
from sistap.tap.records.record import Record, Type
from sistap.tap.sis import telegram

LINE = {0: Interface(252, "a line of a test")}
BEGIN = datetime(2026, 3, 14, 21, tzinfo=UTC)
WRITE = datetime(2026, 3, 15, 3, 12, tzinfo=UTC)
END = datetime(2026, 3, 15, 5, tzinfo=UTC)
PATIENCE_S = 240


@pytest.fixture(scope="module")
def night(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("night") / "night.pcapng"
    assert cli.main(["bus", "night", "-w", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def ring(night: Path, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """The same night in several files, as a ring has them. The command gets them in the wrong order."""
    folder = tmp_path_factory.mktemp("ring")
    output = Output(str(folder / "night.pcapng"), Limits(size=night.stat().st_size // 5, several=True))
    first, *rest = reading.records(night)
    writer = PcapngWriter(output, LINE, Counters())
    writer.begin(first)
    for record in rest:
        writer.write(record)
    output.close()
    files = sorted(map(str, folder.iterdir()), reverse=True)
    assert len(files) > 4
    return files


def written(records: Sequence[Record]) -> int:
    """Return the number of the packet that writes S-0-0091, counted from 1."""
    (number,) = (
        number
        for number, record in enumerate(records, 1)
        if record.is_good_frame
        and (header := telegram.parse(record.data)).service == 0x1F
        and not header.reaction
        and header.body[2:5] == b"\x00\x5b\x00"
    )
    return number


def seconds(record: Record) -> float:
    return record.time_ns / 1e9


@pytest.mark.thorough
def test_a_scenario_can_say_when_it_begins(night: Path) -> None:
    records = list(reading.records(night))
    assert seconds(records[0]) == BEGIN.timestamp()
    assert WRITE.timestamp() < seconds(records[written(records) - 1]) < WRITE.timestamp() + 1
    assert END.timestamp() - 60 <= seconds(records[-1]) < END.timestamp() + 1


@pytest.mark.thorough
def test_the_list_of_changes_names_the_write(night: Path, capsys: pytest.CaptureFixture[str]) -> None:
    number = written(list(reading.records(night)))
    capsys.readouterr()
    assert cli.main(["parameters", "--changes", str(night)]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith("2026-03-15 03:12:00.")
    assert "17 -> 4 " in line and "S-0-0091" in line and "2000.0000 rpm -> 200.0000 rpm" in line
    assert line.endswith(f"packet {number + 1}")  # the reaction: it was accepted


def test_the_comparison_begins_with_what_happened(
    night: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    records = list(reading.records(night))
    after = written(records)
    evening = [record for record in records if seconds(record) < BEGIN.timestamp() + 3 * 3600]
    for name, part in (("evening.pcapng", evening), ("after.pcapng", records[after - 1 :])):
        output = Output(str(tmp_path / name))
        writer = PcapngWriter(output, LINE, Counters())
        writer.begin(part[0])
        for record in part[1:]:
            writer.write(record)
        output.close()
    capsys.readouterr()
    assert cli.main(["compare", str(tmp_path / "evening.pcapng"), str(tmp_path / "after.pcapng")]) == 0
    first = capsys.readouterr().out.split("\n\n")[1].splitlines()
    subjects = [line[:7].strip() for line in first]
    assert subjects == ["Bus", "Silent", "Drives", "Changed", "", "Limits", "Times"]
    assert "Write, station 4 S-0-0091: 2000.0000 rpm -> " in first[3]
    assert "by new master 17; still set at the end, 03:12:00" in first[3]
    assert "New master: master 17 asked stations 4, 16: 3 commands, 1 value read, 1 written" in first[4]
    assert "Sent again, station 4: a command without a reaction (2 times)" in first[5]
    assert "station 4 answers" in first[6] and "slower" in first[6]


@pytest.mark.thorough
def test_the_report_has_the_least_and_the_greatest(night: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["report", "--format", "json", str(night)]) == 0
    parameters = json.loads(capsys.readouterr().out)["parameters"]
    (limit,) = (one for one in parameters if one["ident"] == "S-0-0091" and one["writes"])
    assert (limit["first"], limit["last"], limit["written_by"]) == ("2000.0000 rpm", "200.0000 rpm", 17)


def output(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    capsys.readouterr()
    assert cli.main(list(arguments)) == 0
    return capsys.readouterr().out


def test_a_ring_has_the_parameters_of_the_whole(
    night: Path, ring: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    whole, cut = (
        list(csv.DictReader(io.StringIO(output(capsys, "parameters", "--csv", *files))))
        for files in ([str(night)], ring)
    )
    for one, other in zip(whole, cut, strict=True):
        for row in (one, other):
            row.update(port="", written_in_packet="", written_in_file="")
        assert one == other
    assert any(row["name"] and row["least"] for row in whole)


@pytest.mark.thorough
def test_a_ring_has_the_report_of_the_whole(night: Path, ring: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """All figures; only the numbers of the packets count the events with which each file begins."""
    whole, cut = (json.loads(output(capsys, "report", "--format", "json", *files)) for files in ([str(night)], ring))
    for report in (whole, cut):
        for name in ("capture", "ports", "windows"):
            del report[name]
        del report["silences"]["longest_before_packet"]
        for row in (*report["episodes"], *report["parameters"], *report["events"]):
            for name in ("packet", "packets", "port", "written_in"):
                row.pop(name, None)
    assert cut == whole
    assert whole["faults"]["unanswered"] and whole["limits"]["trs"]["ok"]


# Columns that say where a row comes from, or that duckdb cannot give without a calendar of all zones.
NOT_COMPARED = {
    "telegrams": "time, port, file, packet, command_packet",
    "values": "time, port, file, packet",
    "events": "time, port, file, packet",
    "episodes": "time, port, file, packet, until",
}


@pytest.mark.thorough
def test_a_ring_has_the_tables_of_the_whole(night: Path, ring: list[str], tmp_path: Path) -> None:
    """Also a ring that had fewer files an hour ago. Beside another capture of the night, it tells nothing less."""
    duckdb = pytest.importorskip("duckdb", reason="duckdb asks the tables: pip install duckdb")
    pytest.importorskip("pyarrow", reason="pyarrow writes the tables: pip install pyarrow")
    calls = [("whole", [str(night)]), ("ring", ring[3:]), ("ring", ring), ("both", [*ring[:2], str(night)])]
    for folder, files in calls:
        assert cli.main(["tables", "--tap", "x", *files, "-o", str(tmp_path / folder)]) == 0
    for table, columns in NOT_COMPARED.items():
        whole, cut, both = (
            f"SELECT * EXCLUDE ({columns}) FROM read_parquet('{tmp_path}/{folder}/{table}/*/*/*.parquet')"
            for folder in ("whole", "ring", "both")
        )
        assert duckdb.sql(whole).fetchall()
        for one, other in ((whole, cut), (cut, whole), (whole, both)):
            assert duckdb.sql(f"({one}) EXCEPT ALL ({other})").fetchall() == []
    [(file, packet)] = duckdb.sql(
        f"""SELECT file, packet FROM read_parquet('{tmp_path}/ring/episodes/*/*/*.parquet')
        WHERE kind = 'write' AND parameter = 'S-0-0091'"""
    ).fetchall()
    assert packet == written(list(reading.records(Path(ring[0]).with_name(file)))) + 1  # its reaction


@pytest.mark.thorough
def test_duckdb_finds_the_minutes(night: Path, tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb", reason="duckdb asks the tables: pip install duckdb")
    pytest.importorskip("pyarrow", reason="pyarrow writes the tables: pip install pyarrow")
    assert cli.main(["tables", str(night), "-o", str(tmp_path / "t")]) == 0
    found = duckdb.sql(
        f"""SELECT DISTINCT strftime(timezone('UTC', time), '%H:%M')
        FROM read_parquet('{tmp_path}/t/telegrams/*/*/*.parquet') WHERE is_unanswered ORDER BY 1"""
    ).fetchall()
    assert found == [("03:40",), ("04:35",)]


@pytest.mark.thorough
@pytest.mark.timeout(PATIENCE_S)
def test_the_recorder_keeps_three_files(tmp_path: Path) -> None:
    """From end to end. Who stops it before the bus ends has no fourth file, which says so."""
    command = [sys.executable, "-m", "sistap"]
    address = f"{tmp_path}/bus"
    bus = subprocess.Popen(
        [*command, "bus", "night", "--listen", address, "--fast"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    assert bus.stdout and bus.stdout.readline()
    keep = ["--keep", "writes", "--keep", "faults", "-w", "kept", "-c", "4700", "-q"]
    done = subprocess.run(
        [*command, "record", "-i", f"bus://{address}", *keep],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    bus.send_signal(signal.SIGTERM)
    bus.communicate()
    assert done.returncode == 0, done.stderr
    files = sorted((tmp_path / "kept").iterdir())
    reasons = [path.stem.split("_", 2)[2] for path in files]
    assert reasons == ["master_write", "repeated", "repeated"]
    assert "3 files kept" in done.stderr
    begun, *rest = reading.records(files[0])
    told, kept = ([one for one in rest if (one.type == Type.BEFORE) == is_before] for is_before in (True, False))
    assert WRITE.timestamp() - 60 < seconds(begun) < WRITE.timestamp() + 1  # not the time of this machine
    assert any(b"\x01\x32\x00" in one.data for one in told)  # all: TrS 50 ms
    assert WRITE.timestamp() - 60 < seconds(kept[-1]) < WRITE.timestamp() + 60
