# SPDX-License-Identifier: GPL-2.0-or-later
"""The checks of capture/windows/check: sistap in a Python for Windows. Prints a table at the end."""

from __future__ import annotations

import os
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from subprocess import SubprocessError
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import on_files  # noqa: E402 - sistap of the checkout
import on_ports  # noqa: E402
import on_wireshark  # noqa: E402
from proxy import Proxy  # noqa: E402
from wine import CAPTURE, ROOT, Wine  # noqa: E402

SUITE_S = 3600
SUITE = "-m pytest -q -rs -c capture/pyproject.toml --rootdir . -p no:cacheprovider --tb=short --timeout=900"
FAILURES = ("failed", "error", "errors")  # pytest's words


class Done(NamedTuple):
    """The result of a part with one Python."""

    amount: str
    good: bool

    def __str__(self) -> str:
        """Return a cell of the table."""
        result = "good" if self.good else "FAILED"
        return f"{self.amount}: {result}" if self.amount else result


def suite(wine: Wine) -> str:
    """Run the tests that also apply to Windows, a share of the files on each processor; suite-*.txt has their output.

    (Without pytest-xdist: under wine it sometimes misses the end of a worker.)
    """
    files = sorted(path.relative_to(ROOT) for path in (CAPTURE / "tests").glob("test_*.py"))
    count = os.cpu_count() or 1
    with ThreadPoolExecutor(count) as pool:
        shares = pool.map(partial(share, wine), range(count), [files[first::count] for first in range(count)])
    counted = sum(shares, Counter[str]())
    told = ", ".join(f"{counted[word]} {word}" for word in ("passed", "skipped", *FAILURES) if counted[word])
    assert counted["passed"] and not any(counted[word] for word in FAILURES), f"{told}: see {_log(wine, '*')}"
    return told


def share(wine: Wine, number: int, files: list[Path]) -> Counter[str]:
    """Run some test files; return how many passed, were skipped, or failed."""
    own = [f"--basetemp=C:\\suite{number}", "-m", "not thorough and not style", *map(str, files)]
    said = wine.run(wine.python, *SUITE.split(), *own, code=None, timeout_s=SUITE_S)
    log = _log(wine, number)
    log.write_text(said)
    # Not always the last line: wine's server may complain when it ends.
    summaries = re.findall(r"^(\d+ [a-z]+, .*|\d+ [a-z]+) in [\d.]+s", said, re.MULTILINE)
    assert summaries, f"no summary of pytest: see {log}"
    return Counter({word: int(count) for count, word in re.findall(r"(\d+) ([a-z]+)", summaries[-1])})


def _log(wine: Wine, number: int | str) -> Path:
    return wine.folder / f"suite-{wine.version}-{number}.txt"


PARTS: dict[str, Callable[[Wine], str]] = {
    "start, --version": on_files.version,
    "ports": on_files.ports,
    "capture -i COM5": partial(on_ports.capture, port="COM5"),
    "capture -i COM15": partial(on_ports.capture, port="COM15"),
    "capture --baud auto": on_ports.looked_for,
    "capture --follow-baud": on_ports.followed,
    "doctor -i COM15": on_files.doctor,
    "bus, and capture from it": on_files.own_bus,
    "capture -b, a ring": on_files.ring,
    "annotate": on_files.annotate,
    "report --format text": on_files.report,
    "selftest": on_files.selftest,
    "sistap.exe, its arguments": on_wireshark.launcher,
    "install": on_wireshark.install,
    "extcap: interfaces, dialog": on_wireshark.asked,
    **{
        f"extcap: {what}, the {first} pipe closed first": partial(capture, first=first)
        for what, capture in (("demo bus", on_wireshark.demo), ("COM5", on_wireshark.port))
        for first in on_wireshark.ORDERS
    },
    "uninstall": on_wireshark.uninstall,
    "the tests of sistap": suite,
}


def results(wine: Wine, wanted: list[str]) -> Iterator[tuple[str, Done]]:
    """Run all parts, or the chosen ones, and yield the results."""
    for part, do in PARTS.items():
        if wanted and part not in wanted:
            continue
        begun = time.monotonic()
        try:
            done = Done(do(wine), True)
        except (AssertionError, OSError, ValueError, SubprocessError) as error:
            print(f"windows: {wine.version}: {part}: {error}", flush=True)
            done = Done("", False)
        print(f"windows: {wine.version}: {part}: {done} ({time.monotonic() - begun:.0f} s)", flush=True)
        yield part, done


def table(columns: dict[str, dict[str, Done]]) -> Iterator[str]:
    """Yield the lines of a table: a row for each part, a column for each Python."""
    yield f"| | {' | '.join(columns)} |"
    yield f"|---|{'---|' * len(columns)}"
    for part in PARTS:
        cells = [str(column[part]) for column in columns.values() if part in column]
        if cells:
            yield f"| {part} | {' | '.join(cells)} |"


def main(folder: str, versions: str, *wanted: str) -> int:
    """Run all parts, or the chosen ones, with each Python; return the exit code."""
    columns: dict[str, dict[str, Done]] = {}
    place = Path(folder)
    plugins = {"WIRESHARK_PLUGIN_DIR": os.environ["WIRESHARK_PLUGIN_DIR"]}
    with Proxy(place / "prefix", {"HOME": str(place / "home")}) as proxy:
        for version in versions.split():
            (python,) = Path(folder, version).rglob("windows-x86_64/python.exe")
            wine = Wine(place, python, PROXY_PORT=str(proxy.port), **plugins)
            try:
                wine.start_up()
                columns[f"Python {wine.version}"] = dict(results(wine, list(wanted)))
            finally:
                wine.shut_down()
        proxy.shutdown()
    print(*table(columns), sep="\n")
    return 0 if all(done.good for column in columns.values() for done in column.values()) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
