# SPDX-License-Identifier: GPL-2.0-or-later
"""A short night with planted events, played by the virtual bus."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import NamedTuple

import once

from sistap import cli

BEGIN_S = 1773522000.0  # 2026-03-14T21:00:00Z
_READ = '{ read = "S-0-0040", station = 3 }, { read = "S-0-0040", station = 4 }'
_ASK = f"{{ repeat = [{_READ}], times = %d, every_ms = 500 }}"
_HEAD = """
title = "a short night"
begin = 2026-03-14T21:00:00Z
[line]
trs_ms = 50
tza_ms = 8
twm_ms = 60
[[station]]
address = 3
parameters = { S-0-0036 = { value = 900 } }
[[station]]
address = 4
parameters = { S-0-0036 = { value = 600 } }
[[master]]
address = 16
script = [
    { set = "TrS", ms = 50, station = 255, device = 0 },
    { set = "TzA", ms = 8, station = 255, device = 0 },
    { set = "accept", station = 255, device = 0 },
    { read = "S-0-0040", element = "attribute", station = 3 },
    { read = "S-0-0040", element = "attribute", station = 4 },
    { read = "S-0-0091", element = "attribute", station = 4 },
    { read = "S-0-0091", station = 4 },
"""


class Planted(NamedTuple):
    """An event of the night: when it can first be seen."""

    kind: str
    second: float
    station: int | None
    parameter: str = ""
    fault: str = ""  # of the scenario, on the first reaction of the station from then on


FAULTS = (
    Planted("late", 20, 4, fault='kind = "late"\nms = 60'),
    Planted("interval", 40, 3, fault='kind = "pause"\nms = 12\ncharacter = 5\nof = "reaction"'),
    Planted("damaged", 60, 4, fault='kind = "checksum"\nof = "reaction"'),
    Planted("line_error", 80, 3, fault='kind = "parity"\ncharacter = 9\nof = "reaction"'),
    Planted("damaged", 100, 4, fault='kind = "lost"\ncharacter = 7\nof = "reaction"'),
    Planted("repeated", 120, 3, fault='kind = "silent"'),
    Planted("silent", 140, 4, fault='kind = "silent"'),  # for 20 s
)
SCRIPT = (  # what the master does when; meanwhile it asks the drives
    (200, "{ token = 17 }", Planted("write", 200, 4, "S-0-0091")),
    (220, "{ switch = 2, station = 4 }", Planted("phase", 220, 4)),
    (240, "{ switch = 4, station = 4 }", Planted("phase", 240, 4)),
    (260, "{ wait_ms = 60000 }", Planted("bus_silent", 260, None)),
    # Nobody may write it.
    (340, '{ write = "S-0-0013", value = 0, station = 3 }', Planted("error", 340, 3, "S-0-0013")),
    (
        360,
        '{ set = "rate", rate = 19200, station = 255, device = 0 }, { set = "accept", station = 255, device = 0 }',
        Planted("rate", 360, None),
    ),
)
PLANTED = (*FAULTS, *(planted for _, _, planted in SCRIPT))
_LAPTOP = '[[master]]\naddress = 17\nscript = [{ write = "S-0-0091", value = 2000000, station = 4 }, { token = 16 }]\n'


def scenario(*, is_clean: bool = False) -> str:
    """Return the scenario; a clean one has the same drives and nothing else."""
    steps, now = [], 2
    for second, step, planted in SCRIPT:
        steps += [f"{{ at_ms = {now * 1000} }}", _ASK % ((second - now) * 2), f"{{ at_ms = {second * 1000} }}"]
        steps += [] if is_clean else [step]
        now = second + (60 if planted.kind == "bus_silent" and not is_clean else 1)
    steps += [f"{{ at_ms = {now * 1000} }}", _ASK % 80]
    text = _HEAD + "".join(f"    {step},\n" for step in steps) + "]\n"
    if is_clean:
        return text
    return text + _LAPTOP + "".join(map(_fault, FAULTS))


def _fault(planted: Planted) -> str:
    until = f"to_s = {planted.second + 20}" if planted.kind == "silent" else "which = 1"
    return f"[[fault]]\n{planted.fault}\nstation = {planted.station}\nfrom_s = {planted.second}\n{until}\n"


def play(path: Path, *, seed: int = 1, is_clean: bool = False) -> Path:
    """Play it into a capture."""
    text = scenario(is_clean=is_clean)
    shutil.copyfile(once.made(f"{text}{seed}", lambda made: _play(made, text, seed)), path)
    return path


def _play(path: Path, text: str, seed: int) -> None:
    script = path.with_suffix(".toml")
    script.write_text(text)
    assert cli.main(["bus", str(script), "-w", str(path), "--seed", str(seed)]) == 0
