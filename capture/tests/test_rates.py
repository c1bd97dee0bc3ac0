# SPDX-License-Identifier: GPL-2.0-or-later
"""`--baud auto` and `--follow-baud`, from a bus into the file, and in this process with a simulated reader."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import independent
import pytest
from portable import SIGNALS, terminals
from specification import TELEGRAMS
from test_bus import TIMEOUT_S, finish, logged, running
from test_end_to_end import CAPTURE

from sistap import cli
from sistap.tap.line.reader import PortError, PortLost
from sistap.tap.line.settings import LineSettings, Read
from sistap.tap.records.record import Event, Record, Type

if sys.platform != "win32":
    import pty
    import tty

# python-pcapng warns of itself.
pytestmark = pytest.mark.filterwarnings("ignore:Field type should not be:DeprecationWarning")

START_NS = 1_700_000_000_000_000_000
ALL = list(TELEGRAMS.values())


def captured(port: str, file: Path, *options: str) -> tuple[int, str, list[Record]]:
    """Capture until the bus ends; return exit code, standard error, records."""
    command = [*CAPTURE, "-i", port, "-w", str(file), *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
    assert "Traceback" not in done.stderr
    return done.returncode, done.stderr, independent.records(file)


def characters(records: list[Record]) -> bytes:
    return b"".join(record.data for record in records if record.type != Type.EVENT)


def changes(records: list[Record]) -> list[str]:
    return [record.data.decode() for record in records if record.event == Event.SETTINGS_CHANGED]


def assert_events_tell_the_settings(records: list[Record]) -> None:
    """What is read between two events has the settings that the first of them says."""
    now = records[0].settings
    for record in records:
        if record.event == Event.SETTINGS_CHANGED:
            now = record.settings
            assert record.data.decode().startswith(f"{now.baud} Bd {now.format}: ")
        elif record.type != Type.EVENT:
            assert record.settings == now


# -- Looking for the rate -------------------------------------------------------------------------------------------


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("baud", "text"),
    [
        (9600, "8N1"),
        (115200, "8E1"),
        *(
            pytest.param(baud, text, marks=pytest.mark.thorough)
            for baud, text in ((9600, "8E1"), (19200, "8E1"), (38400, "8N1"), (57600, "8E1"), (115200, "8N1"))
        ),
    ],
)
def test_the_settings_of_a_bus_are_found_and_nothing_is_lost_on_the_way(tmp_path: Path, baud: int, text: str) -> None:
    log, file = tmp_path / "log", tmp_path / "x.pcapng"
    options = ["--baud", str(baud), "--format", text, "--fast", "--cycles", "3", "--log", str(log)]
    with running("--listen", "127.0.0.1:0", *options) as (bus, port):
        code, said, records = captured(port, file, "--baud", "auto")
        assert finish(bus) == (0, "")
    assert code == 1  # the bus has ended
    assert f"sistap: {baud} Bd {text}: found, by a valid telegram\n" in said
    assert changes(records)[-1] == f"{baud} Bd {text}: found, by a valid telegram"
    assert_events_tell_the_settings(records)
    sent = [played.sent for played in logged(log)]
    assert len(characters(records)) == len(b"".join(sent))  # one is heard for each that was sent, whatever the rate
    found = next(place for place, record in enumerate(records) if b"found" in record.data)
    after = [record.data for record in records[found:] if record.type == Type.FRAME]
    assert after == sent[-len(after) :]
    assert records[found - 1].data == sent[-len(after) - 1]  # the telegram by which it was found
    assert len(after) > len(sent) / 2


@pytest.mark.thorough
def test_only_the_rate_is_looked_for_if_the_format_is_said(tmp_path: Path) -> None:
    with running("--listen", "127.0.0.1:0", "--baud", "19200", "--fast", "--cycles", "1") as (_, port):
        _, _, records = captured(port, tmp_path / "x", "--baud", "auto", "--format", "8E1")
    assert changes(records) == ["19200 Bd 8E1: looking for the rate", "19200 Bd 8E1: found, by a valid telegram"]


@pytest.mark.thorough
@terminals
def test_through_a_pseudo_terminal(tmp_path: Path) -> None:
    """It has no parity: 8E1 and 8N1 are the same for it."""
    log = tmp_path / "log"
    with running("--baud", "19200", "--cycles", "3", "--log", str(log)) as (bus, port):
        _, said, records = captured(port, tmp_path / "x", "--baud", "auto")
        assert finish(bus) == (0, "")
    assert re.search(r"sistap: 19200 Bd 8[EN]1: found, by a valid telegram\n", said)
    assert_events_tell_the_settings(records)
    assert len(characters(records)) == sum(len(played.sent) for played in logged(log))


class FakeReader:
    """Returns scripted reads, with its present settings; at last SIGTERM to this process."""

    name = "/dev/ttyFAKE"
    adapter = "adapter of a test"
    timing = "uncertainty 1 ms"
    notes: tuple[str, ...] = ()
    line = 0

    def __init__(self, *pieces: bytes | None) -> None:
        self.settings = LineSettings()
        self.changed: list[LineSettings] = []
        self.refused: LineSettings | None = None
        self._pieces: list[bytes | None] = list(pieces)
        self._now = START_NS

    def read(self, timeout_s: float) -> Read | None:
        self._now += int(timeout_s * 1e9)
        if not self._pieces:
            signal.raise_signal(signal.SIGTERM)
            return None
        if timeout_s == 0 and self._pieces[0] is None:
            return None
        piece = self._pieces.pop(0)
        # Time goes on also where nothing comes, as with a virtual bus.
        return Read(0, self._now, piece or b"", bytes(len(piece or b"")), 1000, self.settings)

    def change(self, settings: LineSettings) -> None:
        self.changed.append(settings)
        if settings == self.refused:
            raise PortError(f"/dev/ttyFAKE cannot do {settings}")
        self.settings = settings

    def close(self) -> None:
        """Nothing is open."""


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """Run the command with a simulated reader."""
    handlers = [(number, signal.getsignal(number)) for number in SIGNALS]

    def run(reader: FakeReader, *arguments: str) -> int:
        monkeypatch.setattr("sistap.tap.capture.running.open_reader", lambda port, settings, line: reader)
        return cli.main(["capture", "-i", reader.name, *arguments])

    yield run
    for number, handler in handlers:
        signal.signal(number, handler)


def read_back(file: Path) -> list[Record]:
    return independent.records(file)


def test_a_silent_line_is_searched_and_fills_no_file(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    reader = FakeReader(*[None] * 2060)  # 206 s: the last change is due after 198, the next one after 210
    assert run(reader, "-w", str(tmp_path / "x"), "--baud", "auto") == 0
    (started,) = read_back(tmp_path / "x")
    assert "9600 Bd 8E1; looking for the rate; " in started.data.decode()
    # 3 s each in the first round, 6 in the second, 12 in the third
    assert len(reader.changed) == 10 + 10 + 9


def test_what_had_arrived_before_a_change_has_the_settings_of_before(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    reader = FakeReader(b"x" * 526, b"tail", None, ALL[0])
    assert run(reader, "-w", str(tmp_path / "x"), "--baud", "auto") == 0
    rest = read_back(tmp_path / "x")[1:]
    before, after = LineSettings(9600, 8, "E", 2), LineSettings(9600, 8, "N", 2)
    assert [(record.type, record.data, record.settings) for record in rest] == [
        (Type.OTHER, b"x" * 526 + b"tail", before),
        (Type.EVENT, b"9600 Bd 8N1: looking for the rate", after),
        (Type.FRAME, ALL[0], after),
        (Type.EVENT, b"9600 Bd 8N1: found, by a valid telegram", after),
    ]


def test_each_file_begins_with_the_settings_of_now(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    reader = FakeReader(b"x" * 526, None, *ALL * 3)
    assert run(reader, "-w", str(tmp_path / "x"), "--baud", "auto", "-b", "filesize:2") == 0
    first, *_, last = (read_back(file)[0] for file in sorted(tmp_path.iterdir()))
    assert (first.event, first.settings) == (Event.CAPTURE_STARTED, LineSettings(9600))
    assert (last.event, last.settings) == (Event.CAPTURE_STARTED, LineSettings(9600, 8, "N", 2))


def test_settings_that_the_port_cannot_do_are_passed_over(  # type: ignore[no-untyped-def]
    run, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    reader = FakeReader(b"x" * 526, None, *[None] * 100, ALL[0])
    reader.refused = LineSettings(9600, 8, "N", 2)
    assert run(reader, "-w", str(tmp_path / "x"), "--baud", "auto") == 0
    assert reader.changed[:2] == [reader.refused, LineSettings(19200)]
    assert "sistap: /dev/ttyFAKE cannot do 9600 Bd 8N1\n" in capfd.readouterr().err


# -- Following the bus ----------------------------------------------------------------------------------------------


def test_every_telegram_is_read_at_the_rate_that_the_bus_was_told(tmp_path: Path) -> None:
    log, file = tmp_path / "log", tmp_path / "x.pcapng"
    options = ["--fast", "--rates", "38400,115200,9600", "--cycles", "4", "--log", str(log)]
    with running("--listen", "127.0.0.1:0", *options) as (bus, port):
        _, said, records = captured(port, file, "--follow-baud")
        assert finish(bus) == (0, "")
    assert_events_tell_the_settings(records)
    sent = [played.sent for played in logged(log) if "ascii" not in played.marks]
    assert [record.data for record in records if record.type == Type.FRAME] == sent
    assert not any(record.errors for record in records)
    expected = [
        "38400 Bd 8E1: 16 lets 3 test 38400 Bd for 500 ms",
        "9600 Bd 8E1: the timed test is over",
        "38400 Bd 8E1: 16 let all accept 38400 Bd",
        "115200 Bd 8E1: 16 lets 3 test 115200 Bd for 500 ms",
        "38400 Bd 8E1: the timed test is over",
        "115200 Bd 8E1: 16 let all accept 115200 Bd",
        "9600 Bd 8E1: 16 lets 3 test 9600 Bd for 500 ms",
        "115200 Bd 8E1: the timed test is over",
        "9600 Bd 8E1: 16 let all accept 9600 Bd",
        "38400 Bd 8E1: 16 lets 3 test 38400 Bd for 500 ms",
        "9600 Bd 8E1: the timed test is over",
    ]
    assert changes(records) == expected
    assert all(f"sistap: {text}\n" in said for text in expected)


@pytest.mark.thorough
def test_without_it_the_tap_stays(tmp_path: Path) -> None:
    with running("--listen", "127.0.0.1:0", "--fast", "--rates", "115200", "--cycles", "2") as (_, port):
        _, _, records = captured(port, tmp_path / "x")
    assert changes(records) == []
    assert {record.settings.baud for record in records} == {9600}
    assert any(record.errors for record in records)


def test_the_rate_is_found_and_then_followed(tmp_path: Path) -> None:
    options = ["--baud", "19200", "--fast", "--rates", "57600", "--cycles", "3"]
    with running("--listen", "127.0.0.1:0", *options) as (_, port):
        _, _, records = captured(port, tmp_path / "x", "--baud", "auto", "--follow-baud")
    assert "57600 Bd 8E1: 16 let all accept 57600 Bd" in changes(records)
    last = [record for record in records if record.type == Type.FRAME][-10:]
    assert all(record.settings.baud == 57600 and not record.errors for record in last)


@pytest.mark.thorough
@terminals
def test_in_real_time_through_a_pseudo_terminal(tmp_path: Path) -> None:
    """A late tap may hear the first telegram after a change wrongly; it must not fall behind."""
    with running("--baud", "38400", "--rates", "115200", "--cycles", "2") as (bus, port):
        _, _, records = captured(port, tmp_path / "x", "--baud", "38400", "--follow-baud")
        assert finish(bus) == (0, "")
    assert "115200 Bd 8E1: 16 let all accept 115200 Bd" in changes(records)
    last = [record for record in records if record.type != Type.EVENT][-10:]
    assert all(record.type == Type.FRAME and record.settings.baud == 115200 for record in last)


# -- The options ----------------------------------------------------------------------------------------------------


@terminals
@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--baud", "auto", "--framing", "silence:5"], "leave out --framing or --baud auto"),
        (["--follow-baud", "--framing", "silence:5"], "leave out --framing or --follow-baud"),
        (
            ["--baud", "auto", "-i", "socket://127.0.0.1:9"],
            "--baud auto cannot change the rate behind socket://127.0.0.1:9",
        ),
        (["--follow-baud", "-i", "socket://127.0.0.1:9"], "set it there, and leave out --follow-baud"),
        (["--baud", "auto", "--format", "9E1"], "format '9E1' is not"),
    ],
)
def test_what_cannot_be_is_one_line(arguments: list[str], text: str, capfd: pytest.CaptureFixture[str]) -> None:
    master, slave = pty.openpty()
    tty.setraw(slave)
    assert cli.main(["capture", "-i", os.ttyname(slave), *arguments]) == 2
    err = capfd.readouterr().err
    assert text in err and err.count("\n") == 1
    os.close(master)
    os.close(slave)


@pytest.mark.parametrize("rate", ["Auto", "0", "-5", "9600.0", "4294967296", "9" * 5000])
def test_what_is_no_rate(rate: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="^2$"):
        cli.main(["capture", "-i", "/dev/ttyFAKE", f"--baud={rate}"])
    assert "is neither auto nor a rate from 1 to 4294967295 Bd" in capfd.readouterr().err


def test_a_port_that_is_lost_while_it_is_changed_ends_it(run, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    class Unplugged(FakeReader):
        def read(self, timeout_s: float) -> Read | None:
            if timeout_s == 0:
                raise PortLost("/dev/ttyFAKE is gone")
            return super().read(timeout_s)

    assert run(Unplugged(b"x" * 526), "-w", str(tmp_path / "x"), "--baud", "auto") == 1
    assert [record.event for record in read_back(tmp_path / "x")] == [
        Event.CAPTURE_STARTED,
        Event.NONE,
        Event.ADAPTER_LOST,
    ]
