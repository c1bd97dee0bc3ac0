# SPDX-License-Identifier: GPL-2.0-or-later
"""The page listens at serial ports: a pseudo terminal feeds one in place of the browser's."""

from __future__ import annotations

import os
import select
import struct
import subprocess
import sys
import time
import tty
from base64 import b64encode
from pathlib import Path

import pytest

from chromium import Chromium
from parity import SCRIPT
from sistap.dissected.captures.reading import records
from sistap.tap.line.settings import Flag
from sistap.tap.records.record import Event, Record, Type

HERE = Path(__file__).parent
SECONDS = float(os.environ.get("SIS_PAGE_SECONDS", "12"))  # of each line; what README.md says is of 600
CHARACTER = struct.Struct("<BQQ")
STEPS_NS = 200_000  # of the browser's clock

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(180 + 3 * SECONDS)]


@pytest.fixture
def chromium(window: Chromium, page: Path, tmp_path: Path) -> Chromium:
    window.before((HERE / "test" / "serial.js").read_text())
    window.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    window.open(page.as_uri() + "#listen")
    window.until("document.documentElement.dataset.ready")
    return window


def listen(browser: Chromium, rate: str, ports: int = 1) -> None:
    browser.click("Choose a port")
    browser.until("serialTest.ports.length === 1")
    if ports == 2:
        browser.run(
            "[...document.querySelectorAll('button')].find((one) => /second port/.test(one.textContent)).click()"
        )
        browser.until("serialTest.ports.length === 2")
    browser.run(f"document.querySelector('#rate').value = '{rate}'")
    browser.click("Listen")
    browser.until(f"document.querySelector('.live-bar') && serialTest.opened.length === {ports}")


def feed(browser: Chromium, data: bytes, port: int = 0) -> None:
    browser.run(f"serialTest.ports[{port}].feed('{b64encode(data).decode()}')")


def stop(browser: Chromium, folder: Path) -> list[Record]:
    """Stop, save the capture, and return its records."""
    browser.run("[...document.querySelectorAll('.live-bar button')].at(-1)?.click()")
    browser.until("!document.querySelector('.live-bar') && document.querySelector('#busy').hidden")
    browser.until("[...document.querySelectorAll('button')].some((one) => one.textContent === 'Export')")
    browser.click("Export")
    browser.click("The whole capture")
    while not (files := list(folder.glob("*.pcapng"))):
        select.select([], [], [], 0.05)
    assert browser.run("serialTest.writes") == 0
    assert browser.run("serialTest.signals[0]") == {"dataTerminalReady": False, "requestToSend": False}
    return list(records(files[0]))


def characters(found: list[Record]) -> list[tuple[int, int, int]]:
    """Return value, latest time and earliest time of each character."""
    result = []
    for record in found:
        if record.type == Type.EVENT:
            continue
        times = [record.time_ns]
        for interval in record.intervals[1:]:
            times.append(times[-1] + interval)
        behind = 0  # characters of the same read that follow
        earliest = []
        for time_ns, flags in zip(reversed(times), reversed(record.flags), strict=True):
            earliest.append(time_ns - record.uncertainty_ns - behind * record.settings.character_ns)
            behind = behind + 1 if flags & Flag.SAME_READ else 0
        result += list(zip(record.data, times, reversed(earliest), strict=True))
    return result


def play(browser: Chromium, baud: int, log: Path) -> list[int]:
    """Feed the port from a pseudo terminal until its bus ends. Return when each character was handed over."""
    handed_ns: list[int] = []
    command = [sys.executable, str(HERE / "test" / "feeder.py"), str(baud), str(SECONDS), str(log)]
    environment = {**os.environ, "PYTHONPATH": str(SCRIPT.parents[1] / "capture")}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, text=True, env=environment, stdin=pipe, stdout=pipe) as feeder:
        assert feeder.stdin
        assert feeder.stdout
        terminal = os.open(feeder.stdout.readline().strip(), os.O_RDWR | os.O_NOCTTY)
        tty.setraw(terminal)
        count, expected = 0, -1
        while count != expected:
            ready = select.select([terminal, *([] if expected >= 0 else [feeder.stdout])], [], [])[0]
            if terminal in ready:
                data = os.read(terminal, 4096)
                handed_ns += [time.time_ns()] * len(data)
                feed(browser, data)
                count += len(data)
            else:
                expected = int(feeder.stdout.readline())
        feeder.stdin.close()
        os.close(terminal)
    return handed_ns


@pytest.mark.parametrize("baud", [9600, 115200])
def test_every_character_and_its_time(baud: int, chromium: Chromium, tmp_path: Path) -> None:
    listen(chromium, str(baud))
    log = tmp_path / "log"
    handed_ns = play(chromium, baud, log)
    found = stop(chromium, tmp_path)
    sent = list(CHARACTER.iter_unpack(log.read_bytes()))
    heard = characters(found)
    assert [value for value, *_ in heard] == [value for value, *_ in sent]
    assert len(sent) > 20 * SECONDS
    # A busy computer runs this test late, too: then a character is handed over long after the terminal had it.
    at_the_port = [
        (before_ns, max(after_ns, late_ns)) for (_, before_ns, after_ns), late_ns in zip(sent, handed_ns, strict=True)
    ]
    wrong = [
        (before_ns - latest_ns, earliest_ns - after_ns)
        for (before_ns, after_ns), (_, latest_ns, earliest_ns) in zip(at_the_port, heard, strict=True)
        if before_ns > latest_ns + STEPS_NS or after_ns < earliest_ns - STEPS_NS
    ]
    bounds = sorted(record.uncertainty_ns / 1e6 for record in found if record.type != Type.EVENT)
    print(
        f"{baud} Bd: {len(sent)} characters, {len(wrong)} outside of their bound; "
        f"bound {bounds[len(bounds) // 2]:.1f} ms, longest {bounds[-1]:.1f} ms; {sorted(wrong)[-3:]}"
    )
    assert len(wrong) <= len(sent) // 1000


def test_the_rate_is_found(chromium: Chromium, tmp_path: Path) -> None:
    """As `sistap capture --baud auto` does: wrong characters, then the next rate."""
    listen(chromium, "auto")
    for _ in range(30):
        feed(chromium, bytes(range(0x80, 0x94)))
    chromium.until("serialTest.opened.length > 1")
    feed(chromium, bytes.fromhex("02 D9 00 00 00 12 10 03"))
    chromium.until("/found, by a valid telegram/.test(document.querySelector('.live-bar').textContent)")
    opened = chromium.run("serialTest.opened.map(({ baudRate, parity }) => [baudRate, parity])")
    assert opened == [[9600, "even"], [9600, "none"]]
    found = stop(chromium, tmp_path)
    assert [record.settings.format for record in found if record.type == Type.FRAME] == ["8N1"]


def test_errors_are_somewhere_in_their_read(chromium: Chromium, tmp_path: Path) -> None:
    """Which character it was, the browser does not say."""
    telegram = bytes.fromhex("02 D9 00 00 00 12 10 03")
    listen(chromium, "9600")
    feed(chromium, telegram)
    for name in ("ParityError", "FramingError", "BreakError"):
        chromium.run(f"serialTest.ports[0].fail('{name}')")
        feed(chromium, telegram)
    chromium.run("serialTest.ports[0].fail('BufferOverrunError')")
    feed(chromium, telegram)
    frames = [record for record in stop(chromium, tmp_path) if record.type == Type.FRAME]
    somewhere, lost = Flag.UNLOCATED_ERROR, Flag.LOST_BEFORE
    assert [record.errors for record in frames] == [Flag(0), somewhere, somewhere, somewhere, lost]
    assert all(record.data == telegram for record in frames)


def test_unplugged_in_the_middle(chromium: Chromium, tmp_path: Path) -> None:
    """What came is kept, and the capture ends by itself."""
    listen(chromium, "19200")
    feed(chromium, bytes.fromhex("02 D9 00 00"))
    chromium.run("serialTest.ports[0].fail('NetworkError')")
    chromium.until("!document.querySelector('.live-bar')")
    *_, rest, gone = stop(chromium, tmp_path)
    assert (rest.type, rest.data) == (Type.OTHER, bytes.fromhex("02 D9 00 00"))
    assert gone.event == Event.ADAPTER_LOST


def test_two_ports_are_two_directions(chromium: Chromium, tmp_path: Path) -> None:
    listen(chromium, "9600", ports=2)
    feed(chromium, bytes.fromhex("02 D9 00 00 00 12 10 03"), port=0)
    feed(chromium, bytes.fromhex("02 C3 02 02 10 12 10 03 00 02"), port=1)
    frames = [record for record in stop(chromium, tmp_path) if record.type == Type.FRAME]
    assert [record.line for record in frames] == [1, 2]


def test_what_was_heard_survives_the_page(chromium: Chromium, page: Path) -> None:
    """The browser asks before it closes the page. If it does not, the next page offers what came."""
    asks = "dispatchEvent(new Event('beforeunload', {cancelable: true}))"  # false: the browser has to ask
    chromium.run("""(() => {
      const release = async () => (globalThis.isAwake = false);
      navigator.wakeLock.request = async () => (globalThis.isAwake = true, {release});
    })()""")
    assert chromium.run(asks) is True
    listen(chromium, "9600")
    assert chromium.run("isAwake") is True
    assert chromium.run(asks) is False
    feed(chromium, bytes.fromhex("02 D9 00 00 00 12 10 03"))
    feed(chromium, bytes.fromhex("02 C3 02 02 10 12 10 03 00 02"))
    chromium.until("/phase 2/.test(document.querySelector('.packet-list').textContent)")
    time.sleep(4)  # what is heard is written every 2 s
    chromium.open(page.as_uri() + "?again")
    chromium.complaints.clear()  # it asks only somebody who has clicked
    chromium.until("document.querySelector('.left')")
    assert "the page was closed while it listened" in chromium.run("document.querySelector('.left').textContent")
    chromium.click("Open")
    chromium.until("/phase 2/.test(document.querySelector('.packet-list').textContent)")
    chromium.run("location.hash = '#open'")
    chromium.click("Delete")
    chromium.until("!document.querySelector('.left')")
    chromium.open(page.as_uri() + "?third")
    chromium.until("document.documentElement.dataset.ready")
    assert not chromium.run("document.querySelector('.left')")


def test_a_capture_that_was_ended_is_not_offered(chromium: Chromium, page: Path, tmp_path: Path) -> None:
    listen(chromium, "9600")
    feed(chromium, bytes.fromhex("02 D9 00 00 00 12 10 03"))
    assert [record.type for record in stop(chromium, tmp_path)].count(Type.FRAME) == 1
    chromium.open(page.as_uri() + "?again")
    chromium.until("document.documentElement.dataset.ready")
    assert not chromium.run("document.querySelector('.left')")


FULL_DISK = """showSaveFilePicker = async () => ({createWritable: async () => ({
  async write() { if (globalThis.isFull) throw new DOMException('no space', 'QuotaExceededError'); },
  async close() {},
})})"""
FULL_STORAGE = """{
  const add = IDBObjectStore.prototype.add;
  IDBObjectStore.prototype.add = function (value, key) {
    if (globalThis.isFull) throw new DOMException('no space', 'QuotaExceededError');
    return add.call(this, value, key);
  };
}"""


@pytest.mark.parametrize(
    ("full", "into_file", "said"),
    [
        (FULL_DISK, "true", "The file cannot be written: no space. Listening has ended."),
        (FULL_STORAGE, "false", "The browser has no more room for what is heard. Listening has ended"),
    ],
    ids=["disk", "storage"],
)
def test_where_nothing_more_can_be_written(full: str, into_file: str, said: str, chromium: Chromium) -> None:
    """Listening ends, the cause is said, and what came is open."""
    chromium.run(f"{full}; 0")
    chromium.run(f"document.querySelector('#into-file').checked = {into_file}")
    listen(chromium, "9600")
    feed(chromium, bytes.fromhex("02 D9 00 00 00 12 10 03"))
    shown = "document.querySelector('.packet-list').textContent.includes('Read phase')"
    chromium.until(shown)
    chromium.run("globalThis.isFull = true")
    feed(chromium, bytes.fromhex("02 D9 00 00 00 12 10 03"))
    chromium.until("!document.querySelector('.live-bar') && document.querySelector('#trouble').textContent")
    assert said in chromium.run("document.querySelector('#trouble').textContent")
    chromium.until(shown)
