# SPDX-License-Identifier: GPL-2.0-or-later
"""Signals end a command once, wherever it is, and leave neither files nor programs behind."""

from __future__ import annotations

import _thread
import operator
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import FrameType

import pytest

from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.common import temporary
from sistap.tap.terminal.stop import AGAIN_S, Stop, Stopped, held

pytestmark = pytest.mark.tap

NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
BURST = NUMBERS * 10


@pytest.mark.parametrize("number", NUMBERS)
def test_thirty_signals_end_it_once(number: signal.Signals) -> None:
    before = [signal.getsignal(each) for each in NUMBERS]
    closed = False
    with pytest.raises(Stopped), Stop() as stop:
        try:
            signal.raise_signal(number)
            pytest.fail("the first one did not end it")
        finally:
            for each in BURST:
                signal.raise_signal(each)
            closed = True
    assert stop.asked and closed
    assert [signal.getsignal(each) for each in NUMBERS] == before


def test_it_waits_for_the_end_of_what_must_not_be_torn() -> None:
    done = []
    with pytest.raises(Stopped), Stop():
        with held():
            with held():
                signal.raise_signal(signal.SIGINT)
                done.append("inner")
            done.append("outer")
        pytest.fail("it did not end then")
    assert done == ["inner", "outer"]


def test_who_looks_for_himself_is_not_torn() -> None:
    with Stop() as stop:
        stop.at_once = False
        assert not Stop.current().asked
        for number in BURST:
            signal.raise_signal(number)
        assert Stop.current().asked
    assert not Stop.current().asked


def test_one_that_a_library_swallows_comes_again() -> None:
    with pytest.raises(Stopped), Stop():
        with suppress(BaseException):
            signal.raise_signal(signal.SIGINT)
        time.sleep(60)  # which it ends


def test_a_thread_ends_what_waits() -> None:
    with pytest.raises(Stopped), Stop() as stop:
        threading.Thread(target=stop.ask).start()
        time.sleep(60)  # which it ends


def test_one_that_nobody_could_catch_comes_again(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Loud:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(Stopped), Stop():
        tell = sys.unraisablehook

        def tell_slowly(args: sys.UnraisableHookArgs) -> None:
            tell(args)
            time.sleep(0.05)  # a busy computer may go on with other processes here

        monkeypatch.setattr(sys, "unraisablehook", tell_slowly)
        Loud()
        time.sleep(60)  # which it ends
    assert capfd.readouterr() == ("", "")


def test_it_does_not_come_again_where_the_command_closes_things() -> None:
    closed = []
    with pytest.raises(Stopped), Stop():
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            with suppress(OSError):
                raise OSError
            try:
                raise OSError
            except OSError:
                time.sleep(3 * AGAIN_S)
            closed.append("slowly")
    assert closed == ["slowly"]


def test_it_reaches_a_command_whose_threads_all_wait() -> None:
    def signal_from_here() -> None:
        os.kill(os.getpid(), signal.SIGTERM)

    forever = threading.Event()
    with pytest.raises(Stopped), Stop():
        threading.Thread(target=forever.wait, daemon=True).start()
        threading.Thread(target=signal_from_here).start()
        forever.wait(60)
    forever.set()


def test_two_at_once_do_not_meet_in_c_code_that_goes_on() -> None:
    """`os.stat` multiplies, which looks for signals, three times before it looks for an exception."""
    two_then_stat = [
        *(partial(_thread.interrupt_main, number) for number in (signal.SIGINT, signal.SIGTERM)),
        partial(os.stat, "/"),
    ]
    with pytest.raises(Stopped), Stop():
        # All of it in C, so that no handler runs before.
        deque(map(operator.call, two_then_stat), maxlen=0)  # type: ignore[arg-type]


def test_other_failures_that_nobody_could_catch_are_told_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[type[BaseException]] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda args: told.append(args.exc_type))

    class Broken:
        def __del__(self) -> None:
            raise ValueError

    with Stop():
        Broken()
    assert told == [ValueError]


def test_what_nohup_ignores_is_ignored_and_what_a_script_ignores_is_not() -> None:
    """A script starts jobs with & so that they ignore SIGINT."""
    for number in (signal.SIGHUP, signal.SIGINT):
        signal.signal(number, signal.SIG_IGN)
    with pytest.raises(Stopped), Stop() as stop:
        signal.raise_signal(signal.SIGHUP)
        assert not stop.asked
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) == signal.SIG_IGN


def test_the_end_of_a_command_ends_a_process_for_good() -> None:
    stop = Stop()
    stop.begin()
    with stop:
        pass
    assert [signal.getsignal(number) for number in NUMBERS] == [signal.SIG_IGN] * 4


def test_during_the_imports_it_just_ends() -> None:
    text = (
        "import signal; from sistap.tap.terminal.stop import Stop; Stop().begin(); signal.raise_signal(15); print('on')"
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


# -- What a command that was stopped leaves behind: nothing -----------------------------------------------------------


def work() -> None:
    """Run tshark, played by a shell, and make files that must be removed again."""
    with Tshark("sh") as shell, temporary.folder() as folder:
        (folder / "file").touch()
        endless = shell.lines(["-c", "echo 1; exec sleep 1000"])
        assert next(endless) == "1"
        assert shell.output("-c", "echo 2") == "2\n"


@pytest.fixture
def leftovers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], list[str]]:
    """Return the files, and the new children of this process: other tests keep some."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.delenv("WIRESHARK_PLUGIN_DIR", raising=False)
    for number in NUMBERS:  # as it is again when a command has ended
        signal.signal(number, signal.SIG_IGN)

    def children() -> set[str]:
        # Only the main thread starts programs. Other threads may end while their files are read.
        return set(Path(f"/proc/self/task/{os.getpid()}/children").read_text().split())

    before = children()

    def find() -> list[str]:
        return [str(path) for path in tmp_path.rglob("*")] + sorted(children() - before)

    return find


class At:
    """Sends a signal to this process at its n-th counted line; 0: only counts the lines."""

    _WHERE = ("/sistap/", "/contextlib.py", "/subprocess.py", "/tempfile.py", "/weakref.py")

    def __init__(self, number: int) -> None:
        self.left = number

    def __call__(self, frame: FrameType, event: str, argument: object) -> At:
        if any(part in frame.f_code.co_filename for part in self._WHERE):
            self.left -= event in ("line", "call")
            if self.left == 0:
                self.left -= 1
                signal.raise_signal(signal.SIGINT)  # if this raises, Python traces no more
        return self

    def run(self) -> None:
        """Work, in a command."""
        stop = Stop()
        try:
            with stop:
                sys.settrace(self)
                work()
        except Stopped:
            stop.end()
        finally:
            sys.settrace(None)


@pytest.mark.thorough
def test_a_signal_at_any_line_leaves_nothing(leftovers: Callable[[], list[str]]) -> None:
    counting = At(0)
    counting.run()
    count = -counting.left
    for number in sorted(random.Random(1).sample(range(1, count), 60)):
        At(number).run()
        assert leftovers() == [], f"after a signal at line {number} of {count}"


@pytest.mark.thorough
def test_a_hail_of_signals_at_any_time_leaves_nothing(leftovers: Callable[[], list[str]]) -> None:
    main = threading.main_thread().ident
    assert main

    def hail(delay_s: float) -> None:
        time.sleep(delay_s)
        for number in (signal.SIGINT, signal.SIGTERM) * 15:
            signal.pthread_kill(main, number)
            time.sleep(0.001)

    for delay_ms in range(0, 80, 2):
        thread = threading.Thread(target=hail, args=(delay_ms / 1000,))
        stop = Stop()
        try:
            with stop:
                thread.start()  # before, all signals could come too early on a busy computer
                while True:
                    work()
        except Stopped:
            stop.end()
        thread.join()
        assert leftovers() == [], f"after signals from {delay_ms} ms on"
