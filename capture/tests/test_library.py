# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap as a library: a port, a capture, a log and the virtual bus give records; a writer takes them."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import sistap
from sistap import cli, library
from sistap.sis.telegram import build

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


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo terminals")
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


@pytest.mark.parametrize("page", ["docs/library.md", "README.md"])
def test_the_program_in_the_documents(
    page: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It prints every error of a bus that has parity errors."""
    text = (Path(sistap.__file__).parent.parent / page).read_text("utf-8")
    program = text.split("```python\n")[1].split("```")[0]
    records = list(sistap.play("noise", duration_s=20))
    errors = sum(bool(flags & sistap.Flag.CHARACTER_ERROR) for record in records for flags in record.flags)
    monkeypatch.setattr(sistap, "Tap", lambda *_, **__: contextlib.nullcontext(records), raising=False)
    exec(program, {})  # noqa: S102
    assert len(capsys.readouterr().out.splitlines()) == errors > 0


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


def test_the_command_starts_without_it() -> None:
    code = "import sistap, sys; sys.exit('sistap.library' in sys.modules or not sistap.read)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_names_that_stay_the_same() -> None:
    assert sistap.__all__ == library.__all__
    page = (CAPTURE / "docs" / "library.md").read_text("utf-8")
    for name in sistap.__all__:
        assert re.search(rf"`{name}\b", page), name


def test_an_unknown_name() -> None:
    with pytest.raises(AttributeError, match="'sistap' has no attribute 'record'"):
        sistap.record  # noqa: B018
