# SPDX-License-Identifier: GPL-2.0-or-later
"""What the commands that read captures say of a log, of another tool's file, or of nothing: where to begin."""

from __future__ import annotations

import re
import shlex
import struct
from collections.abc import Callable
from pathlib import Path
from zipfile import ZipFile

import pytest
from commands import refused, run
from portable import tables
from report_capture import Sent, write
from usb_captures import USBMON, UsbPcap, ftdi, pcap

from sistap.tap.files import pcapng
from sistap.tap.files.pcapng import Interface
from sistap.tap.sis.telegram import build

COMMANDS: dict[str, object] = {
    "report": ("report", "--format", "text"),
    "parameters": ("parameters",),
    "compare": ("compare", "good.pcapng"),
    "tables": pytest.param(("tables", "-o", "t"), marks=tables),
}
READ = build(0x10, 16, 3, bytes.fromhex("3c032800"))

each_command = pytest.mark.parametrize("words", COMMANDS.values(), ids=COMMANDS)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write(tmp_path / "good.pcapng", [Sent(READ)])
    return tmp_path


def proposed(said: str) -> list[list[str]]:
    """Return the command lines of a message."""
    return [shlex.split(line)[1:] for line in re.findall("`(sistap [^`]*)`", said)]


@each_command
def test_of_a_log_a_capture_is_made_first(folder: Path, words: tuple[str, ...]) -> None:
    (folder / "press 4.log").write_text(f"12:00:00.000 TX {READ.hex(' ')}\n")
    done = run(folder, *words, "press 4.log")
    refused(done, 2, "press 4.log is not a capture")
    made = ["press 4.log", "-w", "press 4-sis.pcapng"]
    assert proposed(done.stderr) == [["annotate", *made], ["import", *made]]
    assert run(folder, *proposed(done.stderr)[0]).returncode == 0
    assert run(folder, *words, made[-1]).returncode == 0


def in_pcap(path: Path) -> Path:
    return ftdi().save(path)


def in_pcapng(path: Path) -> Path:
    """Write the same twice over, as Wireshark does: it names the interfaces first."""
    blocks = [pcapng.section_header("test", "")]
    blocks += [pcapng.interface_description(Interface(link_type, "usb")) for link_type in (USBMON, UsbPcap.link_type)]
    blocks += [pcapng.enhanced_packet(0, round(time_ms * 1e6), data) for time_ms, data in ftdi().packets]
    path.write_bytes(b"".join(blocks))
    return path


@pytest.mark.parametrize("save", [in_pcap, in_pcapng])
@each_command
def test_a_usb_capture_is_imported_first(folder: Path, words: tuple[str, ...], save: Callable[[Path], Path]) -> None:
    save(folder / "usb.cap")
    done = run(folder, *words, "usb.cap")
    refused(done, 2, "usb.cap has packets of USB alone")
    assert proposed(done.stderr) == [["import", "usb.cap", "-w", "usb-sis.pcapng"]]


@pytest.mark.parametrize(("member", "name"), [("metadata", "pulse.sr"), ("header", "a b.dsl")])
def test_a_session_of_a_logic_analyser_is_imported_first(folder: Path, member: str, name: str) -> None:
    with ZipFile(folder / name, "w") as archive:
        archive.writestr(member, "")
    done = run(folder, "report", name)
    refused(done, 2, f"{name} is a session of ")
    assert proposed(done.stderr) == [["import", name, "-w", f"{Path(name).stem}-sis.pcapng"]]


def big_endian(path: Path) -> Path:
    path.write_bytes(struct.pack(">IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 262144, USBMON))
    return path


def without_packets(path: Path) -> Path:
    path.write_bytes(pcapng.section_header("test", "") + pcapng.interface_description(Interface(USBMON, "usb")))
    return path


EMPTY: dict[str, Callable[[Path], object]] = {
    "nothing": lambda path: path.write_bytes(b""),
    "pcapng": without_packets,
    "pcap": lambda path: pcap(path, USBMON, []),
    "pcap of the other order": big_endian,
}


@pytest.mark.parametrize("save", EMPTY.values(), ids=EMPTY)
@each_command
def test_an_empty_capture_is_called_empty(folder: Path, words: tuple[str, ...], save: Callable[[Path], object]) -> None:
    save(folder / "empty.cap")
    done = run(folder, *words, "empty.cap")
    assert done.returncode == 0
    assert done.stderr.startswith("sistap: empty.cap has no packets\n")
