# SPDX-License-Identifier: GPL-2.0-or-later
"""What people open and paste in the page: files with nothing in them, telegrams in other words, logs without an end."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from chromium import Chromium
from make import HERE as CAPTURES
from sistap.tap.files import pcapng

pytestmark = [pytest.mark.thorough, pytest.mark.timeout(600)]

MODBUS = bytes.fromhex("00 01 00 00 00 06 01 03 00 00 00 01")
TROUBLE = "document.querySelector('#trouble').textContent"
NOTE = "(document.querySelector('.packets .note')?.textContent ?? '')"
TREE = "document.querySelector('.tree').textContent"
LIST = "document.querySelector('.packet-list .rows').textContent"


def choose(browser: Chromium, file: Path) -> None:
    """Choose a file, and wait until the page has done with it."""
    browser.run("location.hash = '#open'")
    browser.until("!document.querySelector('section.start').hidden")
    browser.choose("#chooser", file)
    browser.until(f"document.title.startsWith({file.name!r}) && location.hash === '#packets' || {TROUBLE}")
    browser.until("document.querySelector('#busy').hidden")


def network(*payloads: bytes, port: int = 502) -> bytes:
    """Make a capture (pcap) of segments of TCP; Modbus has port 502."""
    blocks = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)]
    sequence = 1
    for second, payload in enumerate(payloads):
        tcp = struct.pack(">HHIIBBHHH", 50000, port, sequence, 1, 0x50, 0x18, 1000, 0, 0) + payload
        ip = struct.pack(">BBHHHBBHII", 0x45, 0, 20 + len(tcp), 1, 0, 64, 6, 0, 0x0A000001, 0x0A000002)
        frame = bytes(12) + b"\x08\x00" + ip + tcp
        blocks.append(struct.pack("<IIII", second, 0, len(frame), len(frame)) + frame)
        sequence += len(payload)
    return b"".join(blocks)


EMPTY = pcapng.section_header("x", "x") + pcapng.interface_description(pcapng.Interface(1, "x", "x"))


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("nothing.pcapng", b"", "nothing.pcapng is empty."),
        ("zeros.bin", bytes(5000), "zeros.bin has 5,000 bytes, and each is 0"),
        ("blank.log", b"\r\n \t\n", "blank.log has nothing but blanks"),
        ("picture.png", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 9, "picture.png is no capture, no text"),
    ],
    ids=["empty", "zeros", "blank", "picture"],
)
def test_a_file_with_nothing_in_it(name: str, data: bytes, said: str, chromium: Chromium, tmp_path: Path) -> None:
    """Nobody is asked for the pattern of its lines."""
    (tmp_path / name).write_bytes(data)
    choose(chromium, tmp_path / name)
    assert chromium.run(TROUBLE).startswith(said)
    assert chromium.run("document.querySelector('dialog[open]')") is None


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (EMPTY, "x.pcapng is a capture without packets"),
        (network(MODBUS, MODBUS), "x.pcapng has 2 packets, but no SIS."),
    ],
    ids=["empty", "modbus"],
)
def test_a_capture_without_sis(data: bytes, said: str, chromium: Chromium, tmp_path: Path) -> None:
    """The next capture is not told the same."""
    (tmp_path / "x.pcapng").write_bytes(data)
    choose(chromium, tmp_path / "x.pcapng")
    assert chromium.run(NOTE).startswith(said)
    for name in ("tcp.pcapng", "ascii.pcapng", "synaxobj.pcapng"):
        choose(chromium, CAPTURES / name)
        assert chromium.run(NOTE) == "", name


def test_sis_that_comes_late(chromium: Chromium, tmp_path: Path) -> None:
    """Not one of the first packets is of it."""
    foreign, ours = network(*[MODBUS] * 99), network(bytes.fromhex("02 D9 00 00 00 12 10 03"), port=4001)
    (tmp_path / "x.pcap").write_bytes(foreign + ours[24:])
    choose(chromium, tmp_path / "x.pcap")
    assert chromium.run(NOTE) == ""
    chromium.run("document.querySelector('.packet-list').focus()")
    chromium.press("End", 35)
    chromium.until(f"{TREE}.includes('Checksum: 0xd9 [correct]')")


def paste(browser: Chromium, text: str) -> None:
    browser.run("location.hash = '#open'")
    browser.until("!document.querySelector('section.start').hidden")
    browser.run("document.querySelector('#pasted').value = ''; document.querySelector('#pasted').focus()")
    browser.type(text)
    browser.click("Decode")
    browser.until(f"location.hash === '#packets' && document.querySelector('.packet-list .row.selected') || {TROUBLE}")
    browser.until("document.querySelector('#busy').hidden")


def test_telegrams_as_people_have_them(chromium: Chromium) -> None:
    """The bytes light up in what was pasted."""
    for text, said in {
        "02_D9_00_00_00_12_10_03": "",
        "STX D9 NUL NUL NUL DC2 DLE ETX": "bytes: hexadecimal with names of control characters.",
        "AtkAAAASEAM=": "bytes: base64.",
        "０２ Ｄ９ ００ ００ ００ １２ １０ ０３": "",
    }.items():
        paste(chromium, text)
        chromium.until(f"document.querySelector('.log-line b.chosen')?.textContent === {text.rstrip('=')!r}")
        assert "Checksum: 0xd9 [correct]" in chromium.run(TREE)
        assert chromium.run(NOTE) == said


def test_a_telegram_that_is_cut_when_it_is_pasted(chromium: Chromium) -> None:
    """As the last of several, too."""
    paste(chromium, "02 C3 02 02 10 12 10 03 00")
    assert "[cut: 9 of 10 bytes]" in chromium.run(LIST)
    assert "Sender address: 16" in chromium.run(TREE)
    assert chromium.run(NOTE).startswith("There is no right telegram of SIS in 9 bytes")
    paste(chromium, "02 D9 00 00 00 12 10 03\n02 C3 02 02 10 12 10 03 00")
    assert chromium.run(NOTE) == ""
    chromium.run("document.querySelector('.packet-list').focus()")
    chromium.press("End", 35)
    chromium.until(f"{TREE}.startsWith('Frame 3:')")
    assert "[cut: 9 of 10 bytes]" in chromium.run(LIST)
    paste(chromium, "hello")
    assert chromium.run(TROUBLE).startswith("There are no bytes in this text: paste them in hexadecimal")


def long_log(count: int, of: int) -> str:
    """Return a log in which each of so many lines has a telegram."""
    lines = ["idle"] * count
    for number in range(0, count, of):
        lines[number] = f"{number // 3600:02}:{number // 60 % 60:02}:{number % 60:02}.000 02 D9 00 00 00 12 10 03"
    return "".join(f"{line}\n" for line in lines)


def test_a_log_of_half_a_million_lines(chromium: Chromium, tmp_path: Path) -> None:
    """It has more lines than a browser has pixels; the first, the last, and those between can be seen and clicked."""
    (tmp_path / "long.log").write_text(long_log(500_000, 10_000))
    chromium.run("location.hash = '#open'")
    chromium.choose("#chooser", tmp_path / "long.log")
    chromium.until("location.hash === '#packets' && document.querySelector('.log-line b.chosen')", timeout_s=400)
    assert chromium.run("document.querySelector('.log-body').offsetHeight") <= 8_000_000
    line = "document.querySelector('.log-line b.chosen').parentNode.querySelector('i').textContent"
    assert chromium.run(line) == "1"
    chromium.run("document.querySelector('.packet-list').focus()")
    chromium.press("End", 35)
    chromium.until(f"document.querySelector('.log-line b.chosen') && {line} === '490001'")
    box = "document.querySelector('.log-line b.chosen').getBoundingClientRect()"
    assert chromium.run(f"document.elementFromPoint({box}.x + 2, {box}.y + 9).className") == "chosen"
    chromium.run("document.querySelector('.log').scrollTop = 1e9")
    chromium.until("[...document.querySelectorAll('.log-line i')].at(-1).textContent === '500000'")


def test_follow_shows_its_progress_and_can_be_cancelled(chromium: Chromium) -> None:
    choose(chromium, CAPTURES / "course" / "07-silence.pcapng")
    chromium.run(
        "new MutationObserver(() => { const bar = document.querySelector('#busy progress');"
        "if (bar?.value > 0.1 && document.querySelector('.follow').children.length) globalThis.seen ??= bar.value,"
        "document.querySelector('#busy button')?.click(); })"
        ".observe(document.querySelector('#busy'), {subtree: true, attributes: true, childList: true})"
    )
    chromium.click("Follow")
    chromium.until("globalThis.seen && document.querySelector('#busy').hidden")
    bar = "document.querySelector('[aria-labelledby=follow-title] p').textContent"
    chromium.until(f"/Cancelled after \\d+/.test({bar})")
    count = chromium.run("document.querySelector('.follow').children.length")
    assert 0 < count < 100
    assert f"Cancelled after {count}." in chromium.run(bar)
