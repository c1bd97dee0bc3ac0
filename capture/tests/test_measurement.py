# SPDX-License-Identifier: GPL-2.0-or-later
"""Results of self-tests: kept, found again where they hold, and skipped with one line where they do not."""

from __future__ import annotations

import json
import os
import platform
import pty
from pathlib import Path
from typing import NamedTuple

import pytest

from sistap.tap.line import measurement, ports, priority
from sistap.tap.line.measurement import MACHINE, Conditions, Result
from sistap.tap.line.reader import computer, delay, latency
from sistap.tap.line.reader.contract import STEP_MS
from sistap.tap.line.settings import UNCERTAINTY_UNKNOWN, LineSettings

pytestmark = pytest.mark.tap

HERE: Conditions = {"machine": "bench", "kernel": "6.1.0-28-amd64", "priority": "ordinary priority"}
FTDI = ports.Adapter("FT232R USB UART", "ftdi_sio", latency_ms=1, serial="A50285BI")
UNKNOWN = ports.Adapter("CP2102", "cp210x", serial="0001")
SETTINGS = LineSettings(9600)
MEASURED_NS = 400_000  # when a capture starts
MEASURING = computer.measured_ns.__wrapped__  # which remembers nothing


def result(p999_ns: int = 250_000, place: str = MACHINE, conditions: Conditions = HERE) -> Result:
    return Result(place, "2026-11-20", 5000, p999_ns, max(p999_ns, 3_000_000), conditions)


@pytest.fixture(autouse=True)
def bench(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(platform, "node", lambda: HERE["machine"])
    monkeypatch.setattr(platform, "release", lambda: HERE["kernel"])
    monkeypatch.setattr(priority, "words", lambda: HERE["priority"])
    monkeypatch.setattr(latency, "measured_ns", lambda: MEASURED_NS)


class At(NamedTuple):
    """A bound when the capture starts."""

    ns: int
    how: str
    notes: tuple[str, ...]


def bound(behind: ports.Adapter, settings: LineSettings = SETTINGS) -> At:
    known = latency.known()
    found = latency.bound(known, "/dev/ttyUSB0", behind, settings)
    return At(found.ns(known.machine_ns), found.how, found.notes)


def store_for(behind: ports.Adapter, p999_ns: int, settings: LineSettings = SETTINGS) -> None:
    place = ports.identity("/dev/ttyUSB0", behind)
    measurement.store(result(p999_ns, place, latency.port_conditions(behind, settings)))


def test_kept_and_found_again(state: Path) -> None:
    assert measurement.load() == ([], "")
    path = measurement.store(result())
    assert path == state / "sistap/selftest.json"
    assert measurement.load() == ([result()], "")
    assert os.listdir(path.parent) == [path.name]


def test_one_result_for_each_place_and_conditions() -> None:
    other_kernel = result(1, conditions=HERE | {"kernel": "6.12.0"})
    for one in (result(1), other_kernel, result(2, place="FT232R A1"), result(3)):
        measurement.store(one)
    assert measurement.load()[0] == [other_kernel, result(2, place="FT232R A1"), result(3)]


def test_it_does_not_grow_for_ever() -> None:
    for number in range(60):
        measurement.store(result(number + 1, place=f"adapter {number}"))
    places = [one.place for one in measurement.load()[0]]
    assert places == [f"adapter {number}" for number in range(10, 60)]


def test_where_it_is_kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """XDG base directories: ~/.local/state by default; a relative folder is ignored."""
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setenv("HOME", str(tmp_path))
    for value in ("", "state"):
        monkeypatch.setenv("XDG_STATE_HOME", value)
        assert measurement.file() == tmp_path / ".local/state/sistap/selftest.json"


GOOD = {"place": MACHINE, "date": "2026-11-20", "characters": 5000, "p999_ns": 1, "longest_ns": 2, "conditions": {}}


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe",
        pytest.param(b"[" * 100_000, id="deep"),
        pytest.param(b'{"results": []}'.ljust(1_000_001), id="large"),
        b"[]",
        b"{}",
        b'{"results": 1}',
        b'{"results": ["a"]}',
        *(
            json.dumps({"results": [entry]}).encode()
            for entry in (
                {"place": MACHINE},
                {**GOOD, "more": 1},
                {**GOOD, "p999_ns": 0},
                {**GOOD, "p999_ns": 0.5},
                {**GOOD, "p999_ns": True},
                {**GOOD, "p999_ns": 3},  # longer than the longest
                {**GOOD, "p999_ns": "1"},
                {**GOOD, "longest_ns": 0xFFFFFFFF},  # which means that it is not known
                {**GOOD, "characters": 0},
                {**GOOD, "date": 20261120},
                {**GOOD, "conditions": []},
                {**GOOD, "conditions": {"kernel": 6}},
            )
        ),
    ],
)
def test_a_broken_file_is_passed_over_with_one_line_and_replaced(state: Path, content: bytes) -> None:
    path = measurement.store(result())
    path.write_bytes(content)
    known = latency.known()
    assert (known.machine_ns, known.how) == (MEASURED_NS, "measured when the capture started and ever since")
    (note,) = known.notes
    assert note == f"{path} is not what `sistap selftest` writes and is ignored: run it again to replace the file"
    measurement.store(result())
    assert measurement.load() == ([result()], "")


def test_the_checks_of_a_file_let_a_good_one_pass(state: Path) -> None:
    path = measurement.store(result())
    smallest = {**GOOD, "characters": 1, "longest_ns": 1}
    largest = {**GOOD, "longest_ns": 0xFFFFFFFE}
    path.write_text(json.dumps({"results": [smallest, largest]}).ljust(1_000_000))
    assert measurement.load() == ([Result(**smallest), Result(**largest)], "")  # type: ignore[arg-type]


def test_a_result_that_cannot_be_kept_leaves_the_file_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, target: Path) -> None:
        raise OSError(28, "No space left on device")

    path = measurement.store(result(1))
    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", refuse)
        with pytest.raises(OSError, match="No space left"):
            measurement.store(result(2))
    assert measurement.load() == ([result(1)], "")
    assert os.listdir(path.parent) == [path.name]


def test_a_pipe_in_its_place_is_not_waited_for(state: Path) -> None:
    path = measurement.store(result())
    path.unlink()
    os.mkfifo(path)
    assert measurement.load()[1].endswith("run it again to replace the file")


def test_a_file_that_cannot_be_read(monkeypatch: pytest.MonkeyPatch) -> None:
    measurement.store(result())

    def refuse(path: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    known = latency.known()
    assert known.machine_ns == MEASURED_NS
    (note,) = known.notes
    assert "cannot be read" in note and "Permission denied" in note


def test_nobody_has_no_home(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    monkeypatch.setenv("XDG_STATE_HOME", "")
    monkeypatch.setattr(Path, "home", homeless)
    assert len(latency.known().notes) == 1


def test_a_capture_takes_the_machines_part_from_it() -> None:
    measurement.store(result())
    assert bound(ports.Adapter(pseudo_terminal=True)) == (
        250_000,
        "uncertainty 0.25 ms, measured by selftest on 2026-11-20 and ever since",
        (),
    )
    assert bound(FTDI) == (
        1_250_000,
        "uncertainty 1.25 ms: latency timer 1 ms and 0.25 ms, measured by selftest on 2026-11-20 and ever since",
        (),
    )


@pytest.mark.parametrize(
    ("name", "other"), [("machine", "laptop"), ("kernel", "6.12.0"), ("priority", "real-time priority")]
)
def test_it_holds_only_under_its_conditions(name: str, other: str) -> None:
    measurement.store(result(conditions=HERE | {name: other}))
    known = latency.known()
    assert (known.machine_ns, known.how) == (MEASURED_NS, "measured when the capture started and ever since")
    assert known.notes == (
        f"the self-test of 2026-11-20 does not hold here ({name} {other}, now {HERE[name]}): "
        "run `sistap selftest` again",
    )


def test_of_several_that_do_not_hold_the_newest_is_named() -> None:
    for date, kernel in (("2026-11-18", "6.12.0"), ("2026-11-19", "6.13.0")):
        measurement.store(result(conditions=HERE | {"kernel": kernel})._replace(date=date))
    (note,) = latency.known().notes
    assert note.startswith("the self-test of 2026-11-19 does not hold here (kernel 6.13.0, now ")


def test_of_several_the_one_that_holds() -> None:
    measurement.store(result(250_000))
    measurement.store(result(90_000, conditions=HERE | {"priority": "real-time priority"}))
    known = latency.known()
    assert (known.machine_ns, known.notes) == (250_000, ())


def test_what_an_unknown_adapter_adds_is_known_from_its_self_test() -> None:
    before = bound(UNKNOWN)
    assert before.how.endswith("; what the adapter adds is not known")
    assert [note for note in before.notes if "`sistap selftest -i /dev/ttyUSB0 --transmit` measures it" in note]
    store_for(UNKNOWN, 2_500_000)
    assert bound(UNKNOWN) == (
        2_500_000,
        "uncertainty 2.50 ms, measured by selftest of the port on 2026-11-20 and ever since",
        (),
    )
    store_for(UNKNOWN, MEASURED_NS - 1)  # it adds nothing
    assert bound(UNKNOWN) == (MEASURED_NS, "uncertainty 0.40 ms, measured when the capture started and ever since", ())


def test_a_self_test_of_a_port_never_makes_the_uncertainty_smaller() -> None:
    store_for(FTDI, 700_000)  # less than its latency timer
    assert bound(FTDI).ns == 1_000_000 + MEASURED_NS
    store_for(FTDI, 1_900_000)
    assert bound(FTDI).ns == 1_900_000


def test_of_two_bounds_that_are_equal_the_measured_one_is_named() -> None:
    store_for(FTDI, 1_000_000 + MEASURED_NS)
    assert bound(FTDI).how == "uncertainty 1.40 ms, measured by selftest of the port on 2026-11-20 and ever since"


@pytest.mark.parametrize(("trigger", "characters"), [(1, 0), (2, 4), (14, 16)])
def test_a_fifo_holds_a_character_until_its_trigger_or_its_time_out(trigger: int, characters: int) -> None:
    """A 16550 raises its interrupt at the trigger, or four character times after the last character."""
    adapter = ports.Adapter("16550A", "8250", fifo_trigger=trigger)
    at = bound(adapter)
    assert (at.ns, at.notes) == (MEASURED_NS + characters * SETTINGS.character_ns, ())


def test_this_machine_is_measured_for_200_ms(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(delay.Computer, "measure", lambda _, duration_ns: asked.append(duration_ns))
    MEASURING()
    assert asked == [200_000_000]


def test_without_a_pseudo_terminal_nobody_knows(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse() -> None:
        raise OSError(2, "No such file")

    monkeypatch.setattr(pty, "openpty", refuse)
    monkeypatch.setattr(latency, "measured_ns", MEASURING)
    how = "uncertainty unknown: there is no pseudo terminal to measure with"
    assert bound(FTDI) == (UNCERTAINTY_UNKNOWN, how, ())


def test_a_self_test_of_a_port_holds_for_its_adapter_tuning_and_line() -> None:
    store_for(FTDI, 9_000_000)
    assert bound(FTDI).ns == 9_000_000
    for behind, settings, said in (
        (FTDI._replace(latency_ms=16), SETTINGS, "adapter FT232R USB UART (ftdi_sio, latency timer 1 ms), now "),
        (FTDI, LineSettings(19200), "line 9600 Bd 8E1, now 19200 Bd 8E1"),
    ):
        at = bound(behind, settings)
        assert at.ns == (behind.latency_ms or 0) * 1_000_000 + MEASURED_NS
        (note,) = at.notes
        assert said in note
    twin = bound(FTDI._replace(serial="A50285BJ"))
    assert (twin.ns, twin.notes) == (1_000_000 + MEASURED_NS, ())  # nobody has tested this one


LATENCY_NS, UNSEEN_NS = 2_000_000, 5_000_000
CHARACTER_NS = LineSettings(9600).character_ns  # 1.146 ms: two intervals are longer than the latency
SLEEP_NS = STEP_MS * 1_000_000  # of a read that nothing wakes


@pytest.mark.parametrize(
    ("count", "unseen_ns", "in_time", "expected_ns"),
    [
        (1, UNSEEN_NS, True, LATENCY_NS),
        (2, UNSEEN_NS, True, LATENCY_NS + CHARACTER_NS),
        (3, UNSEEN_NS, True, LATENCY_NS + UNSEEN_NS),
        (1, UNSEEN_NS, False, LATENCY_NS + UNSEEN_NS),
        (1, SLEEP_NS + LATENCY_NS, True, LATENCY_NS),
        (1, SLEEP_NS + LATENCY_NS + 1, True, SLEEP_NS + 2 * LATENCY_NS + 1),
        (1, 10**12, False, UNCERTAINTY_UNKNOWN),
    ],
    ids=["alone", "two", "more than the latency", "there before", "a whole sleep", "stopped", "too long to be told"],
)
def test_how_long_characters_had_been_there(count: int, unseen_ns: int, in_time: bool, expected_ns: int) -> None:
    found = latency.uncertainty_ns(LATENCY_NS, LineSettings(9600), count, unseen_ns, in_time=in_time)
    assert found == expected_ns
