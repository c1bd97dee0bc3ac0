# SPDX-License-Identifier: GPL-2.0-or-later
"""Loads sis.dll, then sis.lua, in a Wireshark for Windows under wine: each capture has to dissect as on Linux.

`wireshark` beside this makes that Wireshark, `module` the DLL: the one that the bundle has.

Exit code: 0 everything is as expected; 1 something is not; 77 it cannot be tried here, with the reason.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "capture"), str(ROOT / "test-captures")]

from make import Scenario  # noqa: E402

MADE = ROOT / "build/windows"
PROGRAMS = MADE / "wireshark/run"
SERIES = "4.4"  # of that Wireshark
PLUGINS = PROGRAMS / "plugins"
DLL = PLUGINS / SERIES / "epan/sis.dll"
SCRIPT = PLUGINS / "sis.lua"
NOT_RUN = 77
TIMEOUT_S = 180


class WindowsTshark:
    """That tshark.exe, which sees the plugins in its own folder alone."""

    def output(self, *arguments: str) -> str:
        """Return what it says. May raise CalledProcessError and TimeoutExpired."""
        own = {name: value for name, value in os.environ.items() if not name.startswith("WIRESHARK")}
        own |= {"WINEPREFIX": str(MADE / "wireshark/prefix-of-wine"), "WINEARCH": "win64", "WINEDEBUG": "-all"}
        command = ["wine", str(PROGRAMS / "tshark.exe"), *arguments]
        done = subprocess.run(command, env=own, cwd=PROGRAMS, capture_output=True, check=True, timeout=TIMEOUT_S)
        return done.stdout.decode().replace("\r\n", "\n")


def use(plugin: Path, source: Path) -> None:
    """Leave one plugin in Wireshark's folder."""
    for other in (DLL, SCRIPT):
        other.unlink(missing_ok=True)
    plugin.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, plugin)


def differs(description: Path) -> str:
    """Return a sentence if the capture dissects otherwise than expected."""
    try:
        text = Scenario(description).dissection(WindowsTshark(), description.with_suffix(".pcapng"))
    except subprocess.CalledProcessError as error:
        return f"{description.stem}: {error.stderr.decode(errors='replace')[:300]}"
    for number, (line, wanted) in enumerate(
        zip(text.splitlines(), description.with_suffix(".expected").read_text().splitlines(), strict=False), 1
    ):
        if line != wanted:
            return f"{description.stem}, line {number}: {line!r} in place of {wanted!r}"
    return ""


def descriptions(plugin: Path) -> list[Path]:
    """Return those of all captures that this plugin can be asked for: a script has no tables of the user's."""
    every = sorted(file.with_suffix(".txt") for file in (ROOT / "test-captures").glob("*.expected"))
    return [file for file in every if plugin == DLL or not any("uat:" in word for word in Scenario(file).options)]


def trial(plugin: Path, source: Path) -> bool:
    """Dissect the captures with this plugin; say how it went."""
    use(plugin, source)
    asked = descriptions(plugin)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        wrong = [said for said in pool.map(differs, asked) if said]
    for said in wrong:
        print(f"bundle: FAILED {plugin.name}: {said}")
    if not wrong:
        print(f"bundle: good   {plugin.name} in a Wireshark {SERIES} for Windows, {len(asked)} captures")
    return not wrong


def main() -> int:
    """Try both; return the exit code."""
    module = MADE / "module" / SERIES / "sis.dll"
    for needed, maker in {PROGRAMS / "tshark.exe": "wireshark", module: "module"}.items():
        if not needed.exists():
            print(f"bundle: not tried: sis.dll: make it with capture/bundle/{maker}", file=sys.stderr)
            return NOT_RUN
    if not shutil.which("wine"):
        print("bundle: not tried: sis.dll: wine is missing: apt-get install wine wine64", file=sys.stderr)
        return NOT_RUN
    WindowsTshark().output("--version")  # before several at once: wine makes its Windows
    return 0 if all([trial(DLL, module), trial(SCRIPT, ROOT / "lua-fallback/sis.lua")]) else 1


if __name__ == "__main__":
    sys.exit(main())
