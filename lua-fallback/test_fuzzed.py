# SPDX-License-Identifier: GPL-2.0-or-later
"""sis.lua dissects the kept inputs of the plugin's fuzzer without an error."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import parity
from make import HERE
from sistap.dissected.captures import reading
from sistap.dissected.wireshark.tshark import Tshark

FUZZ = HERE / "fuzz"
sys.path.insert(0, str(FUZZ))

import corpus  # noqa: E402

KEPT = sorted(FUZZ.glob("corpus/*"))
USER0 = r'uat:user_dlts:"User 0 (DLT=147)","sis","0","","0",""'
OPTIONS = ("-o", USER0, "-d", "rtacser.data,sis", "-d", "tcp.port==4200,sis")


def packets(paths: list[Path]) -> int:
    """Count the packets of inputs."""
    return sum(len(corpus.unpack(path.read_bytes()).packets) for path in paths)


@pytest.mark.parametrize(
    "more",
    [(), pytest.param(("-2", "-o", "sis.tza_ms:3", "-o", "sis.trs_ms:30"), marks=pytest.mark.thorough)],
    ids=["one_pass", "two_passes"],
)
def test_no_error(more: tuple[str, ...], script: Tshark, tmp_path: Path) -> None:
    capture = tmp_path / "fuzzed.pcapng"
    capture.write_bytes(corpus.capture(KEPT))
    for view in (parity.packets, parity.listed):
        assert len(view(script, capture, *OPTIONS, *more)) == packets(KEPT) > 0


def test_every_capture_gives_seeds(tmp_path: Path) -> None:
    """Every capture has seeds, and those are its packets in order."""
    corpus.seeds(tmp_path)
    assert (tmp_path / "specification-0").exists()
    sections = corpus.unpack((tmp_path / "specification-0").read_bytes())
    originals = [packet.data for packet in reading.packets(HERE / "specification.pcapng")]
    made = tmp_path / "again.pcapng"
    made.write_bytes(corpus.section(sections))
    assert [packet.data for packet in reading.packets(made)] == originals[: corpus.PER_SEED]


def test_an_input_and_its_bytes() -> None:
    packet = corpus.Packet(corpus.TCP, 3, corpus.QUIRK_CUT, -1, b"\2\0")
    sequence = corpus.Sequence(0x01020304, 5, 6, [packet])
    packed = corpus.pack(sequence)
    assert packed == bytes.fromhex("04030201 05000000 06  0a 03 01 ffffffffffffffff 02000000 0200")
    assert corpus.unpack(packed) == sequence
    assert corpus.unpack(packed[:-1]).packets == []
