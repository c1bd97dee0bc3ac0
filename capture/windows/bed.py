# SPDX-License-Identifier: GPL-2.0-or-later
"""The checks of capture/windows/check: sistap in a Python for Windows. Prints a table at the end."""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from subprocess import SubprocessError
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import on_files  # noqa: E402 - sistap of the checkout
import on_ports  # noqa: E402
import on_wireshark  # noqa: E402
from proxy import Proxy  # noqa: E402
from wine import Wine  # noqa: E402

SUITE_S = 900
SUITE = "-m pytest -q -rs -c capture/pyproject.toml --rootdir . -p no:cacheprovider --tb=short -n 2 --dist worksteal"


class Row(NamedTuple):
    """What came of a part."""

    python: str
    part: str
    amount: str
    good: bool

    def __str__(self) -> str:
        """A line of the table."""
        return f"| {self.python} | {self.part} | {self.amount} | {'good' if self.good else 'FAILED'} |"


def suite(wine: Wine) -> str:
    """Run the tests that are for Windows, too; what is not says why (in suite-VERSION.txt)."""
    options = [*SUITE.split(), "-m", "not thorough", "capture/tests"]
    log = wine.folder / f"suite-{wine.python.parents[4].name}.txt"
    said = wine.run(wine.python, *options, code=None, timeout_s=SUITE_S)
    log.write_text(said)
    last = re.sub(r" in .*|=+ ?|, \d+ warnings?", "", said.strip().splitlines()[-1])
    assert re.fullmatch(r"\d+ passed(, \d+ skipped)?", last), f"{last}; see {log}"
    return last


PARTS: dict[str, Callable[[Wine], str]] = {
    "start": on_files.version,
    "ports": on_files.ports,
    "COM5": partial(on_ports.capture, port="COM5"),
    "COM15": partial(on_ports.capture, port="COM15"),
    "--baud auto": on_ports.looked_for,
    "--follow-baud": on_ports.followed,
    "bus": on_files.own_bus,
    "ring": on_files.ring,
    "annotate": on_files.annotate,
    "report --format text": on_files.report,
    "selftest": on_files.selftest,
    "launcher": on_wireshark.launcher,
    "install": on_wireshark.install,
    "extcap, asked": on_wireshark.asked,
    **{
        f"extcap, {what}, {first} pipe closed first": partial(capture, first=first)
        for what, capture in (("demo bus", on_wireshark.demo), ("COM5", on_wireshark.port))
        for first in on_wireshark.ORDERS
    },
    "uninstall": on_wireshark.uninstall,
    "suite": suite,
}


def rows(wine: Wine, name: str, wanted: list[str]) -> Iterator[Row]:
    """Do all parts, or those wanted."""
    for part, do in PARTS.items():
        if wanted and part not in wanted:
            continue
        begun = time.monotonic()
        try:
            row = Row(name, part, do(wine), True)
        except (AssertionError, OSError, ValueError, SubprocessError) as error:
            print(f"windows: {name}: {part}: {error}", flush=True)
            row = Row(name, part, "", False)
        print(f"windows: {row} {time.monotonic() - begun:.0f} s", flush=True)
        yield row


def main(folder: str, versions: str, *wanted: str) -> int:
    """Run all parts, or those wanted, with each Python; return the exit code."""
    table: list[Row] = []
    place = Path(folder)
    plugins = {"WIRESHARK_PLUGIN_DIR": os.environ["WIRESHARK_PLUGIN_DIR"]}
    with Proxy(place / "prefix", {"HOME": str(place / "home")}) as proxy:
        for version in versions.split():
            (python,) = Path(folder, version).rglob("windows-x86_64/python.exe")
            wine = Wine(place, python, PROXY_PORT=str(proxy.port), **plugins)
            try:
                wine.start_up()
                table += rows(wine, version.partition("-")[0], list(wanted))
            finally:
                with suppress(SubprocessError):
                    wine.shut_down()
        proxy.shutdown()
    print("| Python | part | count | result |", "|---|---|---|---|", *table, sep="\n")
    return 0 if all(row.good for row in table) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
