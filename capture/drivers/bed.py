# SPDX-License-Identifier: GPL-2.0-or-later
"""The checks of capture/drivers/check: every driver, then the power cut; writes a table into README.md."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

CAPTURE = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(CAPTURE))

import power  # noqa: E402 - of the checkout
import table  # noqa: E402
from checks import CHECKS, Bench, NotJudged  # noqa: E402
from machine import Guest, NoGuest, Program, accelerator  # noqa: E402
from truth import Figures  # noqa: E402

from drivers import Driver, all_drivers  # noqa: E402

FAILED, NOT_RUN = 1, 77
TRACE = ("-trace", "serial_write", "-D", "trace")


class Judged(NamedTuple):
    """The results of the checks by their names, and the figures of the errors, if they were judged."""

    results: dict[str, str]
    figures: Figures | None


def judged(guest: Guest, driver: Driver, usbmon: Program, words: str) -> Judged:
    """Judge a driver; return the result of each check whose function name contains `word`."""
    figures = None
    results: dict[str, str] = {}
    checks = {name: check for name, check in CHECKS.items() if words in check.__name__}
    starts: dict[str, Callable[[Bench], object]] = {"its ports": Bench.start}
    bench = Bench(guest, driver, usbmon)
    for name, check in (starts | checks).items():
        begun = time.monotonic()
        result, why = table.GOOD, ""
        try:
            said = check(bench)
            figures = said if isinstance(said, Figures) else figures
            why = f": {said}" if said else ""
        except NotJudged:
            result = table.NOT_JUDGED
        except (AssertionError, LookupError, OSError, ValueError) as error:
            result, why = table.FAILED, f": {error}"
        print(f"drivers: {result:6} {driver.name}: {name}, {time.monotonic() - begun:.1f} s{why}", flush=True)
        results[name] = result
        if check is Bench.start and result == table.FAILED:
            break
    driver.end(guest)
    return Judged({name: results.get(name, table.FAILED) for name in checks}, figures)


def drivers(folder: Path, runs_on: str, words: str, only: str) -> dict[str, Judged]:
    """Judge the drivers in one guest."""
    drivers = [driver for driver in all_drivers() if only in driver.name]
    guest = Guest(folder, runs_on, [*TRACE, *(word for driver in drivers for word in driver.devices)])
    try:
        usbmon = guest.start("usbmon", "/dev/null")
        usbmon.until("{}")
        return {driver.name: judged(guest, driver, usbmon, words) for driver in drivers}
    finally:
        guest.kill()


def main() -> int:
    """Run the checks; return the exit code."""
    parser = argparse.ArgumentParser(description="Judge drivers, then pull the plug; without options, write the table.")
    parser.add_argument("folder", type=Path, help="where guest/make has put the guest")
    parser.add_argument("--check", default="", metavar="WORD", help="only checks whose function has this in its name")
    parser.add_argument("--driver", default="", metavar="WORD", help="only drivers that have this in their name")
    parser.add_argument("--plug", action="store_true", help="only pull the plug")
    options = parser.parse_args()
    found: dict[str, Judged] = {}
    pulled = ""
    try:
        runs_on = accelerator(options.folder)
        print(f"drivers: the guest runs on {runs_on.partition(',')[0]}", flush=True)
        if not options.plug:
            found = drivers(options.folder, runs_on, options.check, options.driver)
        if not (options.check or options.driver):
            pulled = power.pulled(options.folder, runs_on)
    except NoGuest as error:
        print(f"drivers: not run: {error}", file=sys.stderr)
        return NOT_RUN
    results = {name: one.results for name, one in found.items()}
    figures = {name: one.figures for name, one in found.items() if one.figures}
    if results and pulled:
        table.write(CAPTURE / "drivers" / "README.md", results, figures, pulled)
    failed = table.FAILED in [pulled.partition(".")[0], *(one for row in results.values() for one in row.values())]
    return FAILED if failed else 0


if __name__ == "__main__":
    sys.exit(main())
