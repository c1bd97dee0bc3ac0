# SPDX-License-Identifier: GPL-2.0-or-later
"""Output of tshark line by line; a shell plays tshark."""

import errno
import os
import shutil
from pathlib import Path

import pytest

from sistap.tshark import Tshark, TsharkError


def test_lines_come_while_it_runs_and_the_rest_is_not_waited_for() -> None:
    with Tshark("sh") as shell:
        lines = shell.lines(["-c", "echo first; exec sleep 1000"])
        assert next(lines) == "first"
        lines.close()  # which ends the program


def test_what_it_said_comes_after_the_last_line() -> None:
    with Tshark("sh") as shell:
        lines = shell.lines(["-c", "echo one; echo why >&2; echo two; exit 3"])
        assert [next(lines), next(lines)] == ["one", "two"]
        with pytest.raises(TsharkError, match="^why$"):
            next(lines)


def test_much_on_stderr_does_not_block_it() -> None:
    with Tshark("sh") as shell:
        flood = (
            "i=0; while [ $i -lt 5000 ]; do echo 'a line as long as a pipe is deep, in the end' >&2; i=$((i+1)); done"
        )
        assert list(shell.lines(["-c", f"{flood}; echo done"])) == ["done"]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root needs a copy")
def test_no_room_for_the_copy(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(source: Path, copy: Path) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", str(source))

    with Tshark("sh") as shell:
        monkeypatch.setattr(shutil, "copyfile", full)
        with pytest.raises(TsharkError, match=r"no room for a copy of day\.pcapng.* TMPDIR$"):
            shell.output("-r", "day.pcapng")
