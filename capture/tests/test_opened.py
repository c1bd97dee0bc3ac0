# SPDX-License-Identifier: GPL-2.0-or-later
"""What the page opens as a log, and what demo.cmd of the bundle starts."""

from __future__ import annotations

import json
import time
from array import array
from pathlib import Path
from typing import Any

import pytest
from portable import posix

from sistap.commands.web.opening import LINES, PLACES, is_import, open_log
from sistap.dissected.captures.reading import records
from sistap.dissected.wireshark import window
from sistap.tap.records.record import Type
from sistap.tap.terminal.exits import DONE, FAILED, Refusal

# Fig. 8-20, and what fig. 8-21 answers: in phase 2.
ASKS, ANSWERS = "02 6C 00 00 00 92 00 00", "02 56 02 02 10 92 00 00 00 02"


def opened(folder: Path, text: str, name: str = "x.log", *, is_pasted: bool = False) -> dict[str, list[Any]]:
    (folder / name).write_text(text)
    done: list[float] = []
    files = str(folder / name), str(folder / "x.pcapng")
    found: dict[str, list[Any]] = json.loads(open_log(*files, "", done.append, is_pasted=is_pasted))
    assert done[-1] <= 1
    assert is_pasted or done == sorted(done)  # a few bytes are read twice
    numbers = array("I", Path(f"{files[1]}{PLACES}").read_bytes())
    return {
        **found,
        "lines": Path(f"{files[1]}{LINES}").read_text(encoding="utf-8").splitlines(),
        "places": [[*numbers[at : at + 4]] for at in range(0, len(numbers), 4)],
    }


def test_a_log_stands_beside_its_telegrams(tmp_path: Path) -> None:
    found = opened(tmp_path, f"10:00:00.000 {ASKS}\n10:00:00.020 {ANSWERS}\n")
    assert found["lines"] == [f"10:00:00.000 {ASKS}", f"10:00:00.020 {ANSWERS}"]
    assert found["places"] == [[0, 0, 13, 36], [1, 1, 13, 42]]  # packet, line, first column, end
    assert found["unread"] == []
    _, *telegrams = records(tmp_path / "x.pcapng")
    assert [one.data.hex(" ").upper() for one in telegrams] == [ASKS, ANSWERS]


def test_bytes_without_text(tmp_path: Path) -> None:
    (tmp_path / "x.bin").write_bytes(bytes.fromhex(ASKS + ANSWERS))
    said = json.loads(open_log(str(tmp_path / "x.bin"), str(tmp_path / "x.pcapng"), "", lambda part: None))["said"]
    assert said == ["It is no text: its bytes are read as they are, without times and directions."]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("SERCOS-ASCII\n", "is a backup of the parameters of a drive"),
        ("10:00:00.000 55 AA 10 20 30 40 50 60\n", "has 8 bytes, but no telegram of SIS"),
        ("hello\n", "has no bytes in hexadecimal"),
        ("\x01\x02\x03\x04hello", "is no capture, no text"),
    ],
)
def test_what_has_no_telegrams_says_what_it_is(text: str, why: str, tmp_path: Path) -> None:
    with pytest.raises(Refusal, match=why):
        opened(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "data", "kind"),
    [
        (ASKS[:-3], ASKS[:-3], Type.FRAME),
        ("02 6C", "02 6C", Type.FRAME),
        (f"{ANSWERS[:-1]}3", f"{ANSWERS[:-1]}3", Type.FRAME),
        (ASKS.replace(" ", "_")[:-3], ASKS[:-3], Type.FRAME),
        ("STX 6C NUL NUL NUL 92 NUL", ASKS[:-3], Type.FRAME),
        ("55 AA 10", "55 AA 10", Type.OTHER),
    ],
)
def test_what_is_pasted_needs_no_right_telegram(text: str, data: str, kind: Type, tmp_path: Path) -> None:
    """A telegram that is cut is shown as one."""
    said = opened(tmp_path, text, is_pasted=True)["said"]
    assert said == [f"There is no right telegram of SIS in {len(data.split())} bytes: what is wrong stands beside each"]
    _, record = records(tmp_path / "x.pcapng")
    assert (record.type, record.data.hex(" ").upper()) == (kind, data)


def test_the_last_telegram_that_is_pasted_may_be_cut(tmp_path: Path) -> None:
    assert opened(tmp_path, f"{ASKS} {ANSWERS[:-3]}", is_pasted=True)["said"] == []
    _, *telegrams = records(tmp_path / "x.pcapng")
    assert [one.type for one in telegrams] == [Type.FRAME, Type.FRAME]
    assert [one.data.hex(" ").upper() for one in telegrams] == [ASKS, ANSWERS[:-3]]


def test_bytes_have_to_be_pasted(tmp_path: Path) -> None:
    with pytest.raises(Refusal, match="There are no bytes in this text"):
        opened(tmp_path, "hello", is_pasted=True)


def test_what_import_is_for(tmp_path: Path) -> None:
    (tmp_path / "x.log").write_text(ASKS)
    assert not is_import(str(tmp_path / "x.log"))


@posix("the program is a script")
def test_wireshark_is_started_wherever_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "wireshark"
    program.write_text(f'#!/bin/sh\necho "$@" >{tmp_path}/said\n')
    program.chmod(0o755)
    monkeypatch.setattr(window, "found", lambda name: str(program))
    assert window.main(["-k", "-i", "SIS"]) == DONE
    until = time.monotonic() + 30
    while not (tmp_path / "said").exists() or not (tmp_path / "said").read_text():
        assert time.monotonic() < until
        time.sleep(0.01)
    assert (tmp_path / "said").read_text() == "-k -i SIS\n"


def test_without_wireshark_it_says_so(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(window, "found", lambda name: "/no/such/wireshark")
    assert window.main([]) == FAILED
    assert "cannot start /no/such/wireshark: " in capfd.readouterr().err
