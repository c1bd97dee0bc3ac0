# SPDX-License-Identifier: GPL-2.0-or-later
"""Zips that no logic analyser writes: each is read as it was meant, or refused in one line; no memory is filled."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from zipfile import ZIP_BZIP2, ZIP_DEFLATED, ZIP_LZMA, ZipFile, ZipInfo

import pytest
from commands import refused, run
from test_import_waves import TELEGRAMS, sr

_DIRECTORY = b"PK\x01\x02"  # begins an entry of a zip's directory
_OFFSET, _SIZE, _UNPACKED, _METHOD, _FLAGS, _VERSION = 42, 20, 24, 10, 8, 6  # places in such an entry
_LEFT = {"x.sr"}

Entries = Sequence[tuple[str, str | bytes]]


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A good one."""
    sr(tmp_path / "x.sr")
    return tmp_path / "x.sr"


def content(session: Path) -> dict[str, bytes]:
    with ZipFile(session) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def write(path: Path, entries: Entries, method: int = ZIP_DEFLATED) -> None:
    with warnings.catch_warnings(), ZipFile(path, "w", method) as archive:
        warnings.simplefilter("ignore")  # a name is there twice
        for name, data in entries:
            archive.writestr(name, data)


def is_refused(path: Path, *words: str) -> None:
    """Check that `import` names the file and what to do, and leaves nothing."""
    done = run(path.parent, "import", path.name, "-w", "out.pcapng")
    refused(done, 2, path.name, *words)
    assert len(done.stderr) < 1000
    assert {file.name for file in path.parent.iterdir()} == _LEFT


def patch(path: Path, entry: bytes, place: int, form: str, value: int) -> None:
    """Change what the directory says of an entry."""
    data = bytearray(path.read_bytes())
    at = data.rindex(entry, data.index(_DIRECTORY)) - 46
    struct.pack_into(form, data, at + place, value)
    path.write_bytes(data)


def version(path: Path) -> None:
    patch(path, b"logic-1-2", _VERSION, "<H", 84)


def name(path: Path) -> None:
    """A name that says it is UTF-8 and is not."""
    patch(path, b"version", _FLAGS, "<H", 0x800)
    data = path.read_bytes()
    path.write_bytes(data[: (at := data.rindex(b"version"))] + b"\xff" + data[at + 1 :])


def encrypted(path: Path) -> None:
    patch(path, b"logic-1-1", _FLAGS, "<H", 1)


def method(path: Path) -> None:
    patch(path, b"logic-1-1", _METHOD, "<H", 93)


def longer(path: Path) -> None:
    patch(path, b"logic-1-2", _SIZE, "<I", 0x7FFFFFFF)


def shorter(path: Path) -> None:
    patch(path, b"logic-1-1", _UNPACKED, "<I", 10)


def elsewhere(path: Path) -> None:
    patch(path, b"logic-1-1", _OFFSET, "<I", 7)


# An older Python goes by the end of the packed data, and reads it as it was meant.
LONGER = pytest.param(longer, marks=pytest.mark.skipif(not hasattr(ZipInfo, "_end_offset"), reason="Python is older"))
DAMAGES = [version, name, encrypted, method, LONGER, shorter, elsewhere]
UNPACKED = pytest.mark.attack("a session whose directory lies: sizes, places, names, methods", "refused in one line")


@UNPACKED
@pytest.mark.parametrize("damage", DAMAGES)
def test_a_directory_that_lies(session: Path, damage: Callable[[Path], None]) -> None:
    damage(session)
    is_refused(session, "again")


@pytest.mark.parametrize("damage", [version, name])
def test_other_commands_say_it_too(session: Path, damage: Callable[[Path], None]) -> None:
    damage(session)
    refused(run(session.parent, "log", "x.sr"), 2, "x.sr is a damaged zip: copy it again")


@pytest.mark.attack("a session with a part of its samples twice, or with a gap", "refused in one line")
@pytest.mark.parametrize("parts", [(1, 1, 2), (1, 3), (2, 3), (1, 2, 2)])
def test_parts_of_the_samples(session: Path, parts: Sequence[int]) -> None:
    """With one more or less, the times behind it would be wrong."""
    whole = content(session)
    entries = [(name, whole[name]) for name in ("version", "metadata")]
    write(session, [*entries, *((f"logic-1-{part}", whole["logic-1-1"]) for part in parts)])
    is_refused(session, "parts of its samples", "save it again")


def test_parts_in_any_order(session: Path) -> None:
    write(session, [*content(session).items()][::-1])
    assert run(session.parent, "import", "x.sr", "-w", "out.pcapng").returncode == 0
    assert TELEGRAMS[-1] in (session.parent / "out.pcapng").read_bytes()


METADATA: dict[str, str | bytes] = {
    "endless lines": "[device 1]\n" + "k\n" * 200_000,
    "endless keys": "[device 1]\n" + "".join(f"k{number}=\n" for number in range(200_000)),
    "an endless line": "x" * 3_000_000,
    "sections": "".join(f"[{number}]\n" for number in range(200_000)),
    "bytes": bytes(range(256)) * 9,
    "no rate": "[device 1]\nsamplerate=0\nprobe1=RO\n",
    "rate": f"[device 1]\nsamplerate={'9' * 60_000}\nprobe1=RO\n",
    "unitsize": "[device 1]\nsamplerate=1 MHz\nprobe1=RO\nunitsize=1000\n",
    "long unitsize": f"[device 1]\nsamplerate=1 MHz\nprobe1=RO\nunitsize={'9' * 60_000}\n",
    "no unitsize": "[device 1]\nsamplerate=1 MHz\nprobe1=RO\nunitsize=-1\n",
}


@pytest.mark.timeout(20)
@pytest.mark.attack("metadata of a session without an end, or with impossible numbers", "refused in one line")
@pytest.mark.parametrize("said", METADATA)
def test_metadata(session: Path, said: str) -> None:
    write(session, [*(content(session) | {"metadata": METADATA[said]}).items()])
    is_refused(session, "save them from sigrok-cli" if "unitsize" in said else "add --samplerate HZ")


def test_channels_of_one_name_are_two(session: Path) -> None:
    metadata = content(session)["metadata"].replace(b"probe2=DE", b"probe2=RO")
    write(session, [*(content(session) | {"metadata": metadata}).items()])
    done = run(session.parent, "import", "x.sr", "-w", "out.pcapng")
    assert "channel probe1" in done.stderr and "channel probe2 is a driver enable" in done.stderr


@pytest.mark.attack("a session packed so that a kilobyte can unpack to gigabytes at once", "refused in one line")
@pytest.mark.parametrize("method", [ZIP_BZIP2, ZIP_LZMA])
def test_only_what_unpacks_in_pieces_is_unpacked(session: Path, method: int) -> None:
    write(session, [*content(session).items()], method)
    is_refused(session, "packed", "save it again")


@pytest.mark.attack("what is no file among the entries of a session, or leads elsewhere", "nothing is unpacked")
def test_entries_that_are_no_files(session: Path) -> None:
    with ZipFile(session, "a") as archive:
        for number, kind in enumerate((0o120777, 0o010666, 0o060666, 0o040755)):  # a link, a pipe, a device, a folder
            entry = ZipInfo(f"../{number}")
            entry.external_attr = kind << 16
            archive.writestr(entry, "/etc/passwd")
        archive.writestr("/tmp/x", "")
        archive.comment = bytes(65_535)
    assert run(session.parent, "import", "x.sr", "-w", "out.pcapng").returncode == 0
    assert {file.name for file in session.parent.iterdir()} == {"x.sr", "out.pcapng"}
    assert not [*session.parent.parent.glob("[0-3]")]
