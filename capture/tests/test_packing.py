# SPDX-License-Identifier: GPL-2.0-or-later
"""Compressed files of a recorder: the same bytes, opened by tshark and by sistap as they are."""

from __future__ import annotations

import errno
import gzip
import json
import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import planted
import pytest
from portable import fifos, keep, modes

from sistap import cli
from sistap.commands.recorder import retention
from sistap.commands.recorder.retention import pack
from sistap.dissected.captures.joining import check_captures
from sistap.dissected.captures.reading import packets
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng

HOUR_NS = 3600 * 10**9


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return planted.play(tmp_path_factory.mktemp("night") / "night.pcapng")


@pytest.fixture
def folder(tmp_path: Path, capture: Path) -> Path:
    """Return a ring of two files: a night, and the same once more an hour later."""
    (tmp_path / "ring_00001_20260314220000.pcapng").write_bytes(capture.read_bytes())
    night = list(packets(capture))
    blocks = [pcapng.section_header("", ""), pcapng.block(pcapng.INTERFACE_DESCRIPTION, night[0].interface)]
    blocks += [pcapng.enhanced_packet(0, (one.time_ns or 0) + HOUR_NS, one.data) for one in night]
    (tmp_path / "ring_00002_20260314230000.pcapng").write_bytes(b"".join(blocks))
    return tmp_path


def ring(folder: Path) -> retention.Retention:
    return retention.ring(folder, None, lambda said: pytest.fail(said), tuple)


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_smaller_and_has_the_same_bytes(folder: Path, capture: Path, tshark: Tshark) -> None:
    packed = pack(folder / "ring_00001_20260314220000.pcapng")
    assert gzip.decompress(packed.read_bytes()) == capture.read_bytes()
    assert packed.stat().st_size < capture.stat().st_size / 2.5
    assert names(folder) == [packed.name, "ring_00002_20260314230000.pcapng"]
    count = ("-T", "fields", "-e", "frame.number")
    assert tshark.output("-r", str(packed), *count) == tshark.output("-r", str(capture), *count)


def test_the_newest_file_of_a_ring_is_left_alone(folder: Path) -> None:
    for path in ring(folder).complete():
        pack(path)
    assert names(folder) == ["ring_00001_20260314220000.pcapng.gz", "ring_00002_20260314230000.pcapng"]
    assert ring(folder).complete() == []
    retention.ring(folder, 1, lambda said: pytest.fail(said), tuple).prune()
    assert names(folder) == ["ring_00002_20260314230000.pcapng"]


@fifos
@pytest.mark.attack("a pipe or a link among the files that a recorder compresses", "left alone; never waited for")
def test_what_is_no_file_is_not_compressed(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    secret = tmp_path_factory.mktemp("root") / "secret"
    secret.write_bytes(b"secret")
    os.mkfifo(folder / "ring_00001_20200101000000.pcapng")
    (folder / "ring_00001_20200101000001.pcapng").symlink_to(secret)
    assert [path.name for path in ring(folder).complete()] == ["ring_00001_20260314220000.pcapng"]


@modes
@pytest.mark.skipif(getattr(os, "geteuid", lambda: 1)() != 0, reason="only root gives files away")
@pytest.mark.attack("a file made from a private capture", "whoever may not read the capture may not read it")
def test_a_compressed_file_is_for_no_other_group(folder: Path) -> None:
    path = folder / "ring_00001_20260314220000.pcapng"
    os.chown(path, 0, 12345)
    path.chmod(0o640)
    assert pack(path).stat().st_mode & 0o777 == 0o600


def told(capsys: pytest.CaptureFixture[str], *captures: Path) -> Any:
    capsys.readouterr()
    assert cli.main(["report", "--format", "json", *map(str, captures)]) == 0
    return json.loads(capsys.readouterr().out)["episodes"]


def test_the_report_of_a_folder_reads_both(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = told(capsys, folder)
    pack(folder / "ring_00001_20260314220000.pcapng")
    assert told(capsys, folder) == before != []


def test_a_file_is_compressed_after_a_folder_was_listed(folder: Path) -> None:
    first, _ = check_captures([folder], pytest.fail)
    before = list(packets(first))
    pack(first)
    assert list(packets(first)) == before


def test_a_recorder_that_was_killed_while_it_compressed(folder: Path) -> None:
    """A part is written again. A file that was not yet removed counts once."""
    first = folder / "ring_00001_20260314220000.pcapng"
    (folder / f".{first.name}.gz").write_bytes(b"\x1f\x8b")
    whole = first.read_bytes()
    packed = pack(first)
    first.write_bytes(whole)
    assert check_captures([folder], pytest.fail) == [first, folder / "ring_00002_20260314230000.pcapng"]
    assert pack(first) == packed
    assert gzip.decompress(packed.read_bytes()) == whole


def test_what_somebody_reads_in_windows_is_compressed_later(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """There it cannot be removed meanwhile. Until then it is there once."""
    path = folder / "ring_00001_20260314220000.pcapng"
    before = names(folder)
    with monkeypatch.context() as reading:
        keep(reading, path)
        with pytest.raises(PermissionError):
            pack(path)
        assert names(folder) == before
    pack(path)
    assert names(folder) == [f"{path.name}.gz", before[1]]


def test_a_compressed_file_that_is_cut_off_ends_before(folder: Path) -> None:
    packed = pack(folder / "ring_00001_20260314220000.pcapng")
    whole = list(packets(packed))
    packed.write_bytes(packed.read_bytes()[: packed.stat().st_size // 2])
    cut = list(packets(packed))
    assert 0 < len(cut) < len(whole) and cut == whole[: len(cut)]


# A byte of a file and of its compression: a check sum at the end, the head, and the first block inside.
DAMAGE = {"sum": -6, "method": 2, "content": 60}


@pytest.mark.attack("a compressed capture is damaged", "a message names it; what comes before the damage is read")
@pytest.mark.parametrize("place", DAMAGE.values(), ids=DAMAGE)
def test_a_compressed_file_that_is_damaged(folder: Path, place: int, capfd: pytest.CaptureFixture[str]) -> None:
    packed = pack(folder / "ring_00001_20260314220000.pcapng")
    content = bytearray(packed.read_bytes())
    content[place] ^= 0xFF
    packed.write_bytes(content)
    for command in ("report --format text", "log"):
        code = cli.main([*command.split(), str(packed)])
        said = capfd.readouterr().err
        assert code in (0, 1, 2) and said.count("\n") == 1 and str(packed) in said
    code = cli.main(["report", "--format", "text", str(folder)])
    said = capfd.readouterr().err
    assert code in (0, 2) and said.count("\n") == 1 and str(packed) in said


@pytest.mark.parametrize("room", [True, False], ids=["said", "not said"])
def test_a_disk_that_becomes_full_leaves_the_file(folder: Path, room: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether the system says before how much room there is (a quota says nothing), or not."""
    path = folder / "ring_00001_20260314220000.pcapng"
    before = path.read_bytes()
    pieces = []

    class Disk(gzip.GzipFile):
        def write(self, data: Any) -> int:
            pieces.append(data)
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(gzip, "GzipFile", Disk)
    if room:
        monkeypatch.setattr(retention, "disk_usage", lambda _: SimpleNamespace(free=len(before) - 1))
    with pytest.raises(OSError, match="No space left on device"):
        pack(path)
    assert path.read_bytes() == before and len(names(folder)) == 2
    assert bool(pieces) != room


def test_a_file_that_cannot_be_compressed_stays(folder: Path) -> None:
    path = folder / "ring_00001_20260314220000.pcapng"
    (folder / f"{path.name}.gz").mkdir()
    before = path.read_bytes()
    with pytest.raises(OSError):
        pack(path)
    assert path.read_bytes() == before
    assert [name for name in names(folder) if name.startswith(".")] == []
