# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap tables` of two days whose every telegram is listed here, and the results of DuckDB and Spark."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
import report_capture
from commands import refused, run, run_anew
from report_capture import Sent, write

from sistap import cli
from sistap.commands.tables.rows import FIELDS, Rows
from sistap.dissected.captures.portions import Portion
from sistap.dissected.packets.dissection import Dissection
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.line.settings import Flag
from sistap.tap.sis.telegram import build

duckdb = pytest.importorskip("duckdb", reason="duckdb asks the tables: pip install duckdb")
pytest.importorskip("pyarrow", reason="pyarrow writes the tables: pip install pyarrow")

HOUSE = Path(__file__).parent.parent.parent
CAPTURES = HOUSE / "test-captures"
README = HOUSE / "capture" / "sistap/commands/tables/README.md"
QUESTIONS = dict(re.findall(r"### (.+?)\n.*?```sql\n(.*?)```", README.read_text("utf-8"), re.DOTALL))
DAY_S = 86_400
BEFORE_MIDNIGHT_S = 6398  # after the first capture: 2 s
NAMES = ("telegrams", "values", "events", "episodes")
SLOWER, HAPPENED, MINUTE, CHANGED, LINE, RANGE = QUESTIONS


def command(service: int, data: str, master: int = 16) -> Sent:
    return Sent(build(service, master, 3, bytes.fromhex(data)))


def reaction(service: int, data: str, master: int = 16, **more: Any) -> Sent:
    return Sent(build(service, master, 3, bytes.fromhex(data), reaction=True), **more)


# P-0-0012 of device 5: 2 bytes, signed, 2 decimal places; in Nm.
KNOWN = [
    command(0x10, "1C 05 00 0C 80"),
    reaction(0x10, "00 1C 05 01 00 21 02"),
    command(0x10, "24 05 00 0C 80"),
    reaction(0x10, "00 24 05 4E 6D"),
]
READ = "3C 05 00 0C 80"
DAY_1 = [
    *KNOWN,
    command(0x10, READ),  # 6: packet 1 is an event
    reaction(0x10, "00 3C 05 F4 01"),  # 5.00
    command(0x1F, READ + "EE 02"),  # 8: 7.50
    reaction(0x1F, "00 3C 05"),
]
DAMAGED = bytearray(build(0x10, 16, 3, bytes.fromhex("00 3C 05 F4 01"), reaction=True))
DAMAGED[-1] ^= 1
DAY_2 = [
    *KNOWN,
    command(0x10, READ),  # 6
    reaction(0x10, "00 3C 05 84 03", silence_ms=80.0),  # 9.00
    command(0x10, READ),  # 8: nobody answers
    Sent(build(0x10, 16, 3, bytes.fromhex(READ)), silence_ms=500.0, flags={3: Flag.CHARACTER_ERROR}),
    Sent(bytes(DAMAGED)),  # 10. Its command is not known to be unanswered: its master says no more
    command(0x1F, READ + "D4 FE", 17),  # 11: -3.00
    reaction(0x1F, "00 3C 05", 17),
]
FIRST = datetime.fromtimestamp(report_capture.START_NS // 10**9, UTC)  # 2023-11-14 22:13:20


def write_at(path: Path, sent: Iterable[Sent], later_s: int) -> Path:
    """Write a capture that begins that much later."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_capture, "START_NS", report_capture.START_NS + later_s * 10**9)
        return write(path, sent)


@pytest.fixture(scope="module")
def days(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("days")
    return [write_at(folder / "one.pcapng", DAY_1, 0), write_at(folder / "two.pcapng", DAY_2, DAY_S)]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory, days: list[Path]) -> Path:
    """Both days of the tap `press`, and the first of them as that of another tap."""
    folder = tmp_path_factory.mktemp("made")
    for tap, captures in (("press", days), ("lathe 2", days[:1])):
        done = run(folder, "tables", "--tap", tap, *captures, "-o", "tables")
        assert done.returncode == 0, done.stderr
    return folder / "tables"


def connected(tables: Path) -> Any:
    connection = duckdb.connect()
    for name in NAMES:
        connection.sql(
            f"CREATE VIEW all_{name} AS FROM "
            f"read_parquet('{tables}/{name}/*/*/*.parquet', hive_partitioning = true)"
        )
    connection.sql("SET TimeZone = 'UTC'")
    return connection


def asked(tables: Path, question: str) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = connected(tables).sql(question).to_arrow_table().to_pylist()
    return rows


def count(tables: Path) -> list[int]:
    return [
        asked(tables, f"SELECT count(*) AS n FROM all_{name}")[0]["n"] for name in ("telegrams", "values", "events")
    ]


def test_the_columns(made: Path) -> None:
    rows = asked(made, "SELECT * FROM all_telegrams WHERE tap = 'press' ORDER BY epoch_ns")
    assert len(rows) == len(DAY_1) + len(DAY_2)
    late = rows[len(DAY_1) + 5]
    start_ns = report_capture.START_NS + DAY_S * 10**9
    assert late["epoch_ns"] == report_capture.records(DAY_2)[6].time_ns - report_capture.START_NS + start_ns
    assert late["time"] == datetime.fromtimestamp(late["epoch_ns"] // 1000 / 1e6, UTC)
    expected = {"file": "two.pcapng", "packet": 7, "port": "test port", "line": 0, "day": date(2023, 11, 15)}
    expected |= {"sender": 3, "receiver": 16, "is_reaction": True, "service": 0x10, "service_name": "Read parameter"}
    expected |= {"parameter": "P-0-0012", "value": "9.00 Nm", "number": 9.0, "status": 0, "error": None}
    expected |= {"is_good": True, "is_repeat": False, "is_unanswered": False, "command_packet": 6, "baud": 9600}
    expected |= {"trs_limit_s": None, "trs_verdict": None, "uncertainty_s": pytest.approx(0.00031)}
    expected |= {"reaction_s": pytest.approx(0.080), "has_character_error": False, "has_loss": False}
    assert {name: late[name] for name in expected} == expected
    sent = [one.data for one in (*DAY_1, *DAY_2)]
    assert [row["raw"] for row in rows] == sent, "the damaged one, too"
    assert [row["packet"] for row in rows if row["has_character_error"]] == [9]
    assert [row["packet"] for row in rows if not row["is_good"]] == [10]


def test_rows_of_alike_packets_are_as_if_each_were_alone(tshark: Tshark, tmp_path: Path) -> None:
    """All captures, each a section of one. The rows of a table have their columns in the same order."""
    every = tmp_path / "every.pcapng"
    every.write_bytes(b"".join(path.read_bytes() for path in sorted(CAPTURES.glob("*.pcapng"))))
    together = Rows("x")
    orders: dict[str, list[str]] = {}
    with Dissection(tshark, [Portion(every)], FIELDS) as dissection:
        for packet in dissection.packets():
            rows = list(together.of(packet))
            assert rows == list(Rows("x").of(packet))
            assert all(list(row.values) == orders.setdefault(row.table, list(row.values)) for row in rows)
    assert sorted(orders) == ["events", "telegrams", "values"]


def test_of_a_telegram_in_one_read_no_interval_is_known(tshark: Tshark, tmp_path: Path) -> None:
    one_read = {place: Flag.SAME_READ for place in range(2, len(KNOWN[0].data) + 1)}
    path = write(tmp_path / "x.pcapng", [KNOWN[0]._replace(flags=one_read), KNOWN[0]])
    with Dissection(tshark, [Portion(path)], FIELDS) as dissection:
        rows = [row for packet in dissection.packets() for row in Rows("x").of(packet)]
    longest_s = [row.values["longest_interval_s"] for row in rows if row.table == "telegrams"]
    assert longest_s == [None, pytest.approx(11 / 9600, abs=1e-6)]


def test_values_and_events(made: Path) -> None:
    rows = asked(made, "SELECT * FROM all_values WHERE tap = 'press' ORDER BY epoch_ns")
    columns = (
        "packet",
        "is_write",
        "master",
        "number",
        "value",
        "station",
        "route",
        "device",
        "parameter",
        "unit",
        "error",
    )
    assert [tuple(row[name] for name in columns) for row in rows] == [
        (packet, is_write, master, number, f"{number:.2f} Nm", 3, "3", 5, "P-0-0012", "Nm", None)
        for packet, is_write, master, number in (
            (7, False, 16, 5.0),
            (9, True, 16, 7.5),
            (7, False, 16, 9.0),
            (12, True, 17, -3.0),
        )
    ]
    events = asked(made, "SELECT * FROM all_events ORDER BY tap, epoch_ns")
    assert [(row["tap"], row["event"], row["text"]) for row in events] == [
        (tap, "capture_started", report_capture.STARTED) for tap in ("lathe_2", "press", "press")
    ]


def test_a_station_is_a_number_and_a_phase_is_a_column(tmp_path: Path, made: Path) -> None:
    """Drive 3 is asked for its phase, and answers 4."""
    asks = write(tmp_path / "phase.pcapng", [command(0x12, ""), reaction(0x12, "00 04")])
    assert run(tmp_path, "tables", asks, "-o", "tables").returncode == 0
    pattern = f"{tmp_path}/tables/telegrams/*/*/*.parquet"
    assert duckdb.sql(f"SELECT phase FROM '{pattern}' ORDER BY packet").fetchall() == [(None,), (4,)]
    types = {
        asked(made, f"SELECT typeof({name}) AS kind FROM all_{table} LIMIT 1")[0]["kind"]
        for table, name in (("telegrams", "sender"), ("values", "station"), ("episodes", "station"))
    }
    assert types == {"SMALLINT"}


# By hand. Of 4 reactions, 25, 25, 25 and 80 ms, 99 % are 0.97 of the way from the third to the fourth.
DAYS = [{"day": date(2023, 11, 14)}, {"day": date(2023, 11, 15)}]
PRESS: dict[str, Any] = {"tap": "press", "station": 3, "half_within_s": pytest.approx(0.025)}
PARAMETER = {"tap": "press", "station": 3, "route": "3", "device": 5, "parameter": "P-0-0012"}
ANSWERS: dict[str, list[dict[str, Any]]] = {
    SLOWER: [
        {**PRESS, **DAYS[0], "tap": "lathe_2", "reactions": 4, "nearly_all_within_s": pytest.approx(0.025)},
        {**PRESS, **DAYS[0], "reactions": 4, "nearly_all_within_s": pytest.approx(0.025)},
        {**PRESS, **DAYS[1], "reactions": 4, "nearly_all_within_s": pytest.approx(0.025 + 0.97 * 0.055)},
    ],
    HAPPENED: [
        {"tap": "press", "severity": "warning", "text": text}
        for text in ("Nothing was captured: 86400 s between two captures",)  # single damaged telegrams are notes
    ],
    MINUTE: [
        {"tap": "press", "began": FIRST.replace(second=0) + timedelta(days=1)}
        | {"faults": 2, "unanswered": 1, "damaged": 1, "late": 0}
    ],
    CHANGED: [
        {**PARAMETER, "tap": "lathe_2", "master": 16, "was": "5.00 Nm", "value": "7.50 Nm", "packet": 9},
        {**PARAMETER, "master": 16, "was": "5.00 Nm", "value": "7.50 Nm", "packet": 9, "file": "one.pcapng"},
        {**PARAMETER, "master": 17, "was": "9.00 Nm", "value": "-3.00 Nm", "packet": 12, "file": "two.pcapng"},
    ],
    LINE: [
        {"tap": "press", **DAYS[1], "telegrams": 11}
        | {f"{what}_per_million": pytest.approx(1e6 / 11) for what in ("damaged", "line_errors", "unanswered")},
        *(
            {"tap": tap, **DAYS[0], "telegrams": 8}
            | {f"{what}_per_million": 0 for what in ("damaged", "line_errors", "unanswered")}
            for tap in ("lathe_2", "press")
        ),
    ],
    RANGE: [
        {**PARAMETER, **DAYS[1], "unit": "Nm", "least": -3.0, "greatest": 9.0}
        | {"least_before": 5.0, "greatest_before": 7.5}
    ],
}


def check(rows: list[dict[str, Any]], answer: list[dict[str, Any]]) -> None:
    assert len(rows) == len(answer)
    assert [{name: row[name] for name in wanted} for row, wanted in zip(rows, answer, strict=True)] == answer


@pytest.mark.parametrize("question", QUESTIONS)
def test_the_questions(made: Path, question: str) -> None:
    check(asked(made, QUESTIONS[question]), ANSWERS[question])


@pytest.fixture(scope="module")
def spark(made: Path) -> Iterator[Any]:
    pyspark = pytest.importorskip("pyspark.sql", reason="Spark is not here: pip install pyspark")
    if not shutil.which("java"):
        pytest.skip("Spark needs Java: apt-get install default-jre-headless")
    builder = pyspark.SparkSession.builder.master("local[2]").config("spark.ui.enabled", "false")
    builder = builder.config("spark.sql.session.timeZone", "UTC").config("spark.sql.shuffle.partitions", "2")
    session = (
        builder.config("spark.driver.bindAddress", "127.0.0.1").config("spark.driver.host", "127.0.0.1").getOrCreate()
    )
    for name in NAMES:
        session.read.parquet(str(made / name)).createOrReplaceTempView(f"all_{name}")
    yield session
    session.stop()


@pytest.mark.thorough
@pytest.mark.timeout(900)  # until Spark has started
@pytest.mark.parametrize("question", QUESTIONS)
def test_spark_gives_the_same_answers(made: Path, spark: Any, question: str) -> None:
    answer = spark.sql(QUESTIONS[question]).toArrow().to_pylist()
    check(answer, ANSWERS[question])
    ours = asked(made, QUESTIONS[question])
    assert [row.keys() for row in answer] == [row.keys() for row in ours]
    for row, other in zip(answer, ours, strict=True):
        assert row == {
            name: pytest.approx(value) if isinstance(value, float) else value for name, value in other.items()
        }


@pytest.mark.thorough
def test_run_again_it_adds_nothing(tmp_path: Path, days: list[Path]) -> None:
    first = run(tmp_path, "tables", *days, "-o", "t")
    before = count(tmp_path / "t"), sorted((tmp_path / "t").rglob("*"))
    again = run(tmp_path, "tables", *days, "-o", "t")
    assert (first.returncode, again.returncode) == (0, 0)
    assert again.stderr == "".join(f"sistap: {day}: is in the tables\n" for day in days)
    assert (count(tmp_path / "t"), sorted((tmp_path / "t").rglob("*"))) == before
    assert before[0] == [len(DAY_1) + len(DAY_2), 4, 2]


@pytest.mark.thorough
def test_a_capture_that_has_grown_brings_what_is_new(tmp_path: Path) -> None:
    for sent in (DAY_2[:8], DAY_2):
        write(tmp_path / "growing.pcapng", sent)
        assert run(tmp_path, "tables", "growing.pcapng", "-o", "t").returncode == 0
    assert count(tmp_path / "t") == [len(DAY_2), 2, 1]
    assert len(list((tmp_path / "t" / "telegrams").rglob("*.parquet"))) == 1


@pytest.mark.thorough
def test_a_capture_that_is_another_now_replaces_what_it_had(tmp_path: Path) -> None:
    """Two days that become one, of the same name and beginning."""
    for sent in ([*DAY_1, command(0x10, READ)._replace(silence_ms=4000.0)], DAY_1):
        write_at(tmp_path / "again.pcapng", sent, BEFORE_MIDNIGHT_S)
        assert run(tmp_path, "tables", "again.pcapng", "-o", "t").returncode == 0
    assert count(tmp_path / "t") == [len(DAY_1), 2, 1]


@pytest.mark.thorough
def test_a_telegram_in_two_captures_is_one(tmp_path: Path, days: list[Path]) -> None:
    """A copy of another name, and a capture that has the beginning of it."""
    write_at(tmp_path / "beginning.pcapng", DAY_2[:8], DAY_S)
    shutil.copy(days[1], tmp_path / "copy.pcapng")
    with (tmp_path / "copy.pcapng").open("ab") as file:  # so its bytes are others: an empty section behind it
        file.write(write(tmp_path / "empty.pcapng", [], dissector="sis").read_bytes())
    for name in ("beginning.pcapng", days[1], "copy.pcapng"):
        assert run(tmp_path, "tables", name, "-o", "t").returncode == 0
    assert count(tmp_path / "t") == [len(DAY_2), 2, 1]


@pytest.mark.thorough
def test_what_was_removed_is_made_again(tmp_path: Path, days: list[Path]) -> None:
    run(tmp_path, "tables", *days, "-o", "t")
    shutil.rmtree(tmp_path / "t" / "telegrams" / "tap=test_port" / "day=2023-11-14")
    run(tmp_path, "tables", *days, "-o", "t")
    assert count(tmp_path / "t") == [len(DAY_1) + len(DAY_2), 4, 2]


@pytest.mark.thorough
def test_with_the_script(tmp_path: Path, days: list[Path], made: Path) -> None:
    (tmp_path / "plugins").mkdir()
    shutil.copy(HOUSE / "lua-fallback" / "sis.lua", tmp_path / "plugins")
    done = run(tmp_path, "tables", "--tap", "press", *days, "-o", "t", WIRESHARK_PLUGIN_DIR=str(tmp_path / "plugins"))
    assert done.returncode == 0, done.stderr
    question = "SELECT * FROM all_{} WHERE tap = 'press' ORDER BY epoch_ns, place"
    for name in NAMES:
        assert asked(tmp_path / "t", question.format(name)) == asked(made, question.format(name))


def test_what_cannot_be_put(tmp_path: Path, days: list[Path]) -> None:
    (tmp_path / "junk").write_text("this is no capture\n" * 9)
    refused(run(tmp_path, "tables", "junk", "-o", "t"), 2, "junk is not a capture")
    refused(run(tmp_path, "tables", "none", "-o", "t"), 2, "cannot read none")
    refused(run(tmp_path, "tables", ".", "-o", "t"), 2, ". has no captures")
    refused(run(tmp_path, "tables", days[0], "-o", "junk"), 2, "cannot write junk", "-o")
    refused(run(tmp_path, "tables", days[0], "-o", "junk/t"), 2, "cannot write junk/t", "-o")


@pytest.mark.thorough
def test_a_full_disk_leaves_nothing_half_written(tmp_path: Path, days: list[Path]) -> None:
    """A folder is in the place of a file."""
    run(tmp_path, "tables", days[0], "-o", "t")
    [file] = (tmp_path / "t" / "telegrams").rglob("*.parquet")
    file.unlink()
    file.mkdir()
    done = run(tmp_path, "tables", days[0], "-o", "t")
    refused(done, 1, "t is incomplete", "run it again")
    assert not list((tmp_path / "t").rglob(".sistap-*"))


@pytest.mark.thorough
def test_a_file_that_is_none_of_the_tables(tmp_path: Path, days: list[Path]) -> None:
    run(tmp_path, "tables", *days, "-o", "t")
    copy = shutil.copy(days[0], tmp_path / "copy.pcapng")
    with Path(copy).open("ab") as file:
        file.write(write(tmp_path / "empty.pcapng", [], dissector="sis").read_bytes())
    [folder] = (tmp_path / "t" / "telegrams").glob("*/day=2023-11-14")
    (folder / "half.parquet").write_bytes(b"PAR1 and then nothing")
    refused(
        run(tmp_path, "tables", "copy.pcapng", "-o", "t"), 1, "half.parquet", "move what is none of the tables away"
    )
    (folder / "half.parquet").unlink()
    assert count(tmp_path / "t") == [len(DAY_1) + len(DAY_2), 4, 2]


def test_a_long_name_of_a_tap(tmp_path: Path) -> None:
    write_at(tmp_path / "old.pcapng", DAY_1, 0)
    run(tmp_path, "tables", "--tap", "../" + "x" * 300, "old.pcapng", "-o", "t")
    [folder] = (tmp_path / "t" / "telegrams").iterdir()
    assert folder.name == f"tap={'x' * 100}"


def with_pyarrow(folder: Path, text: str, capture: Path) -> subprocess.CompletedProcess[str]:
    """Run where pyarrow is this text."""
    (folder / "other/pyarrow").mkdir(parents=True)
    (folder / "other/pyarrow/__init__.py").write_text(text)
    path = f"{folder / 'other'}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    return run_anew(folder, "tables", capture, "-o", "t", PYTHONPATH=path)


def test_without_pyarrow(tmp_path: Path, days: list[Path]) -> None:
    text = "raise ModuleNotFoundError(name='pyarrow')"
    refused(with_pyarrow(tmp_path, text, days[0]), 1, "pyarrow is missing", "pip install pyarrow")


def test_a_fault_of_sistap_is_not_one_of_pyarrow(
    tmp_path: Path, days: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "sistap.commands.tables.convert", None)  # as if a file of sistap were missing
    with pytest.raises(ModuleNotFoundError, match="sistap.commands.tables.convert"):
        cli.main(["tables", str(days[0]), "-o", str(tmp_path / "t")])


BROKEN = {
    "its library is for another processor": ("raise ImportError('wrong ELF class')", "(wrong ELF class)"),
    "another package has a wrong version": ("raise AttributeError('numpy: no x\\nmore')", "(numpy: no x)"),
    "it says nothing": ("raise SystemError", "(SystemError)"),
    "a part is missing": ("string = bool_ = int64 = schema = lambda *_: 0", "pyarrow"),
    "a file is cut off": ("def x(", "'(' was never closed"),
}


@pytest.mark.attack("a broken pyarrow, or one without a part", "a line says why, and how to get one that works")
@pytest.mark.parametrize("how", BROKEN)
def test_a_broken_pyarrow(tmp_path: Path, days: list[Path], how: str) -> None:
    text, why = BROKEN[how]
    said = with_pyarrow(tmp_path, text, days[0])
    refused(said, 1, "pyarrow does not work with ", why, "pip install --force-reinstall pyarrow")
