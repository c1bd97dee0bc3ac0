# SPDX-License-Identifier: GPL-2.0-or-later
"""Checks without a port: sistap prints and writes the same under Windows as here."""

from __future__ import annotations

import re
from pathlib import Path

from wine import ROOT, TIMEOUT_S, Wine, drive, emptied, here

from sistap.dissected.captures.reading import records
from sistap.tap.records.record import Type

DAY = ROOT / "test-captures/commands.pcapng"
LARGE_KB, KEPT, CYCLES = 5, 3, "4"


def version(wine: Wine) -> str:
    """Start sistap."""
    said = wine.sistap("--version")
    assert said.startswith("sistap "), said
    return ""


def ports(wine: Wine) -> str:
    """List the ports, or print the cure for Windows. (wine lists no ports for pyserial.)"""
    said = wine.sistap("ports")
    assert "Device Manager" in said, said
    return ""


def doctor(wine: Wine) -> str:
    """Check a port, and print the cures for Windows."""
    with wine.terminal("COM15"):
        said = wine.sistap("doctor", "-i", "COM15")
    assert "good  opens" in said, said
    assert "good  plugin" in said, said
    assert not re.search("sudo|apt-get|/dev/|dmesg", said), said
    return ""


def own_bus(wine: Wine) -> str:
    """Play a bus without naming a place: it listens, and prints where."""
    process = wine.start(wine.python, "-m", "sistap", "bus", "--cycles", "1")
    assert process.stdout
    url = process.stdout.readline().strip()
    assert url.startswith("bus://127.0.0.1:"), url
    said = wine.sistap("capture", "-i", url, "-c", "9")
    process.communicate(timeout=TIMEOUT_S)
    assert re.search(r"16 -> 3 +Command +Node identification", said), said
    return ""


def ring(wine: Wine) -> str:
    """Keep the last files of a ring; together they are one contiguous piece of the traffic."""
    folder = emptied(wine.folder / "ring")
    whole = wine.folder / "whole.pcapng"
    here("bus", "--cycles", CYCLES, "-w", whole, "--force")
    process = wine.start(wine.python, "-m", "sistap", "bus", "--fast", "--cycles", CYCLES)
    assert process.stdout
    url = process.stdout.readline().strip()
    limits = ["-b", f"filesize:{LARGE_KB}", "-b", f"files:{KEPT}"]
    said = wine.sistap("capture", "-i", url, "-w", drive(folder / "day.pcapng"), *limits, code=1)  # the bus ends
    process.communicate(timeout=TIMEOUT_S)
    files = sorted(folder.iterdir())
    assert len(files) == KEPT, f"{files}\n{said}"
    kept = b"".join(map(_characters, files))
    assert kept and kept in _characters(whole), said
    return f"{KEPT} files, {len(kept)} characters"


def _characters(file: Path) -> bytes:
    return b"".join(record.data for record in records(file) if record.type in (Type.FRAME, Type.OTHER))


def annotate(wine: Wine) -> str:
    """Explain a log with the same result as here."""
    log = wine.folder / "master.txt"
    here("bus", "--cycles", "2", "--force", "-w", wine.folder / "master.pcapng", "--log", log)
    said = wine.sistap("annotate", drive(log))
    assert said == here("annotate", log)
    return f"{said.count(chr(10))} lines"


def report(wine: Wine) -> str:
    """Report on a capture with the same result as here."""
    said = wine.sistap("report", "--format", "text", drive(DAY))
    assert said.replace(drive(DAY), str(DAY)) == here("report", "--format", "text", DAY)
    return f"{said.count(chr(10))} lines"


def selftest(wine: Wine) -> str:
    """Measure this computer."""
    said = wine.sistap("selftest", "--duration", "10")
    assert "p99.9" in said, said
    assert "kept in" in said, said
    return ""
