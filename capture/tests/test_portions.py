# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report` of files too large to be read together: all is as if they were."""

from __future__ import annotations

import errno
import gzip
import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import planted
import pytest
from no_tap import NoTap

from sistap import cli
from sistap.dissected.captures import portions, reading
from sistap.dissected.captures.portions import Portion, in_turn
from sistap.dissected.episodes.engine import Engine
from sistap.dissected.packets.dissection import Dissection
from sistap.dissected.packets.kept import Span
from sistap.dissected.wireshark.tshark import Tshark
from sistap.tap.files import pcapng
from sistap.tap.files.output import FileLimits, Output
from sistap.tap.files.writer import PcapngWriter
from sistap.tap.records.counters import Counters
from sistap.tap.terminal.exits import NotCaptured, Refusal

PORT = pcapng.Interface(252, "bus")
PIECES = 6


def pieces(night: Path, folder: Path) -> list[Path]:
    """Cut a capture between any two packets. No file says what was told before."""
    heading = [pcapng.section_header("", ""), pcapng.interface_description(PORT)]
    packets = list(reading.packets(night))
    ends = [len(packets) * number // PIECES for number in range(PIECES + 1)]
    files = [folder / f"piece-{number}.pcapng" for number in range(PIECES)]
    for file, (begin, end) in zip(files, pairwise(ends), strict=True):
        blocks = [pcapng.enhanced_packet(0, one.time_ns or 0, one.data) for one in packets[begin:end]]
        file.write_bytes(b"".join([*heading, *blocks]))
    return files


def ring(night: Path, folder: Path) -> list[Path]:
    """Write a capture again, as several files. Each but the first begins with what was told before."""
    output = Output(str(folder / "ring.pcapng"), FileLimits(size=night.stat().st_size // PIECES, several=True))
    first, *rest = reading.records(night)
    writer = PcapngWriter(output, {0: PORT}, Counters())
    writer.begin(first)
    for record in rest:
        writer.write(record)
    output.close()
    return sorted(folder.iterdir())


@pytest.fixture(scope="module")
def night(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return planted.play(tmp_path_factory.mktemp("night") / "night.pcapng")


def alone(night: Path, _folder: Path) -> list[Path]:
    """Leave it as it is: one file."""
    return [night]


@pytest.fixture(params=[pieces, ring, alone])
def files(night: Path, tmp_path: Path, request: pytest.FixtureRequest) -> list[Path]:
    found: list[Path] = request.param(night, tmp_path)
    return found


def largest(files: Sequence[Path]) -> int:
    return max(file.stat().st_size for file in files)


def reported(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> dict[str, Any]:
    capsys.readouterr()
    assert cli.main(["report", "--format", "json", *map(str, arguments)]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def happened(report: Mapping[str, Any]) -> list[Sequence[Any]]:
    """Return what a person is told."""
    names = ("kind", "severity", "station", "parameter", "from", "to", "packets", "text")
    return [[one[name] for name in names] for one in report["episodes"]]


@pytest.mark.parametrize("options", [[], ["--since", "2026-03-14T21:03:00Z", "--window", "1+2"]])
def test_portions_are_judged_as_one(
    night: Path,
    files: list[Path],
    options: list[str],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = reported(capsys, *options, *files)
    monkeypatch.setattr(portions, "TOGETHER", largest(files) // (PIECES if files == [night] else 1))
    cut = reported(capsys, *options, *files)
    assert happened(whole)
    assert happened(cut) == happened(whole)
    for name in ("capture", "packets", "records", "telegrams", "not_judged"):
        assert cut[name] == whole[name]
    for one, other in zip(cut["events"], whole["events"], strict=True):
        assert one == other | {"time_s": pytest.approx(other["time_s"], abs=1e-5)}
    assert cut["duration_s"] == pytest.approx(whole["duration_s"], abs=1e-5)
    assert cut["limits"] == whole["limits"]
    assert len(cut["windows"]) == len(whole["windows"]) > 0
    for one, other in zip(cut["windows"], whole["windows"], strict=True):
        assert one["packets"] == other["packets"]
        assert one["start_s"] == pytest.approx(other["start_s"], abs=1e-5)


class OneAfterTheOther(NoTap):
    """tshark, each time with the next rows."""

    def __init__(self, *runs: Sequence[Mapping[str, str]]) -> None:
        self._runs = iter(runs)

    def lines(self, arguments: Sequence[str]) -> Iterator[str]:
        names = [name for option, name in pairwise(arguments) if option == "-e"]
        rows = [[row.get(name, "") for name in names] for row in next(self._runs)]
        return iter(["\t".join(row) for row in (names, *rows)])


def row(number: int, epoch_s: float, second: float, **own: str) -> dict[str, str]:
    named = {name.replace("__", "."): text for name, text in own.items()}
    return {"frame.number": str(number), "frame.time_epoch": str(epoch_s), "frame.time_relative": str(second)} | named


def test_numbers_and_seconds_go_on() -> None:
    """What was told before is counted nowhere. The load of less than a second is none."""
    command = row(2, 50.25, 0.25, sis__start="2", sis__bus__load="90")
    reaction = row(3, 52.5, 2.5, sis__start="2", sis__bus__load="40", sis__command_in="2")
    before = row(1, 50.0, 0.0, sertap__type="2", sertap__event="7", sertap__text="all TrS 50 ms")
    plain = row(4, 53.0, 3.0)
    tshark = OneAfterTheOther([row(1, 10.0, 0.0), row(2, 20.0, 10.0)], [before, command, reaction, plain])
    with Dissection(cast(Tshark, tshark), [Portion(Path("a")), Portion(Path("b"), told=1)]) as dissection:
        read = list(dissection.packets())
        again = list(dissection.again([Span(41.0, 43.0)]))
    times = [(1, 0.0), (2, 10.0), (3, 40.25), (4, 42.5), (5, 43.0)]
    assert [(packet.number, packet.time_s) for packet in read] == times
    assert again == read[3:]
    assert read[4].alike is read[0].alike  # what rows have in common is worked out once, also for a month
    first, second = (packet.telegrams[0] for packet in read[2:4])
    assert (first.load_percent, second.load_percent) == (None, 40.0)
    assert second.command_in == 3


def test_a_silence_that_began_in_the_portion_before_is_no_jump_of_the_clock() -> None:
    """The first record of a portion says only that it was longer than 4.29 s."""
    first = row(1, 10.0, 0.0, sertap__type="0", sertap__interval="0.1\x1f0.001")
    second = row(1, 70.0, 0.0, sertap__type="0", sertap__interval="4.294967295\x1f0.001")
    engine = Engine()
    tshark = cast(Tshark, OneAfterTheOther([first], [second]))
    with Dissection(tshark, [Portion(Path("a")), Portion(Path("b"))]) as dissection:
        for packet in dissection.packets():
            engine.add(packet)
    assert engine.finish() == []


def test_a_foreign_file_is_told_before_anything_is_read(night: Path, tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.pcap"
    foreign.write_bytes(b"\xd4\xc3\xb2\xa1" + bytes(20))
    with pytest.raises(NotCaptured, match="foreign.pcap cannot be read with others"):
        next(in_turn([night, foreign], largest([night]), pytest.fail))


def test_files_that_are_deleted_meanwhile_are_told(
    night: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(portions, "_AROUND", 10)
    first, second, third = pieces(night, tmp_path)[:3]
    said: list[str] = []
    read = in_turn([first, second, third], largest([first, second, third]), said.append)
    next(read)
    third.unlink()
    assert next(read).told > 0
    assert next(read, None) is None
    assert [text.partition(": ")[0] for text in said] == [str(third)]


def test_no_room_for_a_piece(night: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(kind: int, body: bytes) -> bytes:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(pcapng, "block", full)
    with pytest.raises(Refusal, match=r"cannot keep a part of the capture: .*; make room, .* TMPDIR"):
        next(in_turn([night], night.stat().st_size // PIECES, pytest.fail))


def test_a_large_file_that_is_cut_off_says_so(night: Path, tmp_path: Path) -> None:
    half = tmp_path / "half.pcapng"
    half.write_bytes(night.read_bytes()[: night.stat().st_size // 2 + 1])
    said: list[str] = []
    whole = [packet.data for packet in reading.packets(half)]
    read: list[list[bytes]] = []
    for portion in in_turn([half], half.stat().st_size // PIECES, said.append):
        numbered = enumerate(reading.packets(portion.path), 1)
        read.append([packet.data for number, packet in numbered if portion.owns(number)])
    assert [packet for portion in read for packet in portion] == whole
    assert len(read) >= PIECES - 1
    assert said == [f"{half}: only what comes before the damage: {half} is cut off"]


def large(path: Path, count: int, size: int) -> Path:
    """Write packets of another program, each so large, compressed."""
    head = pcapng.section_header("", "") + pcapng.interface_description(pcapng.Interface(1, "eth"))
    packet = pcapng.enhanced_packet(0, 10**18, bytes(size))
    with gzip.open(path, "wb") as file:
        file.write(head)
        for _ in range(count):
            file.write(packet)
    return path


def test_large_packets_do_not_fill_the_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is beside a seam is bounded in bytes, too."""
    monkeypatch.setattr(portions, "_AROUND_BYTES", 300_000)
    captures = [large(tmp_path / f"{name}.pcapng.gz", 20, 100_000) for name in "ab"]
    sizes = [portion.path.stat().st_size for portion in in_turn(captures, 200_000, pytest.fail)]
    assert len(sizes) > 5 and max(sizes) < 200_000 + 2 * 300_000 + 300_000


def test_what_was_told_is_known_after_a_capture_that_was_compressed_well(
    tmp_path: Path, night: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody knows before how large it is, and that it is cut."""
    monkeypatch.setattr(portions, "_AROUND", 1)
    noise = pcapng.enhanced_packet(0, 2 * 10**18, bytes(100_000))
    packed = tmp_path / "night.pcapng.gz"
    packed.write_bytes(gzip.compress(night.read_bytes() + 100 * noise))
    more = large(tmp_path / "more.pcapng.gz", 1, 10)
    most = 13 * (packed.stat().st_size + more.stat().st_size)
    told = [portion.told for portion in in_turn([packed, more], most, pytest.fail)]
    assert len(told) > 1 and told[-1] > 1
