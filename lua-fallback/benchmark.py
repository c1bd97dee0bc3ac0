#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Measures the speed of sis.lua, compared with the C plugin and with a minimal dissector in Lua.

python3 benchmark.py

All three read the same capture: telegrams as the serial tap records them. The minimal dissector has four fields and a
column. Times are processor times, the best of the rounds; a time is the increase: all packets minus one packet.
WIRESHARK_PLUGIN_DIR names the C plugin.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent / "capture"), str(HERE.parent / "capture" / "benchmark")]

import dissect  # noqa: E402

from sistap.dissected.wireshark.tshark import Tshark, TsharkError  # noqa: E402

GOAL = 40_000  # telegrams a second in the list, or half of the minimal dissector's

LEAST = """
local least = Proto("sertap", "Four fields")
local version = ProtoField.uint8("sertap.version", "Version")
local kind = ProtoField.uint8("sertap.type", "Type")
local baud = ProtoField.uint32("sertap.baud", "Baud rate")
local count = ProtoField.uint16("sertap.count", "Count")
least.fields = { version, kind, baud, count }
function least.dissector(tvb, pinfo, tree)
    pinfo.cols.protocol = "SERTAP"
    pinfo.cols.info = "Record of " .. tvb(16, 2):uint()
    local item = tree:add(least, tvb())
    item:add(version, tvb(0, 1))
    item:add(kind, tvb(2, 1))
    item:add(baud, tvb(4, 4))
    item:add(count, tvb(16, 2))
end
"""

MODES = {"list": [], "list -2": ["-2"], "-V": ["-V"]}


def contestants(folder: Path, stack: ExitStack) -> dict[str, Tshark]:
    """Return a tshark for each side."""
    for name in ("script", "least"):
        (folder / name).mkdir()
    shutil.copy(HERE / "sis.lua", folder / "script")
    (folder / "least" / "least.lua").write_text(LEAST)
    return {
        "C plugin": stack.enter_context(Tshark()),
        "sis.lua": stack.enter_context(Tshark(plugins=folder / "script")),
        "four fields": stack.enter_context(Tshark(plugins=folder / "least")),
    }


def check(sides: dict[str, Tshark], capture: str) -> None:
    """Raise TsharkError unless every side dissects the capture, and both of ours give the same result."""
    said = {name: tshark.output("-r", capture, "-V", "-O", "sertap,sis") for name, tshark in sides.items()}
    if said["sis.lua"] != said["C plugin"]:
        raise TsharkError("C plugin and sis.lua differ; is WIRESHARK_PLUGIN_DIR a folder with the plugin?")
    if "Four fields" not in said["four fields"]:
        raise TsharkError("the dissector with four fields is not loaded; was tshark built without Lua?")


def seconds(tshark: Tshark, capture: str, options: list[str]) -> float:
    """Return the processor time of one run."""
    return tshark.usage(["-r", capture, *options]).seconds


def rates(sides: dict[str, Tshark], captures: tuple[str, str], count: int, rounds: int, mode: str) -> dict[str, float]:
    """Return telegrams a second for every side; the captures have `count` packets and one."""
    best = {(name, capture): float("inf") for name in sides for capture in captures}
    for _ in range(rounds):
        for name, capture in best:
            best[name, capture] = min(best[name, capture], seconds(sides[name], capture, MODES[mode]))
    many, one = captures
    return {name: (count - 1) / (best[name, many] - best[name, one]) for name in sides}


def measure(sides: dict[str, Tshark], folder: Path, count: int, rounds: int) -> None:
    """Print the table."""
    captures = tuple(str(folder / f"{packets}.pcapng") for packets in (count, 1))
    for capture, packets in zip(captures, (count, 1), strict=True):
        dissect.write_capture(Path(capture), dissect.PROTOCOLS[0], packets)
    check(sides, captures[1])
    print(f"{'telegrams/s':<12}" + "".join(f"{name:>14}" for name in sides))
    for mode in MODES:
        found = rates(sides, (captures[0], captures[1]), count, rounds, mode)
        print(f"{mode:<12}" + "".join(f"{rate:>14,.0f}" for rate in found.values()))
        if mode == "list":
            goal = max(GOAL, found["four fields"] / 2)
            print(f"{'':<12}goal {goal:,.0f}: {'met' if found['sis.lua'] >= goal else 'NOT MET'}")


def main() -> int:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=50_000, help="telegrams (default 50000)")
    parser.add_argument("--rounds", type=int, default=3, help="how often each is measured (default 3)")
    arguments = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory(prefix="sistap-benchmark-") as name, ExitStack() as stack:
            folder = Path(name)
            measure(contestants(folder, stack), folder, arguments.count, arguments.rounds)
    except (TsharkError, OSError) as error:
        print(f"benchmark.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
