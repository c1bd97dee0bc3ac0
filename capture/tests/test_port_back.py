# SPDX-License-Identifier: GPL-2.0-or-later
"""`--wait-for-port`: the adapter is plugged in late, unplugged, and back; the capture continues by itself."""

from __future__ import annotations

import gc
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
from independent import records
from specification import TELEGRAMS

from sistap.tap.capture.options import CaptureOptions
from sistap.tap.capture.running import Ports
from sistap.tap.line.reader import PortError, open_reader
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Event, Type

sys.path.append(str(Path(__file__).parent.parent / "benchmark"))  # behind: its tables.py is not that of test-captures

from plugged import Adapter  # noqa: E402

pytestmark = pytest.mark.tap

PATIENCE_S = 60
COMMAND, REACTION = TELEGRAMS["8-20"], TELEGRAMS["8-21"]


class Tap:
    """A running capture, and its output so far."""

    def __init__(self, arguments: Sequence[str], folder: Path) -> None:
        self.said = folder / "said"
        with self.said.open("wb") as errors:
            command = [sys.executable, "-m", "sistap", "capture", "--wait-for-port", *arguments]
            self.process = subprocess.Popen(command, stderr=errors)

    def wait_for(self, happens: Callable[[], bool]) -> None:
        end_s = time.monotonic() + PATIENCE_S
        while not happens():
            assert time.monotonic() < end_s and self.process.poll() is None, self.said.read_text()
            time.sleep(0.01)

    def wait_until_said(self, text: str, times: int = 1) -> None:
        self.wait_for(lambda: self.said.read_text().count(text) >= times)

    def stop(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(PATIENCE_S)


@pytest.fixture
def adapters(tmp_path: Path) -> Iterator[list[Adapter]]:
    made = [Adapter(tmp_path / f"adapter{number}") for number in (1, 2)]
    yield made
    for adapter in made:
        adapter.unplug()


@pytest.fixture
def tap(tmp_path: Path) -> Iterator[Callable[..., Tap]]:
    made: list[Tap] = []

    def start(*arguments: str) -> Tap:
        made.append(Tap(arguments, tmp_path))
        return made[-1]

    yield start
    for one in made:
        one.process.kill()
        one.process.wait()


def frames(path: Path) -> list[tuple[int, bytes]]:
    return [(record.line, record.data) for record in records(path) if record.type == Type.FRAME]


def events(path: Path) -> list[tuple[int, int]]:
    return [(record.line, record.event) for record in records(path) if record.type == Type.EVENT]


@pytest.mark.thorough
def test_a_port_that_goes_and_comes(adapters: list[Adapter], tap: Callable[..., Tap], tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    adapter = adapters[0]
    capture = tap("-i", str(adapter.name), "-w", str(path))
    capture.wait_until_said("does not exist: `sistap ports` lists the ports there are. Waiting for it\n")
    adapter.plug()
    capture.wait_until_said("capturing on ")
    adapter.send(COMMAND)
    capture.wait_for(lambda: len(frames(path)) == 1)
    for number in (1, 2):
        adapter.unplug()
        capture.wait_until_said(". Waiting until it is back\n", number)
        adapter.plug()
        capture.wait_until_said(" is back after ", number)
        adapter.send(REACTION)
        capture.wait_for(lambda number=number: len(frames(path)) == 1 + number)  # type: ignore[misc]
    assert capture.stop() == 0
    assert frames(path) == [(0, COMMAND), (0, REACTION), (0, REACTION)]
    gone = [(0, Event.ADAPTER_LOST), (0, Event.CHARACTERS_LOST)]
    assert events(path) == [(0, Event.CAPTURE_STARTED), *gone, *gone]
    assert capture.said.read_text().count("Waiting for it") == 1


def test_one_of_two_ports_goes_and_comes(adapters: list[Adapter], tap: Callable[..., Tap], tmp_path: Path) -> None:
    path = tmp_path / "x.pcapng"
    first, second = adapters
    first.plug()
    second.plug()
    capture = tap("-i", str(first.name), "-i", str(second.name), "-w", str(path))
    capture.wait_until_said("capturing on ", 2)
    second.unplug()
    capture.wait_until_said(". Waiting until it is back\n")
    first.send(COMMAND)
    capture.wait_for(lambda: len(frames(path)) == 1)
    second.plug()
    capture.wait_until_said("line 2: ", 3)
    second.send(REACTION)
    first.send(COMMAND)
    capture.wait_for(lambda: len(frames(path)) == 3)
    assert capture.stop() == 0
    assert sorted(frames(path)) == [(1, COMMAND), (1, COMMAND), (2, REACTION)]
    assert events(path)[2:] == [(2, Event.ADAPTER_LOST), (2, Event.CHARACTERS_LOST)]


def test_a_stop_does_not_wait_for_a_port(adapters: list[Adapter], tap: Callable[..., Tap], tmp_path: Path) -> None:
    capture = tap("-i", str(adapters[0].name), "-w", str(tmp_path / "x"))
    capture.wait_until_said("Waiting for it")
    assert capture.stop() == 0
    assert not (tmp_path / "x").exists()


def test_a_stop_does_not_wait_for_a_port_that_was_lost(
    adapters: list[Adapter], tap: Callable[..., Tap], tmp_path: Path
) -> None:
    adapters[0].plug()
    capture = tap("-i", str(adapters[0].name), "-w", str(tmp_path / "x"))
    capture.wait_until_said("capturing on ")
    adapters[0].unplug()
    capture.wait_until_said("Waiting until it is back")
    assert capture.stop() == 0


@pytest.mark.thorough
@pytest.mark.parametrize("port", ["{}/missing", "bus://{}/missing", "socket://127.0.0.1:1", "rfc2217://127.0.0.1:1"])
def test_waiting_for_months_leaves_no_garbage(tmp_path: Path, port: str) -> None:
    """A capture collects none, and tries every second."""
    settings = LineSettings()
    gc.collect()
    gc.disable()
    try:
        for attempt in range(4):
            with pytest.raises(PortError):
                open_reader(port.format(tmp_path), settings)
            if attempt == 0:  # which has imported something
                gc.collect()
        assert gc.collect() == 0
    finally:
        gc.enable()


def test_a_port_that_goes_and_comes_leaves_no_garbage(adapters: list[Adapter]) -> None:
    adapters[0].plug()
    ports = Ports(CaptureOptions(ports=(str(adapters[0].name),)))
    (reader,) = ports.open(LineSettings(), pytest.fail)
    gc.collect()
    gc.disable()
    try:
        for _ in range(3):
            adapters[0].unplug()
            adapters[0].plug()
            reader = ports.reopen(reader, LineSettings())
        assert gc.collect() == 0
    finally:
        gc.enable()
        ports.close()
