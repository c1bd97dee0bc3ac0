# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap selftest`: what it measures, prints and keeps, and that it sends nothing without permission."""

import errno
import os
import pty
import random
import select
import signal
import subprocess
import sys
import threading
import time
import tty
from array import array
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sistap import cli
from sistap.commands import selftest
from sistap.tap.common.quantiles import quantile
from sistap.tap.line import measurement
from sistap.tap.line.reader import delay

MS = 1_000_000
PATIENCE_S = 60  # only reached when a test fails


@pytest.fixture
def no_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(random, "uniform", lambda least, most: 0.00001)


class Port:
    """A pseudo terminal at whose far end `answer` turns what comes into what goes back."""

    def __init__(self, answer: Callable[[bytes], bytes]) -> None:
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.name = os.ttyname(self._slave)
        self.heard = b""
        self._answer = answer
        self._end, self._ended = os.pipe()
        self._thread = threading.Thread(target=self._play)
        self._thread.start()

    def _play(self) -> None:
        while self._master in (ready := select.select([self._master, self._end], [], [])[0]) and self._end not in ready:
            data = os.read(self._master, 4096)
            self.heard += data
            os.write(self._master, self._answer(data))

    def close(self) -> None:
        os.write(self._ended, b"x")
        self._thread.join(PATIENCE_S)
        for descriptor in (self._master, self._slave, self._end, self._ended):
            os.close(descriptor)


@pytest.fixture
def port() -> Iterator[Callable[[Callable[[bytes], bytes]], Port]]:
    made: list[Port] = []

    def make(answer: Callable[[bytes], bytes]) -> Port:
        made.append(Port(answer))
        return made[-1]

    yield make
    for one in made:
        one.close()


# -- Measuring ---------------------------------------------------------------------------------------------------------


class Ended:
    """A writer that has written everything."""

    def is_alive(self) -> bool:
        return False


def read_back(monkeypatch: pytest.MonkeyPatch, came: list[bytes], at_ns: list[int], written_ns: list[int]) -> list[int]:
    """Return the delays when these characters come at these times."""

    class Poll:
        def register(self, fd: int, events: int) -> None: ...

        def poll(self, timeout: float) -> bool:
            return True

    reads, now = iter(came), iter(at_ns)
    monkeypatch.setattr(select, "poll", Poll)
    monkeypatch.setattr(os, "read", lambda fd, size: next(reads))
    monkeypatch.setattr(delay, "monotonic_ns", lambda: next(now))
    return list(delay._read(0, array("q", written_ns), Ended()))  # type: ignore[arg-type]


def test_delays_are_from_write_to_read(monkeypatch: pytest.MonkeyPatch) -> None:
    delays = read_back(monkeypatch, [b"@", b"AB", b"C"], [1_000, 5_500, 9_100], [900, 2_000, 4_000, 9_000])
    assert delays == [100, 3_500, 1_500, 100]


@pytest.mark.parametrize("came", [b"@A", b"A", b""])  # one more than was sent, another one, the end
def test_what_was_not_sent_is_no_delay(monkeypatch: pytest.MonkeyPatch, came: bytes) -> None:
    with pytest.raises(delay.LoopBroken):
        read_back(monkeypatch, [came], [1_000], [900])


def test_the_time_on_the_line_is_no_delay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delay, "_read", lambda reading, written, writer: array("q", [1_200_000, 1_000_000]))
    master, slave = pty.openpty()
    assert list(delay.through(slave, master, 0, character_ns=1_145_833)) == [54_167, 0]
    for descriptor in (master, slave):
        os.close(descriptor)


def test_what_the_port_does_not_take_is_not_awaited(no_pauses: None) -> None:
    """As of cdc_acm, while 16 characters are on their way: here the pipe is full until somebody reads."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    with pytest.raises(BlockingIOError):
        while True:
            os.write(writing, bytes(1 << 16))
    written = array("q")
    delay._write(os.dup(writing), written, 0, 0)
    assert not written
    os.read(reading, 1 << 20)
    delay._write(writing, written, 0, 0)
    assert len(written) == 1
    assert os.read(reading, 9) == b"@"
    os.close(reading)


def test_through_a_pseudo_terminal(no_pauses: None) -> None:
    delays = delay.through_pty(500 * MS)
    assert len(delays) > 10
    assert min(delays) > 0


def test_a_machine_that_is_late_sends_a_character_all_the_same() -> None:
    assert len(delay.through_pty(0)) == 1


def test_quantiles() -> None:
    for count, expected in ((1000, [500, 900, 990, 999, 1000]), (1001, [501, 901, 991, 1000, 1001])):
        values = range(1, count + 1)
        assert [quantile(values, share) for share in selftest.QUANTILES.values()] == expected
    assert [quantile([7], share) for share in selftest.QUANTILES.values()] == [7] * 5


def test_report() -> None:
    delays = sorted([15_000] * 900 + [45_000] * 98 + [2_291_666, 30 * MS])  # 2.29 ms: two characters at 9600 Bd 8E1
    text = "\n".join(selftest.report(delays))
    for line in (
        "1000 characters; how late they were seen:",
        "  p50         0.015 ms",
        "  p90         0.015 ms",
        "  p99         0.045 ms",
        "  p99.9       2.292 ms",
        "  longest    30.000 ms",
        "    9600 Bd     2.00   (a character takes 1.146 ms)",
        "  115200 Bd    24.00   (a character takes 0.095 ms)",
    ):
        assert f"\n{line}\n" in f"\n{text}\n"


def test_histogram() -> None:
    assert selftest.histogram([20_000] * 4 + [20_001] + [200_000] * 2 + [60 * MS]) == [
        "  <= 0.02 ms         4  ########################################",
        "  <= 0.05 ms         1  ##########",
        "   <= 0.1 ms         0",
        "   <= 0.2 ms         2  ####################",
        *(f"  {'<= ' + row + ' ms':>10}         0" for row in ("0.5", "1", "2", "5", "10", "20", "50")),
        "     > 50 ms         1  ##########",
    ]


# -- The command -------------------------------------------------------------------------------------------------------


def run(*arguments: str) -> int:
    return cli.main(["selftest", "--duration", "1", *arguments])


def test_this_machine(no_pauses: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert run() == 0
    ((place, date, characters, p999_ns, longest_ns, conditions),) = measurement.load()[0]
    assert place == measurement.MACHINE
    assert date == time.strftime("%Y-%m-%d")
    assert 0 < p999_ns <= longest_ns
    assert set(conditions) == {"machine", "kernel", "priority"}
    out = capsys.readouterr().out
    assert f"\n{characters} characters; " in out
    assert f"  p99.9    {p999_ns / 1e6:8.3f} ms\n" in out
    assert "selftest.json: captures under these conditions (" in out


def test_a_port_whose_lines_are_joined(
    port: Callable[[Callable[[bytes], bytes]], Port], no_pauses: None, capsys: pytest.CaptureFixture[str]
) -> None:
    joined = port(lambda data: data)
    assert run("-i", joined.name, "--transmit", "--baud", "115200") == 0
    ((place, _, characters, _, _, conditions),) = measurement.load()[0]
    assert place == f"pseudo terminal at {joined.name}"
    assert (conditions["adapter"], conditions["line"]) == ("pseudo terminal", "115200 Bd 8E1")
    assert len(joined.heard) == characters
    assert set(joined.heard) <= set(range(0x40, 0x7F))  # no start of a telegram, nothing that a port would mark


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda data: b"", "a character that was sent did not come back within a second"),
        (lambda data: data + b"?", "what came back is not what was sent ("),
        (lambda data: bytes(c ^ 1 for c in data), "what came back is not what was sent ("),
    ],
)
def test_a_port_whose_lines_are_not_joined(
    port: Callable[[Callable[[bytes], bytes]], Port],
    answer: Callable[[bytes], bytes],
    said: str,
    capfd: pytest.CaptureFixture[str],
) -> None:
    bus = port(answer)
    assert run("-i", bus.name, "--transmit") == 1
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"sistap: no result: {said}")
    assert line.endswith(f": join the transmit and receive lines of {bus.name}, and nothing else to them")
    assert measurement.load() == ([], "")


def test_without_transmit_nothing_is_sent(
    port: Callable[[Callable[[bytes], bytes]], Port], capfd: pytest.CaptureFixture[str]
) -> None:
    bus = port(lambda data: data)
    assert run("-i", bus.name) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert "would disturb it" in line and "--transmit" in line
    assert bus.heard == b""


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--duration", "0.5"], "is not a number of seconds from 1 to 3600"),
        (["--duration", "nan"], "is not a number of seconds from 1 to 3600"),
        (["--transmit"], "say it with -i"),
        (["-i", "socket://localhost:1", "--transmit"], "is no device"),
        (["-i", "/dev/ttyS9", "--transmit", "--baud", "0"], "is no rate"),
        (["-i", "/dev/ttyS9", "--transmit", "--format", "9E1"], "format '9E1' is not"),
    ],
)
def test_wrong_usage(arguments: list[str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert run(*arguments) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert said in line


def test_a_port_that_cannot_be_opened(capfd: pytest.CaptureFixture[str]) -> None:
    assert run("-i", "/dev/ttyMISSING7", "--transmit") == 3
    assert "does not exist" in capfd.readouterr().err


def test_too_few_characters_are_not_kept(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(delay, "through_pty", lambda duration_ns: array("q", [1000] * 999))
    assert run() == 1
    assert "999 characters are too few for p99.9" in capfd.readouterr().err
    assert measurement.load() == ([], "")


def test_what_was_measured_over_a_stop_is_not_kept(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """So long an uncertainty does not fit into a record, so captures would reject the whole file."""
    monkeypatch.setattr(delay, "through_pty", lambda duration_ns: array("q", [1000] * 1999 + [5_000 * MS]))
    assert run() == 1
    assert "for 5 s sistap was stopped: measure again" in capfd.readouterr().err
    assert measurement.load() == ([], "")


def test_a_result_that_cannot_be_kept_is_shown(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr(delay, "through_pty", lambda duration_ns: array("q", [1000] * 1000))
    assert run() == 1
    out, err = capfd.readouterr()
    assert "p99.9" in out
    assert "the result cannot be kept" in err and "XDG_STATE_HOME" in err and err.count("\n") == 1


def test_no_pseudo_terminal(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    def none() -> tuple[int, int]:
        raise OSError(errno.ENOENT, "out of pty devices")

    monkeypatch.setattr(pty, "openpty", none)
    assert run() == 1
    assert capfd.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it(number: signal.Signals) -> None:
    command = [sys.executable, "-m", "sistap", "selftest", "--duration", "3600"]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout
    assert child.stdout.readline().startswith("measuring for 3600 s through a pseudo terminal, ")
    child.send_signal(number)
    out, err = child.communicate(timeout=PATIENCE_S)
    assert (child.returncode, out, err) == (0, "", "")
    assert measurement.load() == ([], "")
