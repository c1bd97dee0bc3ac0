# SPDX-License-Identifier: GPL-2.0-or-later
"""Pipes that no Wireshark makes, or leaves so: a capture goes on, or ends soon, and no process stays."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from test_extcap_capture import INITIALIZED, MARKER, PATIENCE_S, SET, SISTAP, Wireshark, message

from sistap.tap.records.record import Event, Type

# A sistap that waits for the toolbar longer than Wireshark lets it run here: it ends only if it does not wait.
PATIENTLY = f"""\
import sys
from sistap import cli
from sistap.commands.extcap import toolbar
toolbar.PATIENCE_S = {2 * PATIENCE_S}
sys.exit(cli.main())
"""
PATIENT = [sys.executable, "-c", PATIENTLY]


@pytest.mark.parametrize("hostile", [Path.mkdir, lambda pipe: pipe.symlink_to("nowhere")], ids=["folder", "link"])
@pytest.mark.attack("something else in the place of the toolbar's pipes", "not waited for; the capture goes on")
def test_no_pipes_of_a_toolbar(tmp_path: Path, hostile: Callable[[Path], None]) -> None:
    hostile(tmp_path / "in")
    hostile(tmp_path / "out")
    wireshark = Wireshark(tmp_path, "sistap-demo", sistap=PATIENT)
    try:
        wireshark.event(Event.CAPTURE_STARTED)
        assert not (tmp_path / "nowhere").exists()
        assert any(record.type == Type.FRAME for record in wireshark.records())
        wireshark.process.send_signal(signal.SIGTERM)
        assert list(wireshark.blocks())
        assert wireshark.ended() == (0, "")
    finally:
        wireshark.close()


@pytest.mark.attack("something else in the place of the toolbar's pipes", "not waited for; the capture goes on")
def test_a_file_is_no_pipe_of_a_toolbar(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("precious")
    wireshark = Wireshark(tmp_path, "sistap-demo")
    try:
        with (tmp_path / "in").open("wb"):
            assert any(record.type == Type.FRAME for record in wireshark.records())
            wireshark.process.send_signal(signal.SIGTERM)
            assert list(wireshark.blocks())
            assert wireshark.ended() == (0, "")
        assert (tmp_path / "out").read_text() == "precious"
    finally:
        wireshark.close()


@pytest.mark.attack("Wireshark never opens the toolbar's pipes, and ends the capture", "it ends at once")
def test_a_toolbar_that_is_never_opened(tmp_path: Path) -> None:
    wireshark = Wireshark(tmp_path, "sistap-demo", sistap=PATIENT)
    try:
        wireshark.event(Event.CAPTURE_STARTED)
        wireshark.process.send_signal(signal.SIGTERM)
        assert list(wireshark.blocks())
        assert wireshark.ended() == (0, "")
    finally:
        wireshark.close()


@pytest.mark.parametrize("signalled", [False, True])
@pytest.mark.attack("Wireshark leaves before it opens the pipe of the capture", "the process ends")
def test_a_capture_that_nobody_reads(tmp_path: Path, *, signalled: bool) -> None:
    words = [*SISTAP, "extcap", "--capture", "--extcap-interface", "sistap-demo"]
    for option, name in (("--fifo", "x"), ("--extcap-control-in", "in"), ("--extcap-control-out", "out")):
        os.mkfifo(tmp_path / name)
        words += [option, str(tmp_path / name)]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        try:
            (tmp_path / "in").open("wb").close()
            if signalled:
                process.send_signal(signal.SIGTERM)
            _, errors = process.communicate(timeout=PATIENCE_S)
        finally:
            process.kill()
    assert (process.returncode, errors) == (0, "")


@pytest.mark.attack("a toolbar floods with markers and reads no answer", "the capture goes on, and can be stopped")
def test_a_flood_of_markers(tmp_path: Path) -> None:
    wireshark = Wireshark(tmp_path, "sistap-demo")
    try:
        with (tmp_path / "in").open("wb", buffering=0) as control, (tmp_path / "out").open("rb"):
            control.write(message(0, INITIALIZED, b""))

            def flood() -> None:
                with suppress(OSError, ValueError):  # until the capture has ended
                    while True:
                        control.write(message(MARKER, SET, b"x") * 100)

            flooding = threading.Thread(target=flood)
            flooding.start()
            for _ in range(2000):
                wireshark.event(Event.MARKER)
            assert any(record.type == Type.FRAME for record in wireshark.records())
            wireshark.process.send_signal(signal.SIGTERM)
            assert list(wireshark.blocks())
            assert wireshark.ended() == (0, "")
            flooding.join(PATIENCE_S)
            assert not flooding.is_alive()
    finally:
        wireshark.close()
