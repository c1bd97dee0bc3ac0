# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap as a library: a port, a capture, a log and the virtual bus give records; a writer takes them."""

from __future__ import annotations

import csv
import gzip
import inspect
import json
import os
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from portable import NO_TSHARK, terminals

import sistap
from sistap import cli, library
from sistap.tap.sis.telegram import build

CAPTURE = Path(__file__).parents[1]
READ = build(0x10, 16, 3, bytes.fromhex("3C 03 00 24 00"))
ANSWER = build(0x10, 16, 3, bytes.fromhex("00 3C 03 00 00 00 00"), reaction=True)
CHARACTER_NS = 1_145_833  # 11 bits at 9600 Bd


def test_the_bus_gives_what_its_capture_has(tmp_path: Path) -> None:
    capture = tmp_path / "bus.pcapng"
    assert cli.main(["bus", "late-reaction", "--duration", "3", "-w", str(capture)]) == 0
    played = list(sistap.play("late-reaction", duration_s=3))
    assert [record.data for record in played] == [record.data for record in sistap.read(capture)]
    assert played[0].event == sistap.Event.CAPTURE_STARTED


def test_times_of_characters() -> None:
    record = sistap.Record(
        1000, sistap.Type.FRAME, 0, sistap.LineSettings(), b"ab", (77, CHARACTER_NS), bytes([0x20, 0x02]), 500
    )
    assert list(record.characters()) == [
        sistap.Character(1000, 0x61, sistap.Flag.INTERVAL_UNKNOWN),
        sistap.Character(1000 + CHARACTER_NS, 0x62, sistap.Flag.CHARACTER_ERROR),
    ]


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    capture = tmp_path / "copy.pcapng"
    records = [record for record in sistap.play("demo", duration_s=2) if record.type == sistap.Type.FRAME]
    with sistap.Writer(capture) as writer:
        for record in records:
            writer.write(record)
    again = list(sistap.read(capture))
    assert [(one.time_ns, one.data, list(one.intervals), one.flags) for one in again] == [
        (one.time_ns, one.data, list(one.intervals), one.flags) for one in records
    ]


def test_a_log(tmp_path: Path) -> None:
    log = tmp_path / "night.log"
    log.write_text(f"12:00:00.000 TX: {READ.hex(' ')}\n12:00:00.010 RX: {ANSWER.hex(' ')}\n")
    assert [record.data for record in sistap.read(log)] == [READ, ANSWER]


@terminals
def test_a_port() -> None:
    """Records come while the port is open; when it is gone, PortLost says so."""
    master, slave = os.openpty()
    found = []
    with sistap.Tap(os.ttyname(slave), baud=9600) as tap:
        os.close(slave)
        sender = threading.Thread(target=lambda: os.write(master, READ + ANSWER))
        with pytest.raises(sistap.PortLost):
            for record in tap:
                if record.event == sistap.Event.CAPTURE_STARTED:
                    sender.start()
                if record.type == sistap.Type.FRAME:
                    found.append(record.data)
                    if record.data == ANSWER:
                        os.close(master)
    sender.join()
    assert found == [READ, ANSWER]


# -- The documents -----------------------------------------------------------------------------------------------------

ATTRIBUTES = bytes.fromhex("1C 05 00 24 00"), bytes.fromhex("00 1C 05 01 00 22 04")  # S-0-0036: four decimal places
TEXT = bytes.fromhex("00 3C 05 04 00 3C 00")  # of S-0-0095, four letters
TRAFFIC = [
    build(0x10, 16, 3, ATTRIBUTES[0]),
    build(0x10, 16, 3, ATTRIBUTES[1], reaction=True),
    build(0x1F, 16, 3, bytes.fromhex("3C 05 00 24 00 80 96 98 00")),
    build(0x1F, 16, 3, bytes.fromhex("00 3C 05"), reaction=True),
    build(0x10, 16, 3, bytes.fromhex("3C 05 00 5F 00")),
    build(0x10, 16, 3, TEXT + b"F228", reaction=True),
    build(0x10, 17, 3, bytes.fromhex("3C 05 00 5F 00")),
    build(0x10, 17, 3, TEXT + b"F228", reaction=True),
    build(0x10, 17, 3, bytes.fromhex("3C 05 00 5F 00")),
    build(0x10, 17, 3, TEXT + b"A101", reaction=True),
]


def programs(page: str) -> list[str]:
    text = (CAPTURE / page).read_text("utf-8")
    return [part.split("```")[0] for part in text.split("```python\n")[1:]]


@pytest.fixture
def line(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Replace the port of a program's Tap by one with the traffic, which is closed when that is over."""
    master, slave = os.openpty()
    tap = sistap.Tap(os.ttyname(slave), baud=19200)

    class Ending:
        def __enter__(self) -> Iterator[sistap.Record]:
            for record in tap:
                if record.event == sistap.Event.CAPTURE_STARTED:
                    os.write(master, b"".join(TRAFFIC))
                if record.data == TRAFFIC[-1]:
                    tap.close()
                yield record

        def __exit__(self, *reason: object) -> None:
            tap.close()

    monkeypatch.setattr(sistap, "Tap", lambda *_, **__: Ending(), raising=False)
    yield
    tap.close()
    os.close(slave)
    os.close(master)


@pytest.fixture
def day(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[sistap.Record]:
    """Go to a folder with the capture of the demo bus that the programs read."""
    records = list(sistap.play("demo", duration_s=10))
    with sistap.Writer(tmp_path / "day.pcapng") as writer:
        for record in records:
            writer.write(record)
    monkeypatch.chdir(tmp_path)
    return records


WRITTEN = "16 -> 3  Command  Write parameter S-0-0036 (Velocity command value) = 1000.0"


@terminals
def test_the_program_that_prints_every_write(
    line: None, day: list[sistap.Record], capsys: pytest.CaptureFixture[str]
) -> None:
    """Of the file, then of the port. The line below the program is one that it prints."""
    exec(programs("README.md")[0], {})
    written = capsys.readouterr().out.splitlines()
    of_file = [record for record in day if record.telegram and record.telegram.service == 0x1F]
    assert len(written) == sum(not record.telegram.is_reaction for record in of_file if record.telegram) + 1
    assert written[-1] == WRITTEN
    shown = (CAPTURE / "README.md").read_text("utf-8").split("```")[2].strip().splitlines()
    assert 0 < len(shown[:2]) == sum(line.strip() in written for line in shown[:2])


def test_the_program_that_dissects(day: list[sistap.Record], capsys: pytest.CaptureFixture[str]) -> None:
    exec(programs("docs/library.md")[0], {})
    printed = [line.split(" ", 2)[1] for line in capsys.readouterr().out.splitlines()]
    said = [one.telegram for one in day if one.telegram and one.telegram.is_reaction]
    assert printed == [one.parameter for one in said if one.parameter and one.element == "value"]


@terminals
def test_the_web_hook(line: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second master reads the same diagnosis: the hook is called once."""
    called = []
    monkeypatch.setattr("urllib.request.urlopen", lambda url, body, timeout: called.append(json.loads(body)))
    exec(programs("docs/library.md")[1], {})
    assert called == [{"drive": "3", "diagnosis": "F228"}]


def test_the_table_of_values(day: list[sistap.Record], capsys: pytest.CaptureFixture[str]) -> None:
    exec(programs("docs/library.md")[2], {})
    rows = list(csv.reader(capsys.readouterr().out.splitlines()))
    asked = [one.telegram for one in day if one.telegram and one.telegram.parameter == "S-0-0040"]
    assert len(rows) == sum(one.is_reaction and one.element == "value" for one in asked) > 3
    assert {(row[1], row[3]) for row in rows} == {("3", "rpm"), ("4", "rpm")}


@terminals
def test_the_watch_for_a_second_master(line: None, capsys: pytest.CaptureFixture[str]) -> None:
    exec(programs("docs/library.md")[3], {})
    assert capsys.readouterr().out == "another master: 17\n"


# -- Errors ------------------------------------------------------------------------------------------------------------


def test_a_port_that_is_not_there() -> None:
    with pytest.raises(sistap.PortError, match="/dev/no-such-port"):
        sistap.Tap("/dev/no-such-port")


@pytest.mark.parametrize("ports", [(), ("/dev/a", "/dev/b", "/dev/c")])
def test_no_port_or_too_many(ports: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match=f"one port, or the two of a full-duplex line, not {len(ports)}"):
        sistap.Tap(*ports)


def test_a_file_that_has_data(tmp_path: Path) -> None:
    """The text has no options of the command."""
    (tmp_path / "day.pcapng").write_bytes(b"data")
    with pytest.raises(sistap.OutputRefused, match="holds data already; choose another path, or overwrite it with fo"):
        sistap.Writer(tmp_path / "day.pcapng")


def test_what_is_no_capture_and_no_log(tmp_path: Path) -> None:
    (tmp_path / "cut.pcapng").write_bytes(bytes.fromhex("0A0D0D0A 1C000000 4D3C2B1A 00000000"))
    with pytest.raises(sistap.NotCaptured, match=r"cut\.pcapng"):
        list(sistap.read(tmp_path / "cut.pcapng"))
    (tmp_path / "picture.log").write_bytes(bytes.fromhex("1F8B08") + bytes(64))
    with pytest.raises(sistap.SourceError, match=r"picture\.log"):
        list(sistap.read(tmp_path / "picture.log"))


def test_every_error_is_an_error() -> None:
    """Their texts are for people: one line, with the cure. NotCaptured was a ValueError before."""
    errors = [getattr(sistap, name) for name in sistap.__all__]
    errors = [one for one in errors if inspect.isclass(one) and issubclass(one, Exception)]
    assert len(errors) == 8
    assert all(issubclass(one, sistap.Error) for one in errors)
    assert issubclass(sistap.NotCaptured, ValueError)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    for function in (sistap.read, sistap.dissect):
        with pytest.raises(FileNotFoundError):
            next(function(tmp_path / "missing.pcapng"))


def test_a_writer_is_closed_once(tmp_path: Path) -> None:
    records = list(sistap.play("demo", duration_s=1))
    with sistap.Writer(tmp_path / "day.pcapng") as writer:
        writer.write(records[0])
        writer.close()
    writer.close()
    with pytest.raises(sistap.OutputError, match="the file is closed: open another Writer"):
        writer.write(records[0])
    assert len(list(sistap.read(tmp_path / "day.pcapng"))) == 1


def test_a_compressed_capture(tmp_path: Path, day: list[sistap.Record]) -> None:
    """As a recorder leaves it."""
    packed = tmp_path / "day.pcapng.gz"
    packed.write_bytes(gzip.compress((tmp_path / "day.pcapng").read_bytes()))
    assert list(sistap.read(packed)) == list(sistap.read(tmp_path / "day.pcapng"))


# -- Wireshark ---------------------------------------------------------------------------------------------------------


def test_dissect_a_file_and_records(day: list[sistap.Record]) -> None:
    """Fields of one's own beside those that it has; the same of both."""
    said = [
        [(packet.number, packet.columns["sis.parameter"], packet.columns["frame.len"]) for packet in packets]
        for packets in (
            sistap.dissect("day.pcapng", "frame.len", "sis.parameter"),
            sistap.dissect(iter(day), "frame.len", "sis.parameter"),
        )
    ]
    assert said[0] == said[1]
    assert len(said[0]) == len(day)
    assert "S-0-0036" in {parameter for _, parameter, _ in said[0]}
    packets = list(sistap.dissect("day.pcapng", "sis.parameter"))
    assert isinstance(packets[0], sistap.Packet)
    assert any(packet.accesses for packet in packets)


def test_dissect_is_left_early(day: list[sistap.Record]) -> None:
    packets = sistap.dissect("day.pcapng")
    assert next(packets).number == 1
    packets.close()  # type: ignore[attr-defined]


def test_dissect_what_it_cannot(tmp_path: Path, day: list[sistap.Record], monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="tshark knows no field sis.speed"):
        next(sistap.dissect("day.pcapng", "sis.speed"))
    (tmp_path / "night.log").write_text(READ.hex(" "))
    with pytest.raises(sistap.NotCaptured, match=r"night\.log is not a capture .* `sistap annotate"):
        next(sistap.dissect("night.log"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(sistap.TsharkError, match=NO_TSHARK[0]):
        next(sistap.dissect("day.pcapng"))


def test_a_capture_that_is_cut_off(day: list[sistap.Record], caplog: pytest.LogCaptureFixture) -> None:
    """What is there comes; the logger says that it is not all."""
    cut = Path("day.pcapng").read_bytes()[:-200]
    Path("cut.pcapng").write_bytes(cut)
    assert 0 < len(list(sistap.dissect("cut.pcapng"))) < len(day)
    assert "cut.pcapng: " in caplog.text and "cut short" in caplog.text
    caplog.clear()
    packed = gzip.compress(cut)[:-9]
    Path("packed.pcapng.gz").write_bytes(packed)
    for name in ("cut.pcapng", "packed.pcapng.gz"):
        assert 0 < len(list(sistap.read(name))) < len(day)
        assert f"{name} is cut off" in caplog.text
    caplog.clear()
    assert len(list(sistap.read("day.pcapng"))) == len(day) and not caplog.text


@pytest.mark.parametrize(
    ("log", "said"),
    [
        (b"nothing but words\n", "has no telegram of SIS; bytes found in it: 0"),
        (b"01 02 03 04\n", "has no telegram of SIS; bytes found in it: 4"),
        (READ.hex(" ").encode(), ""),
    ],
)
def test_a_log_without_telegrams(tmp_path: Path, caplog: pytest.LogCaptureFixture, log: bytes, said: str) -> None:
    (tmp_path / "a.log").write_bytes(log)
    list(sistap.read(tmp_path / "a.log"))
    assert [record.getMessage() for record in caplog.records] == ([f"{tmp_path / 'a.log'} {said}"] if said else [])


# -- Names -------------------------------------------------------------------------------------------------------------


def test_the_command_starts_without_it() -> None:
    code = "import sistap, sys; sys.exit('sistap.library' in sys.modules or not sistap.read)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_it_loads_what_is_used() -> None:
    """A tap needs no log, no virtual bus and no tshark."""
    code = """
import sistap, sys
sistap.Tap, sistap.Record, sistap.Telegram, sistap.Error, sistap.PortLost, sistap.read, sistap.dissect
print(*sorted({name.split(".")[2] for name in sys.modules if name.count(".") > 1 and name.startswith("sistap.")}))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    rooms = {"capture", "captures", "files", "line", "records", "sis", "telegrams", "terminal"}
    assert set(done.stdout.split()) == rooms


def test_it_can_be_imported_where_there_are_no_terminals(day: list[sistap.Record]) -> None:
    """As on Windows."""
    code = """
import sys
sys.modules["termios"] = sys.modules["tty"] = sys.modules["pty"] = None
import sistap
print(len([getattr(sistap, name) for name in sistap.__all__]), len(list(sistap.read("day.pcapng"))))
"""
    environment = {**os.environ, "PYTHONPATH": str(CAPTURE)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.split() == [str(len(sistap.__all__)), str(len(day))]


def test_its_types_are_told() -> None:
    """To programs that mypy checks."""
    assert (Path(sistap.__file__).parent / "py.typed").exists()
    assert '"py.typed"' in (CAPTURE / "pyproject.toml").read_text("utf-8")


def test_the_names_that_stay_the_same() -> None:
    assert sistap.__all__ == library.__all__
    page = (CAPTURE / "docs" / "library.md").read_text("utf-8")
    for name in sistap.__all__:
        assert re.search(rf"`{name}\b", page), name


def test_an_unknown_name() -> None:
    with pytest.raises(AttributeError, match="'sistap' has no attribute 'record'; it has Character, Error,"):
        sistap.record  # noqa: B018
