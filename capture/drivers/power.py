# SPDX-License-Identifier: GPL-2.0-or-later
"""Cuts the power while a capture is written to a disk: the file must have the beginning of what came.

QEMU is killed, so everything that the guest's kernel had not written yet is lost. Another guest then examines the disk.
It booted earlier and was saved before the disk was plugged in, so it has no cached data of the disk.
"""

from __future__ import annotations

import subprocess
import time
from bisect import bisect_right
from pathlib import Path
from typing import NamedTuple

import table
from checks import Captured
from machine import Guest, eventually

from drivers import SocketLine, received

PULLS = 10
FIRST_S, STEP_S = 4.5, 0.13  # time until the power cut, and its increase each time
PROMISED_S = 1.0  # the README: at most the characters of the last second
OF_SYNC_S = 2.0  # and those that came during the slow write of the emulated computer
_SLACK = (
    f"At most the last {PROMISED_S + OF_SYNC_S:g} s were missing: 1 s, the most that `sistap` may lose, "
    f"and {OF_SYNC_S:g} s because the emulated disk writes slowly."
)
CHARACTERS_S = 870  # at 9600 Bd
UNBROKEN = "silence:400"  # no such silence comes: a frame is cut when it is long enough
PACE_S = 0.1  # interval between looks: constant looking would leave no time to the capture
BURST = bytes(range(256)) * 256  # no stretch of 87 characters repeats in a row

DISK_MB = 32
# Nothing needs to reach this computer's disk: only the guest dies.
DISK = {"driver": "file", "node-name": "disk", "filename": "disk", "cache": {"no-flush": True}}
PORT, FILE = "/dev/ttyS1", "/mnt/capture.pcapng"
DEVICES = "-chardev socket,id=isa0,path=isa0,server=on,wait=off -device isa-serial,chardev=isa0,index=1".split()


class Pull(NamedTuple):
    """What had come when the power was cut."""

    played: bytes
    times_ns: list[int]  # of the guest's clock, at which ...
    counts: list[int]  # ... this many characters had come

    def before(self, seconds: float) -> int:
        """Return how many had come that long before the end."""
        at = bisect_right(self.times_ns, self.times_ns[-1] - int(seconds * 1e9))
        return self.counts[at - 1] if at else 0


def pulled(folder: Path, runs_on: str) -> str:
    """Cut the power again and again; return the result in words."""
    try:
        _pull_all(folder, runs_on)
    except (AssertionError, OSError) as error:
        print(f"drivers: FAILED plug: {error}", flush=True)
        return f"{table.FAILED}."
    return f"{table.GOOD}. Each file held the characters in their order, from the first on. {_SLACK}"


def _pull_all(folder: Path, runs_on: str) -> None:
    """Raise AssertionError if a file lacks characters."""
    (folder / "disk").write_bytes(b"")
    subprocess.run(["/sbin/mke2fs", "-q", "-F", "-t", "ext4", "disk", f"{DISK_MB}M"], cwd=folder, check=True)
    _save(folder, runs_on)
    last: Pull | None = None
    for number in range(PULLS + 1):
        guest = _restored(folder, runs_on)
        try:
            if last:
                lacking = _judged(guest, last)
                print(f"drivers: good   plug pulled, {lacking} of {len(last.played)} characters lack", flush=True)
            if number < PULLS:
                last = _until_pulled(guest, FIRST_S + number * STEP_S)
        finally:
            guest.kill()


def _save(folder: Path, runs_on: str) -> None:
    """Boot a guest, and save its state to a file."""
    guest = Guest(folder, runs_on, DEVICES)
    try:
        guest.monitor("stop")
        guest.monitor("migrate", uri="exec:cat >state")
        eventually(lambda: guest.monitor("query-migrate")["status"] == "completed", lambda: "it cannot be saved")
    finally:
        guest.kill()


def _restored(folder: Path, runs_on: str) -> Guest:
    """Continue from that state, with the disk mounted."""
    guest = Guest(folder, runs_on, [*DEVICES, "-incoming", "exec:cat state"])
    try:
        _mount(guest)
    except BaseException:
        guest.kill()
        raise
    return guest


def _mount(guest: Guest) -> None:
    eventually(lambda: guest.monitor("query-status")["status"] in ("paused", "running"), lambda: "it does not go on")
    guest.monitor("cont")
    guest.monitor("blockdev-add", **DISK)
    guest.monitor("device_add", driver="virtio-blk-pci", drive="disk", id="virtual-disk")
    eventually(lambda: bool(guest.find("/dev/vda")), lambda: "the disk is not found")
    done = guest.run("mount", "/dev/vda", "/mnt")
    assert done.code == 0, done.said


def _until_pulled(guest: Guest, seconds: float) -> Pull:
    """Capture to the disk while characters come, for the given time; then cut the power."""
    guest.run("rm", "-f", FILE)
    guest.run("chmod", "777", "/mnt")
    guest.run("sync")
    line = SocketLine(guest, "isa0", PORT)
    # Without real-time priority: on an emulated processor the capture would starve the kernel's threads.
    program = guest.start("sistap", "capture", "--force", "-i", PORT, "--framing", UNBROKEN, "-w", FILE, user="tap")
    program.until("capturing on")
    first = received(guest, PORT)
    pull = Pull(b"", [], [])
    begun = time.monotonic()
    played = b""
    while (elapsed_s := time.monotonic() - begun) < seconds:
        part = BURST[len(played) : int(elapsed_s * CHARACTERS_S)]
        line.play(part)
        played += part
        pull.times_ns.append(guest.agent(do="clock")["ns"])
        pull.counts.append(received(guest, PORT) - first)
        time.sleep(PACE_S)
    guest.kill()
    return pull._replace(played=played)


def _judged(guest: Guest, pull: Pull) -> int:
    """Check the disk; return how many characters it lacks."""
    found = Captured.of(guest.read(FILE)).data() if guest.find(FILE) else b""
    assert pull.played.startswith(found), f"what is in the file ({len(found)} characters) is not what came"
    needed = pull.before(PROMISED_S + OF_SYNC_S)
    assert needed, "nothing came"
    assert (
        len(found) >= needed
    ), f"{len(found)} characters are in the file, but {needed} had come {PROMISED_S + OF_SYNC_S:g} s before"
    return pull.counts[-1] - len(found)
