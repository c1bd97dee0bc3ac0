# SPDX-License-Identifier: GPL-2.0-or-later
"""Logs of other things: no telegram is found in them, and nobody is accused. They are drawn from a seed."""

from __future__ import annotations

import json
import uuid
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from sistap import cli
from sistap.commands.annotate.annotating import Passage
from sistap.commands.annotate.choosing import AnyReader
from sistap.commands.annotate.textlog import lines
from sistap.tap.terminal.exits import DONE, USAGE

_WORDS = "start of job done failed connect timeout port read write session user cache error 0x1f retry device".split()


def _stamp(draw: Random) -> str:
    return f"2026-03-{draw.randint(1, 28):02} {draw.randint(0, 23):02}:{draw.randint(0, 59):02}:07"


def _syslog(draw: Random) -> str:
    words = " ".join(draw.choices(_WORDS, k=draw.randint(2, 9)))
    return f"Mar {draw.randint(1, 28):2} 10:{draw.randint(0, 59):02}:07 host app[{draw.randint(1, 9999)}]: {words}"


def _gps(draw: Random) -> str:
    north, east = draw.random() * 60, draw.random() * 60
    said = f"GPRMC,{draw.randint(0, 235959):06}.00,A,48{north:07.4f},N,011{east:07.4f},E,0.02,77"
    total = 0
    for character in said:
        total ^= ord(character)
    return f"${said}*{total:02X}"


def _modbus(draw: Random) -> str:
    data = bytes(
        [draw.choice([1, 2, 5, 17]), draw.choice([3, 4, 6, 16]), 0, draw.randint(0, 40), 0, draw.randint(1, 9)]
    )
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    frame = data + crc.to_bytes(2, "little")
    return f"{_stamp(draw)}.{draw.randint(0, 999):03} {draw.choice(['TX', 'RX'])}: {frame.hex(' ')}"


def _temperatures(draw: Random) -> str:
    values = (draw.choice([f"{draw.gauss(20, 9):.1f}", str(draw.randint(0, 60))]) for _ in range(9))
    return f"{_stamp(draw)},{','.join(values)}"


def _counts(draw: Random) -> str:
    values = (str(draw.randint(0, draw.choice([9, 30, 255]))) for _ in range(12))
    return draw.choice([" ", ", ", ";", "\t"]).join(values)


def _dump(draw: Random) -> str:
    data = draw.randbytes(16)
    shown = "".join(chr(byte) if 0x20 <= byte < 0x7F else "." for byte in data)
    return f"{draw.randrange(0, 1 << 20, 16):08x}  {data.hex(' ')}  |{shown}|"


def _mac(draw: Random) -> str:
    return f"{_stamp(draw)} dhcpd: lease 192.168.0.{draw.randint(1, 254)} to {draw.randbytes(6).hex(':')} via eth0"


def _uuid(draw: Random) -> str:
    request, digest = uuid.UUID(int=draw.getrandbits(128)), draw.getrandbits(160)
    return f"{_stamp(draw)} request {request} hash {digest:x} took {draw.randint(1, 99)} ms"


def _traceback(draw: Random) -> str:
    name, line, value = draw.choice(_WORDS), draw.randint(1, 300), draw.randint(0, 99)
    return f'  File "C:\\new\\{name}.py", line {line}, in f\n    x = b"\\x00" + {value}'


def _json(draw: Random) -> str:
    values = [draw.randint(0, 20) for _ in range(9)]
    return json.dumps({"id": draw.randint(0, 999), "values": values, "said": draw.choice(["\x02a", "é"])})


KINDS: list[Callable[[Random], str]] = [
    *(_syslog, _gps, _modbus, _temperatures, _counts, _dump, _mac, _uuid, _traceback, _json),
]


def drawn(seed: int) -> str:
    draw = Random(seed)
    kind = KINDS[seed % len(KINDS)]
    return "".join(f"{kind(draw)}\n" for _ in range(draw.randint(1, 60)))


def check(seed: int) -> None:
    text = drawn(seed)
    log = [*lines([text.encode()])]
    passage = Passage(AnyReader(log))
    for line in log:
        passage.feed(line)
    passage.end()
    assert passage.telegrams == 0, f"{seed}\n{text}"


@pytest.mark.parametrize("first", range(0, 100, 25))
def test_logs_of_other_things_have_no_telegram(first: int) -> None:
    for seed in range(first, first + 25):
        check(seed)


@pytest.mark.thorough
@pytest.mark.parametrize("first", range(0, 2000, 250))
def test_two_thousand_logs_of_other_things_have_no_telegram(first: int) -> None:
    for seed in range(first, first + 250):
        check(seed)


_ACCUSATIONS = ("cable", "wiring", "What to do", "checksum", "more line", ": '", "odd number")


@pytest.mark.parametrize("seed", range(len(KINDS)))
def test_logs_of_other_things_accuse_nobody(seed: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "x.txt"
    log.write_text(drawn(seed))
    code = cli.main(["annotate", str(log)])
    said = capfd.readouterr()
    if "no bytes were found" in said.err:
        assert (code, said.err.count("\n")) == (USAGE, 1)  # it may say why
        return
    assert code == DONE
    added = [line for line in said.out.splitlines() if "^--" in line] + said.err.splitlines()
    assert not [line for line in added if any(word in line for word in _ACCUSATIONS)]
