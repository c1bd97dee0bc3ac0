# SPDX-License-Identifier: GPL-2.0-or-later
"""The page and hostile files: what they are named, what is in them, and what they do to a worker."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from recordings import session
from report_capture import Sent, write

from chromium import Chromium
from make import HERE as CAPTURES
from sistap.tap.files import pcapng
from sistap.tap.line.settings import LineSettings
from sistap.tap.records.record import Event, event
from sistap.tap.sis.telegram import build

PAGE = Path(__file__).parent
IMAGE = "<img src=x onerror=alert(1)>"
FORMULAS = ['=HYPERLINK("x")', "@SUM(1)", "-1+1|cmd", "+1+cmd|' /C calc'!A0", "\t=1", "\r=1"]
HONEST = ["-12.5 mm/min", "+1", "-3e-05", "-40 °C", "S-0-0036", "", "3 - 2"]
TROUBLE = "document.querySelector('#trouble').textContent"
TOO_MUCH = (
    "This needs more memory than a page has. Cut the capture into parts of 100,000 packets, as editcap -c 100000 does, "
    "and open one of them; or open it in Wireshark itself"
)
DAMAGED = "This file is damaged, and Wireshark in this page cannot go on with it: open it in Wireshark itself"


def ran(*words: str) -> Any:
    """Run a script that needs no package."""
    if shutil.which("node") is None:
        pytest.skip("needs node")
    done = subprocess.run(["node", *words], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def found() -> Any:
    return ran(str(PAGE / "test" / "hostile.mjs"), json.dumps(FORMULAS + HONEST))


@pytest.mark.attack("page: a packet block that is shorter than its head", "Wireshark says what is wrong")
def test_cut_packets(found: dict[str, Any]) -> None:
    assert found["cut"] == [False] * 5


@pytest.mark.attack("page: 60 MB of packets with 4 bytes", "read with less than 32 MB of memory more")
def test_tiny_packets() -> None:
    assert ran("--max-old-space-size=32", str(PAGE / "test" / "tiny.mjs")) == 3_000_000


@pytest.mark.attack("page: a file named like those that its commands write, like an option or a path", "another name")
def test_names_of_files(found: dict[str, Any]) -> None:
    """What they write begins with a point."""
    assert found["names"] == ["_log.pcapng", "_changes.csv", "_w.txt", "__.._x", "_", "_img src_x_.log", "file"]


@pytest.mark.attack("page: control characters and Unicode direction marks in names of files", "visible escapes")
def test_names_that_are_shown(found: dict[str, Any]) -> None:
    assert found["shown"] == [r"a\u202eb\u000a\u001b\ufeff\ue0001\u00a0c", "Presse läuft 3.pcapng"]


@pytest.mark.attack("page: a cell of ten million characters", "read")
def test_a_long_cell(found: dict[str, Any]) -> None:
    assert found["long"] == 10_000_000


def test_what_a_table_was_is_what_it_is_read_as(found: dict[str, Any]) -> None:
    assert found["read"] == [FORMULAS + HONEST, ['say "no"', "a,b", "two\r\nlines", "x"]]


@pytest.mark.attack("page: a cell of a table like a formula of a spreadsheet", "a ' before it makes it text in CSV")
def test_no_cell_is_a_formula(found: dict[str, Any]) -> None:
    formulas = ['"\'=HYPERLINK(""x"")"', "'@SUM(1)", "'-1+1|cmd", "'+1+cmd|' /C calc'!A0", "'\t=1", '"\'\r=1"']
    assert found["csv"] == ",".join(formulas + HONEST) + "\r\n"


@pytest.mark.attack(
    "page: a capture breaks a Wireshark or sistap down", "another one takes its place; no call waits for ever"
)
def test_a_worker_that_breaks_down(found: dict[str, Any]) -> None:
    for name, words, text in (
        ("broken", TOO_MUCH, "Aborted(OOM)"),
        ("stack", DAMAGED, "Maximum call stack size exceeded"),
        ("sistap", TOO_MUCH, "RuntimeError: Aborted(OOM)"),
        ("memory", TOO_MUCH, "MemoryError"),
    ):
        said = f"{words} ({text})"
        assert found[name] == {"said": said, "later": [said, "stopped"], "told": 1}
    assert found["refused"] == {"said": "Array buffer allocation failed", "later": [], "told": 0}


@pytest.fixture
def chromium(window: Chromium, page: Path) -> Chromium:
    window.before(
        "window.workers = [];"
        "window.Worker = class extends Worker { constructor(...all) { super(...all); workers.push(this); } }"
    )
    window.open(page.as_uri())
    window.until("document.documentElement.dataset.ready")
    return window


def changes(name: bytes) -> list[Sent]:
    """Make telegrams that read the name of a parameter and write it twice."""
    sent = [build(0x10, 16, 3, b"\x14\x05\0\0\0"), build(0x10, 16, 3, b"\0\x14\x05" + name, reaction=True)]
    for value in (1, 2):
        sent += [
            build(0x1F, 16, 3, bytes([0x3C, 5, 0, 0, 0, value, 0])),
            build(0x1F, 16, 3, b"\0\x3c\x05", reaction=True),
        ]
    return [Sent(telegram) for telegram in sent]


def is_text(browser: Chromium, text: str) -> bool:
    assert browser.run("document.querySelector('img, [onerror]')") is None
    return bool(browser.run(f"document.body.textContent.includes({json.dumps(text)})"))


@pytest.mark.thorough
@pytest.mark.attack("page: HTML in names of files, captures, logs and channels", "shown as text; nothing runs")
def test_html(chromium: Chromium, tmp_path: Path) -> None:
    name = f"{IMAGE}.pcapng"
    marker = event(0, 0, LineSettings(), Event.MARKER, IMAGE)
    (tmp_path / name).write_bytes(
        pcapng.section_header(IMAGE, IMAGE)
        + pcapng.interface_description(pcapng.Interface(pcapng.LINKTYPE_WIRESHARK_UPPER_PDU, IMAGE, IMAGE))
        + pcapng.enhanced_packet(0, 0, pcapng.upper_pdu("sertap", marker.pack()))
    )
    chromium.choose("#chooser", tmp_path / name)
    chromium.until("document.querySelector('.tree li') && !document.querySelector('section.packets').hidden")
    assert is_text(chromium, IMAGE)
    for view in ("findings", "statistics", "packets"):
        chromium.run(f"location.hash = '#{view}'")
        chromium.until("document.querySelector('#busy').hidden")
        assert is_text(chromium, IMAGE) and not chromium.run(TROUBLE)
    log = tmp_path / f"{IMAGE}.log"
    log.write_text(f"{IMAGE}\n16.03.2026 09:00:00 {IMAGE} {build(0x12, 16, 3).hex(' ')}\n{IMAGE}\n")
    chromium.choose("#chooser", log)
    chromium.until("document.querySelector('.log-line') && document.querySelector('.answer-bar a')")
    assert is_text(chromium, f"{IMAGE}.log")
    chromium.run("location.hash = '#answer'")
    assert is_text(chromium, f"{IMAGE}.log")
    session(tmp_path / f"{IMAGE}.sr", IMAGE)
    chromium.choose("#chooser", tmp_path / f"{IMAGE}.sr")
    chromium.until("document.title.endsWith('.sr - SIS') && document.querySelector('.note')")
    chromium.until("document.querySelector('.answer-bar a')")
    assert is_text(chromium, f"{IMAGE}.sr") and is_text(chromium, f": {IMAGE}; 9600")


@pytest.mark.thorough
@pytest.mark.attack("page: hostile names in Compare and Changes", "shown as text, each in its own cell")
def test_names_in_tables(chromium: Chromium, tmp_path: Path) -> None:
    """One capture is named like the file that a command writes, the other one turns the direction of writing."""
    name = f"={IMAGE}|1|\r\n\r\n"
    captures = [
        write(tmp_path / named, changes(name.encode())) for named in ("compared.html", f"a\u202e{IMAGE}\n.pcapng")
    ]
    chromium.choose("#chooser", captures[0])
    chromium.until("location.hash === '#packets'")
    for view, there in (
        ("changes", "document.querySelector('[aria-label=Changes] td')"),
        ("compare", "document.querySelector('[title=Comparison]').srcdoc"),
    ):
        chromium.run(f"location.hash = '#{view}'")
        if view == "compare":
            chromium.choose("#other", captures[1])
        chromium.until(f"{there} || {TROUBLE}")
        chromium.until("document.querySelector('#busy').hidden")
        assert is_text(chromium, IMAGE) and not chromium.run(TROUBLE)
    said = chromium.run("document.querySelector('[aria-labelledby=compare-title] [role=status]').textContent")
    assert said == f"Good: a\\u202e{IMAGE}\\u000a.pcapng. Bad: compared.html."


@pytest.mark.thorough
def test_a_wireshark_that_breaks_down_loses_no_capture(chromium: Chromium) -> None:
    """The next one opens it again; and another file after it."""

    def opened(name: str) -> None:
        chromium.choose("#chooser", CAPTURES / name)
        chromium.until(f"document.title === '{name} - SIS' && location.hash === '#packets'")
        chromium.until("document.querySelector('.tree li')")

    opened("specification.pcapng")
    chromium.run("workers[0].onmessage({ data: { id: 1, error: 'x', isBroken: true } })")  # it has no such call
    chromium.run("before = workers.length")
    chromium.run("workers[0].onerror({ preventDefault() {}, message: 'out of memory' })")
    chromium.until("workers.length > before && document.querySelector('#busy').hidden")
    chromium.until("document.querySelector('.tree li') && document.querySelector('.row.selected')")
    assert chromium.run("[location.hash, document.title]") == ["#packets", "specification.pcapng - SIS"]
    opened("routes.pcapng")


@pytest.mark.thorough
def test_a_page_that_is_cut_off(window: Chromium, page: Path, tmp_path: Path) -> None:
    half = tmp_path / "sis.html"
    half.write_bytes(page.read_bytes()[: page.stat().st_size // 2])
    window.open(half.as_uri())
    window.until("document.querySelector('#trouble').textContent")
    said = window.run("document.querySelector('#trouble').textContent")
    assert said == "This page is cut off: copy its file once more"
    window.complaints.clear()  # of what is cut in two
