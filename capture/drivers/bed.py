# SPDX-License-Identifier: GPL-2.0-or-later
"""The checks of capture/drivers/check: every driver, then the pulled plug; a table of it into capture/README.md."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

CAPTURE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CAPTURE))

import power  # noqa: E402 - of the checkout
import table  # noqa: E402
from checks import CHECKS, Bench, NotJudged  # noqa: E402
from drivers import Driver, all_drivers  # noqa: E402
from machine import Guest, NoGuest, Program, accelerator  # noqa: E402

FAILED, NOT_RUN = 1, 77
TRACE = ("-trace", "serial_write", "-D", "trace")


def judged(guest: Guest, driver: Driver, usbmon: Program, words: str) -> dict[str, str]:
    """Judge a driver; return the result of each check whose name has these words."""
    driver.start(guest)
    bench = Bench(guest, driver, driver.watch(guest, usbmon))
    results = {}
    for name, check in CHECKS.items():
        if words not in check.__name__:
            continue
        begun = time.monotonic()
        try:
            check(bench)
            results[name] = table.GOOD
        except NotJudged:
            results[name] = table.NOT_JUDGED
        except (AssertionError, OSError, ValueError) as error:
            results[name] = table.FAILED
            print(f"drivers: FAILED {driver.name}: {name}: {error}", flush=True)
        print(f"drivers: {results[name]:6} {driver.name}: {name} ({time.monotonic() - begun:.1f} s)", flush=True)
    return results


def drivers(folder: Path, runs_on: str, words: str) -> dict[str, dict[str, str]]:
    """Judge all drivers in one guest."""
    drivers = all_drivers()
    guest = Guest(folder, runs_on, [*TRACE, *(word for driver in drivers for word in driver.devices)])
    try:
        usbmon = guest.start("usbmon", "/dev/null")
        usbmon.until("{}")
        return {driver.name: judged(guest, driver, usbmon, words) for driver in drivers}
    finally:
        guest.kill()


def main() -> int:
    """Do it; return the exit code."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", default="", metavar="WORD", help="run the checks whose function has this in its name")
    options = parser.parse_args()
    try:
        runs_on = accelerator(options.folder)
        results = drivers(options.folder, runs_on, options.only)
        pulled = power.pulled(options.folder, runs_on) if options.only in power.pulled.__name__ else ""
    except NoGuest as error:
        print(f"drivers: not run: {error}", file=sys.stderr)
        return NOT_RUN
    if not options.only:
        table.write(CAPTURE / "README.md", results, pulled)
    failed = table.FAILED in [result for row in results.values() for result in row.values()] or pulled.startswith(table.FAILED)
    return FAILED if failed else 0


if __name__ == "__main__":
    sys.exit(main())
