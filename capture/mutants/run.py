#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-2.0-or-later
"""Do the tests notice small faults in the engine? Makes mutants and counts those that a test catches."""

from __future__ import annotations

import argparse
import enum
import hashlib
import importlib.util
import os
import queue
import secrets
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import making
import making_c
from covering import PARTS, Part
from making import Mutant
from making_c import Change
from plugin import Plugin

DESCRIPTION = """\
Make mutants of the engine, each with one small fault, and run the tests that cover it. Print each mutant that no test
catches, with its line before and after, and the share caught. A mutant whose tests hang counts as caught.
"""

EPILOG = """\
exit status:
  0  enough were caught
  1  too few were caught
  2  wrong usage, or the tests fail without any fault
"""

HERE = Path(__file__).resolve().parent
CAPTURE = HERE.parent
GOAL, ENOUGH = 95, 90  # %; the goal of the project; below ENOUGH the exit code is 1, because a sample varies
WORKERS = 2
COUNT = 80  # about six minutes on two quiet cores
PATIENCE, PATIENCE_S = 4, 15  # time limit: PATIENCE times as long as the tests without a fault, plus PATIENCE_S
SURVIVED, INTERNAL = 0, 3  # exit codes of pytest; above the second: wrong usage, no tests
OPTIONS = shlex.split(
    '-c pyproject.toml --rootdir . -x -q -m "not thorough and not style" -p quick -p no:cacheprovider'
)
COMPILER = 1  # it has noticed the fault


class Broken(Exception):
    """The tests cannot be run; str() is the line to show."""


class Fate(enum.Enum):
    """The result of a mutant."""

    CAUGHT = enum.auto()
    NO_END = enum.auto()  # counts as caught, because somebody would notice
    NOT_CAUGHT = enum.auto()


class Chosen(NamedTuple):
    """A mutant, and its part."""

    part: Part
    source: str  # of the module, without the fault
    mutant: Mutant | Change

    @property
    def mutated(self) -> str:
        """Return the source with the fault."""
        if isinstance(self.mutant, Change):
            return making_c.mutated(self.source, self.mutant)
        return making.mutated(self.source, self.mutant)

    def __str__(self) -> str:
        """Name it in one line: where, and what was changed."""
        if isinstance(self.mutant, Change):
            before, after = making_c.difference(self.source, self.mutant)
        else:
            before, after = making.difference(self.source, self.mutant)
        return f"{self.part.module}:{self.mutant.line}: {before}  ->  {after}"


class Copy:
    """A copy of the package and its tests in which one module at a time is a mutant."""

    def __init__(self, folder: Path, of: Path = CAPTURE) -> None:
        """Copy everything; the folders beside capture/ are only read, so link them."""
        self.capture = folder / "capture"
        self._temporary = folder / "temporary"
        self._running: subprocess.Popen[bytes] | None = None
        left_out = shutil.ignore_patterns("__pycache__", ".*", "build") if of == CAPTURE else None
        shutil.copytree(of, self.capture, ignore=left_out)
        for beside in ("lua-fallback", "test-captures"):
            (folder / beside).symlink_to(CAPTURE.parent / beside)
        self._plugin = Plugin(folder)

    def run(self, part: Part, limit_s: float | None = None, *, compiled: bool = False) -> int | None:
        """Run the tests of a part; return the exit code of pytest, None if they exceed the limit.

        `compiled`: keep the compiled Python files; those of a mutant must not stay.
        """
        if part.is_c and not self._plugin.build():
            return COMPILER
        tests = [f"tests/{name}" for name in part.tests]
        options = [*OPTIONS, "--basetemp", str(self._temporary)]
        process = subprocess.Popen(
            [sys.executable, "-m", "pytest", *options, *tests],
            cwd=self.capture,
            env={
                **os.environ,
                **(self._plugin.environment if part.is_c else {}),
                "PYTHONPATH": os.pathsep.join((str(self.capture), str(self.capture / "mutants"))),
                "PYTHONDONTWRITEBYTECODE": "" if compiled and not part.is_c else "1",  # their tests are links
            },
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self._running = process
        try:
            return process.wait(limit_s)
        except subprocess.TimeoutExpired:
            return None
        finally:
            self.stop()
            process.wait()
            self._running = None

    def stop(self) -> None:
        """End what runs, including its children."""
        if self._running:
            with suppress(ProcessLookupError):
                os.killpg(self._running.pid, signal.SIGKILL)

    @contextmanager
    def with_fault(self, chosen: Chosen) -> Iterator[None]:
        """Replace the module by the mutant."""
        module = self.capture / chosen.part.module
        Path(importlib.util.cache_from_source(str(module))).unlink(missing_ok=True)
        module.write_text(chosen.mutated)
        try:
            yield
        finally:
            module.write_text(chosen.source)


def all_of(parts: Iterable[Part]) -> list[Chosen]:
    """Return all mutants."""
    sources = {part: (CAPTURE / part.module).read_text() for part in parts}
    return [
        Chosen(part, source, mutant)
        for part, source in sources.items()
        for mutant in (making_c if part.is_c else making).mutants(source, part.functions)
    ]


def named(names: list[str]) -> list[Chosen]:
    """Return all mutants of folders, of modules, or of lines such as sistap/tap/records/framer.py:219."""
    found = []
    for name in names:
        module, _, line = name.partition(":")
        parts = [part for part in PARTS if module in part.module]
        found += [one for one in all_of(parts) if line in ("", str(one.mutant.line))]
    return found


def sample(every: Iterable[Chosen], count: int, seed: int) -> list[Chosen]:
    """Choose so many, by what each one is itself: a change of other code does not move the choice."""
    return sorted(every, key=lambda one: _by_itself(one, seed))[:count]


def _by_itself(one: Chosen, seed: int) -> bytes:
    return hashlib.sha256(f"{seed} {Path(one.part.module).name} {one.mutant.key(one.source)}".encode()).digest()


def usual_times(copy: Copy, parts: Iterable[Part]) -> dict[tuple[str, ...], float]:
    """Run the tests of each part without a fault; return how long they take. Raise Broken if they fail."""
    times = {}
    for tests, part in sorted({part.tests: part for part in parts}.items()):
        begun = time.monotonic()
        if code := copy.run(part, compiled=True):
            raise Broken(f"pytest ends with {code} for {' '.join(tests)} without any fault: make them pass first")
        times[tests] = time.monotonic() - begun
    return times


def fate(copy: Copy, chosen: Chosen, usual_s: float) -> Fate:
    """Run the tests on a mutant. Broken if they cannot be run."""
    with copy.with_fault(chosen):
        code = copy.run(chosen.part, PATIENCE * usual_s + PATIENCE_S)
    if code is None:
        return Fate.NO_END
    if code > INTERNAL:
        raise Broken(f"pytest ends with {code} for {' '.join(chosen.part.tests)}")
    return Fate.NOT_CAUGHT if code == SURVIVED else Fate.CAUGHT


def fates(all_chosen: list[Chosen], folder: Path, workers: int) -> Counter[Fate]:
    """Try all mutants, with as many workers; print those that no test catches, and count all."""
    first = Copy(folder / "0")
    times = usual_times(first, [chosen.part for chosen in all_chosen])
    copies = [first, *(Copy(folder / str(number), first.capture) for number in range(1, workers))]
    free: queue.SimpleQueue[Copy] = queue.SimpleQueue()
    for copy in copies:
        free.put(copy)

    def try_one(chosen: Chosen) -> Fate:
        copy = free.get()
        try:
            found = fate(copy, chosen, times[chosen.part.tests])
        finally:
            free.put(copy)
        if found is Fate.NOT_CAUGHT:
            print(f"not caught: {chosen}", flush=True)
        return found

    pool = ThreadPoolExecutor(workers)
    try:
        return Counter(pool.map(try_one, all_chosen))
    finally:  # also after Ctrl-C
        pool.shutdown(wait=False, cancel_futures=True)
        for copy in copies:
            copy.stop()
        pool.shutdown()


def positive(text: str) -> int:
    """Parse a number above 0."""
    if int(text) < 1:
        raise ValueError
    return int(text)


def arguments() -> argparse.Namespace:
    """Parse the command line; `chosen` are the mutants to try."""
    parser = argparse.ArgumentParser(
        description=DESCRIPTION, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=secrets.randbelow(10_000), help="which mutants; default: any")
    parser.add_argument("--count", type=positive, help=f"how many; default: {COUNT}, of those named all")
    parser.add_argument("--workers", type=positive, default=WORKERS, help=f"how many at a time; default: {WORKERS}")
    parser.add_argument("--enough", type=int, default=ENOUGH, help=f"%% below which it fails; default: {ENOUGH}")
    parser.add_argument("of", nargs="*", help="of these folders, modules or lines, such as records/framer.py:219")
    asked = parser.parse_args()
    every = named(asked.of) if asked.of else all_of(PARTS)
    asked.chosen = sample(every, asked.count or (len(every) if asked.of else COUNT), asked.seed)
    if not asked.chosen:
        parser.error(f"nothing can be changed in {' '.join(asked.of)}: covering.py has the modules")
    return asked


def main() -> int:
    """Make mutants, print those that survive and the share caught."""
    asked = arguments()
    count = len(asked.chosen)
    begun = time.monotonic()
    print(f"{count} mutants, --seed {asked.seed}", flush=True)
    try:
        with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
            counted = fates(asked.chosen, Path(folder), asked.workers)
    except (Broken, KeyboardInterrupt) as broken:
        print(f"mutants: {str(broken) or 'interrupted'}", file=sys.stderr)
        return 2
    caught = count - counted[Fate.NOT_CAUGHT]
    took = f"{counted[Fate.NO_END]} of them as their tests did not end; {time.monotonic() - begun:.0f} s"
    print(f"{caught} of {count} mutants caught: {caught / count:.1%} (goal {GOAL} %), {took}")
    return 0 if 100 * caught >= asked.enough * count else 1


if __name__ == "__main__":
    sys.exit(main())
