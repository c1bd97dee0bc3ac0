#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""The whole path once, with no hardware: virtual bus -> pseudo terminal -> capture -> Wireshark's dissection.

`./bootstrap demo` calls it with the plugin built and WIRESHARK_PLUGIN_DIR set.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sistap.dissected.wireshark.tshark import Tshark, TsharkError

SISTAP = [sys.executable, "-m", "sistap"]
CAPTURE = Path(__file__).parent.parent / "build" / "demo.pcapng"
SECONDS = 6
PACKETS = 60
STATISTICS = (
    ("sis,tree", "Who talked how much, and what went wrong"),
    ("sis,srt", "How fast the drives react, in seconds"),
)
UNRESOLVED = "sis.tza.verdict == 2 || sis.trs.verdict == 2 || sis.tmas.verdict == 2"
VALUE = 'sis.value contains "rpm" && sis.control.reaction == 1'


@contextmanager
def virtual_bus() -> Iterator[str]:
    """Play the virtual bus; return the name of its pseudo terminal."""
    bus = subprocess.Popen([*SISTAP, "bus", "--seed", "1"], stdout=subprocess.PIPE, text=True)
    try:
        assert bus.stdout is not None
        yield bus.stdout.readline().strip()
    finally:
        bus.terminate()
        bus.wait()


def heading(text: str, command: str) -> None:
    """Print what comes, and the command that shows it."""
    print(f"\n-- {text}\n   {command}\n", flush=True)


def show(tshark: Tshark) -> None:
    """Print what a user would look at first."""
    capture = ("-r", str(CAPTURE))
    heading("The bus, one telegram in each line", "tshark -r build/demo.pcapng")
    packets = tshark.output(*capture).splitlines()
    print("\n".join(packets[:PACKETS]))
    if len(packets) > PACKETS:
        print(f"  ... and {len(packets) - PACKETS} more")
    heading("One telegram in detail", f"tshark -r build/demo.pcapng -V -O sis -Y '{VALUE}'")
    print(tshark.output(*capture, "-Y", VALUE, "-V", "-O", "sis").split("\n\n")[0])
    for statistics, text in STATISTICS:
        heading(text, f"tshark -r build/demo.pcapng -q -z {statistics}")
        print(tshark.output(*capture, "-q", "-z", statistics))
    print(doubts(tshark.output(*capture, "-Y", UNRESOLVED, "-T", "fields", "-e", "sertap.uncertainty").splitlines()))


def doubts(uncertainties_s: list[str]) -> str:
    """Say why verdicts are unresolved, given the uncertainties of those telegrams in s. Empty if there are none."""
    if not uncertainties_s:
        return ""
    known = [float(text) for text in uncertainties_s if text]
    exact = f"exact only to {max(known) * 1e3:.3f} ms" if known else "of unknown exactness"
    return (
        f"Unresolved verdicts: {len(uncertainties_s)}. This computer was busy, so the times are {exact}.\n"
        "For exact times, play into a file: sistap bus --cycles 5 -w exact.pcapng"
    )


def main() -> int:
    """Run the demo; return the exit code."""
    CAPTURE.parent.mkdir(exist_ok=True)
    with virtual_bus() as port:
        command = ["capture", "-i", port, "-w", str(CAPTURE), "--force", "-a", f"duration:{SECONDS}"]
        heading(
            f"A virtual bus plays on {port}; {SECONDS} seconds of it",
            f"sistap {' '.join(command[:4])} build/demo.pcapng",
        )
        code = subprocess.run([*SISTAP, *command], check=False).returncode
    if code != 0:
        return code
    try:
        with Tshark() as tshark:
            if "sis.so" not in tshark.output("-G", "plugins"):
                raise TsharkError("tshark does not load sis.so: is WIRESHARK_PLUGIN_DIR set?")
            show(tshark)
    except TsharkError as error:
        print(f"demo: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
