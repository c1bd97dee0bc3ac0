# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures of real drivers through `sistap import`: every character is the one that was sent."""

from __future__ import annotations

from pathlib import Path

import pytest
from imported import Imported, run
from real_captures import truth, unpacked

from sistap.tap.line.settings import ERROR_FLAGS, Flag, LineSettings

SHARED, RECEIVED, SENT = 0, 1, 2
BREAK, SOMEWHERE, LOST = int(Flag.BREAK), int(Flag.UNLOCATED_ERROR), int(Flag.LOST_BEFORE)


def characters(done: Imported, line: int) -> bytes:
    return b"".join(record.data for record in done.records if record.line == line)


def errors(done: Imported) -> list[int]:
    return [flag & ERROR_FLAGS for record in done.records for flag in record.flags]


def test_both_directions_through_ftdi_sio(tmp_path: Path) -> None:
    played = truth("usbmon-ftdi-19200")
    done = run(unpacked("usbmon-ftdi-19200.pcapng", tmp_path))
    assert done.code == 0
    assert characters(done, RECEIVED) == played.received
    assert characters(done, SENT) == played.sent
    assert not any(errors(done))
    assert {record.settings for record in done.records} == {LineSettings(19200)}
    assert "19200 Bd 8E1, as the adapter was set" in done.events[0]


def test_what_qemu_itself_has_recorded(tmp_path: Path) -> None:
    """The timer was 1 ms while characters came; closing the port set it back."""
    done = run(unpacked("qemu-ftdi-9600.pcap", tmp_path))
    assert (done.code, len(characters(done, SHARED))) == (0, 1620)
    assert all(record.is_good_frame for record in done.records)
    assert not any(errors(done))
    assert "latency timer 1 ms, and a USB frame" in done.events[0]


@pytest.mark.thorough
def test_both_directions_through_cdc_acm(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    played = truth("usbmon-cdc-acm")
    source = unpacked("usbmon-cdc-acm.pcapng", tmp_path)
    assert run(source).code == 2
    said = capfd.readouterr().err
    assert said == (
        f"sistap: {source} does not say at which rate the bus ran (a driver tells a CDC adapter its rate only when it "
        "changes): add it, such as --baud 9600\n"
    )
    done = run(source, "--baud", "9600")
    assert done.code == 0
    assert characters(done, RECEIVED) == played.received
    assert played.sent.startswith(characters(done, SENT))  # the capture ended a telegram before
    assert len(played.sent) - len(characters(done, SENT)) == 11
    assert not any(errors(done))


def test_line_errors_of_a_ft232r(tmp_path: Path) -> None:
    parity, framing, overrun, broken = 0x04, 0x08, 0x02, 0x10
    played = truth("usbmon-ft232r-errors")
    done = run(unpacked("usbmon-ft232r-errors.pcapng", tmp_path))
    assert done.code == 0
    assert characters(done, SHARED) == played.received
    expected: list[int] = []
    for size, status in played.packets:
        damaged = SOMEWHERE if status & (parity | framing | broken | overrun) else 0
        flags = [damaged] * size
        if size == 1 and damaged:  # the break
            flags = [BREAK]
        if status & overrun:
            flags[0] |= LOST
        expected += flags
    assert errors(done) == expected
    assert all(expected[place] for place in played.errors if played.errors[place] != overrun)
    assert "latency timer 1 ms, and a USB frame" in done.events[0]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("usbmon-ftdi-38400-8n1", "38400 Bd 8N1"),
        ("usbmon-ft232r-115200-8e1", "115200 Bd 8E1"),
        ("usbmon-cdc-115200-8n1", "115200 Bd 8N1"),
    ],
)
def test_rates_that_a_driver_has_set(tmp_path: Path, name: str, settings: str) -> None:
    """From before the adapter was plugged in: nothing has to be told."""
    played = truth(name)
    done = run(unpacked(f"{name}.pcap", tmp_path))
    assert done.code == 0
    assert characters(done, RECEIVED) == played.received
    assert characters(done, SENT) == played.sent
    assert f"{settings}, as the adapter was set" in done.events[0]
    overrun, broken = 0x02, 0x10
    expected: list[int] = []
    for size, status in played.packets:
        flags = [SOMEWHERE if status else 0] * size
        if size == 1 and status:
            flags = [BREAK if status & broken else int(Flag.CHARACTER_ERROR)]
        if status & overrun:
            flags[0] |= LOST
        expected += flags
    assert [flag & ERROR_FLAGS for one in done.records if one.line == RECEIVED for flag in one.flags] == expected
