# SPDX-License-Identifier: GPL-2.0-or-later
"""Arguments that no Wireshark passes to an extcap: an exit code and perhaps a line, never a traceback."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from sistap import cli
from sistap.commands.extcap import dialog
from sistap.commands.extcap.interfaces import ANALYSER, DEMO

QUESTIONS = ["--extcap-interfaces", "--extcap-dlts", "--extcap-config", "--capture", ""]
NAMES = [DEMO, ANALYSER, "", "../..", "x\0y", "é\udcff", "-w", "%s%n", "A" * 9999]
VALUES = [
    "",
    "0",
    "-1",
    "9" * 400,
    "1e999",
    "nan",
    "/",
    "/proc",
    "/no/such",
    "\udcff",
    "a\0b",
    "=1",
    "--",
    "A" * 9999,
    "\x1b[31m",
]
OPTIONS = [
    *("--extcap-version", "--extcap-reload-option", "--extcap-capture-filter", "--fifo"),
    *(field.call for field in dialog.OPTIONS),
]
MUTANTS = 60


@pytest.mark.attack("arguments that no Wireshark passes to an extcap", "an exit code and a line; no traceback")
@pytest.mark.parametrize("seed", range(4))
def test_hostile_arguments(seed: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pick = random.Random(seed)
    for _ in range(MUTANTS):
        words = [pick.choice(QUESTIONS), "--extcap-interface", pick.choice(NAMES)]
        for option in pick.sample(OPTIONS, pick.randint(0, 4)):
            words += [option] if option in {"--follow-baud"} else [option, pick.choice(VALUES)]
        if "--capture" in words:
            words += ["--fifo", pick.choice([str(tmp_path), str(tmp_path / "no/x"), "/dev/full"])]
        code: str | int | None
        try:
            code = cli.main(["extcap", *filter(None, words)])
        except SystemExit as left:  # of the parser
            code = left.code
        assert code in (0, 1, 2, 3), words
        assert "Traceback" not in capfd.readouterr().err, words
