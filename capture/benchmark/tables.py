#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""What the five queries of `sistap tables` cost on one computer with DuckDB, and how the cost grows with the telegrams.

A day of a bus is put into tables with `sistap tables`, and then copied to other days and other taps. Each query has a
process of its own.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from datetime import timedelta
from pathlib import Path
from typing import NamedTuple

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

PACKAGE = Path(__file__).parent.parent / "sistap"
README = PACKAGE / "commands/tables/README.md"
QUESTIONS = dict(re.findall(r"### (.+?)\n.*?```sql\n(.*?)```", README.read_text("utf-8"), re.DOTALL))
NAMES = ("telegrams", "values", "events")
DAY_S = 86_400
DAYS = 100  # for each tap; then the next tap follows

# Three drives that are read all day, one of them with occasional errors; a limit is written now and then.
SCENARIO = """\
title = "a day"
[line]
baud = 115200
trs_ms = 50
[[station]]
address = 3
[[station]]
address = 4
[[station]]
address = 5
[[master]]
address = 16
script = [
    { set = "TrS", ms = 50, station = 3 },
    { set = "accept", station = 255, device = 0 },
    { read = "S-0-0051", element = "attribute", station = 3 },
    { read = "S-0-0051", element = "attribute", station = 4 },
    { read = "S-0-0051", element = "attribute", station = 5 },
    { loop = [
        { repeat = [
            { read = "S-0-0051", station = 3 },
            { read = "S-0-0051", station = 4 },
            { read = "S-0-0051", station = 5 },
            { read = "S-0-0040", station = 3 },
        ], times = 500 },
        { write = "S-0-0091", value = 100, station = 4 },
        { write = "S-0-0091", value = 200, station = 4 },
    ] },
]
[[fault]]
kind = "silent"
station = 5
probability = 0.0005
[[fault]]
kind = "checksum"
station = 4
probability = 0.0002
"""


class Used(NamedTuple):
    """The resources that a process has used."""

    seconds: float  # of the clock
    cores: float  # seconds of all cores
    megabytes: float  # at most

    def __str__(self) -> str:
        """Write it as in the table."""
        return f"{self.seconds:.1f} s, {self.cores:.1f} s of cores, {self.megabytes:.0f} MB"


def main() -> int:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", metavar="N", type=float, nargs="*", help="telegrams, such as 1e6 (default: 1e5, 1e6)")
    parser.add_argument("--capture", type=Path, help="a day of your own (default: one that the virtual bus plays)")
    parser.add_argument("--spark", action="store_true", help="ask Spark, too (local, on all cores)")
    parser.add_argument("--folder", type=Path, help="where the tables are made (default: where TMPDIR says)")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.folder) as name:
        folder = Path(name)
        day = _day(folder, args.capture)
        results = {}
        for size in sorted(map(int, args.sizes or (1e5, 1e6))):
            made = _multiply(day, folder / "many", size)
            print(f"{made:.3g} telegrams: {_megabytes(folder / 'many'):.0f} MB in Parquet files", flush=True)
            for asking in ("duckdb", *(["spark"] if args.spark else [])):
                for question in QUESTIONS:
                    used = _ask(asking, folder / "many", question)
                    results[asking, question, made] = used
                    print(f"  {asking}: {question} {used}", flush=True)
    _print(results)
    return 0


def _day(folder: Path, capture: Path | None) -> Path:
    """Make the tables of one day."""
    if not capture:
        capture = folder / "day.pcapng"
        (folder / "day.toml").write_text(SCENARIO, "utf-8")
        _sistap("bus", folder / "day.toml", "--duration", "1600", "--seed", "1", "-w", capture)
    before = os.times()
    _sistap("tables", "--tap", "day", capture, "-o", folder / "day")
    after = os.times()
    seconds = sum(after[2:4]) - sum(before[2:4])
    count = sum(pq.read_metadata(file).num_rows for file in (folder / "day" / "telegrams").rglob("*.parquet"))
    print(f"a day has {count} telegrams; making its tables: {count / seconds:.0f} of them in a second of a core")
    return folder / "day"


def _sistap(*arguments: str | Path) -> None:
    environment = os.environ | {"PYTHONPATH": str(PACKAGE.parent)}
    subprocess.run([sys.executable, "-m", "sistap", *map(str, arguments)], check=True, env=environment)


def _multiply(day: Path, many: Path, size: int) -> int:
    """Copy the day until there are enough telegrams; return how many there are. Existing files stay."""
    tables = {name: pq.ParquetDataset(day / name).read() if (day / name).exists() else None for name in NAMES}
    telegrams = tables["telegrams"]
    assert telegrams is not None
    copies = max(round(size / len(telegrams)), 1)
    for number in range(copies):
        tap, later = number // DAYS, number % DAYS
        for name, table in tables.items():
            if table is not None:
                _copy(table, many / name / f"tap=press-{tap}", later)
    return copies * len(telegrams)


def _copy(table: pa.Table, tap: Path, later: int) -> None:
    first = pc.min(table["time"]).as_py()
    folder = tap / f"day={first.date() + timedelta(days=later)}"
    if folder.exists():
        return
    folder.mkdir(parents=True)
    table = table.drop_columns([name for name in ("tap", "day") if name in table.schema.names])
    for name, unit in (("epoch_ns", 10**9), ("time", 10**6)):
        column = table[name]
        moved = pc.add(column.cast(pa.int64()), later * DAY_S * unit).cast(column.type)
        table = table.set_column(table.schema.get_field_index(name), name, moved)
    if "reaction_s" in table.schema.names:  # make the days different
        factor = pc.add(pc.multiply(pc.random(len(table), initializer=later), 0.2), 0.9)
        place = table.schema.get_field_index("reaction_s")
        table = table.set_column(place, "reaction_s", pc.multiply(table["reaction_s"], factor))
    pq.write_table(table, folder / "day.parquet", compression="zstd")


def _megabytes(folder: Path) -> float:
    return sum(file.stat().st_size for file in folder.rglob("*.parquet")) / 1e6


def _ask(asking: str, tables: Path, question: str) -> Used:
    """Query in a process of its own; with Spark, also in its Java process."""
    began = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, __file__, "--ask", asking, str(tables), question], stdout=subprocess.PIPE
    )
    assert process.stdout
    said = process.stdout.read().split()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{asking} cannot answer: {question}")
    cores, megabytes = map(float, said[-2:]) if said else (0.0, usage.ru_maxrss / 1024)
    return Used(time.monotonic() - began, cores or usage.ru_utime + usage.ru_stime, megabytes)


def _answer(asking: str, tables: Path, question: str) -> None:
    {"duckdb": _answer_with_duckdb, "spark": _answer_with_spark}[asking](tables, QUESTIONS[question])


def _answer_with_duckdb(tables: Path, question: str) -> None:
    import duckdb  # noqa: PLC0415 - in the process that runs the query

    duckdb.sql("SET TimeZone = 'UTC'")
    for name in NAMES:
        files = f"{tables}/{name}/*/*/*.parquet"
        duckdb.sql(f"CREATE VIEW all_{name} AS FROM read_parquet('{files}', hive_partitioning = true)")
    duckdb.sql(f"CREATE TABLE answer AS {question}")


def _answer_with_spark(tables: Path, question: str) -> None:
    from pyspark.sql import SparkSession  # noqa: PLC0415

    builder = SparkSession.builder.master("local[*]").config("spark.ui.enabled", "false")
    builder = builder.config("spark.ui.showConsoleProgress", "false")
    builder = builder.config("spark.driver.memory", "8g").config("spark.driver.host", "127.0.0.1")
    spark = builder.config("spark.sql.session.timeZone", "UTC").getOrCreate()
    for name in NAMES:
        spark.read.parquet(str(tables / name)).createOrReplaceTempView(f"all_{name}")
    spark.sql(question).toArrow()
    assert spark._jvm
    java = int(spark._jvm.java.lang.ProcessHandle.current().pid())
    [peak] = re.findall(r"VmHWM:\s+(\d+)", Path(f"/proc/{java}/status").read_text())
    ticks = Path(f"/proc/{java}/stat").read_text().rpartition(")")[2].split()[11:13]
    print(sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK"), int(peak) / 1024)


def _print(results: dict[tuple[str, str, int], Used]) -> None:
    """Print the table of the README."""
    sizes = sorted({size for _, _, size in results})
    print("| question |", " | ".join(f"{size:.3g}" for size in sizes), "| growth |")
    print("|---|" + "---|" * (len(sizes) + 1))
    for asking, question in dict.fromkeys((asking, question) for asking, question, _ in results):
        row = [results[asking, question, size] for size in sizes]
        cells = " | ".join(map(str, row))
        growth = f"{row[-1].cores / row[-2].cores:.1f}" if len(row) > 1 else ""
        print(f"| {asking}: {question} | {cells} | {growth} |")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--ask"]:
        _answer(sys.argv[2], Path(sys.argv[3]), sys.argv[4])
    else:
        sys.exit(main())
