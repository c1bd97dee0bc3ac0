# SPDX-License-Identifier: GPL-2.0-or-later
"""Files that are no captures yet: the command that makes one of a log or of another tool's file, or unpacks it.

Recordings of logic analysers are zips, too.
"""

from __future__ import annotations

import re
import zlib
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from sistap.tap.terminal.advice import shell_word

_PACKED = {
    rb"\xfd7zXZ\x00": "xz -dk",
    rb"\x1f\x8b": "gunzip -k",
    rb"BZh[1-9]1A": "bunzip2 -k",
    rb"PK\x03\x04": "unzip",
    rb"7z\xbc\xaf": "7z x",
    rb"\x04\x22M\x18": "lz4 -dk",
    rb"\x28\xb5\x2f\xfd": "zstd -dk",
}
_UNTOLD = ("lz4 -dk", "zstd -dk")  # tshark takes what is left of a capture that is cut off for all of it
# The recordings of logic analysers among zips, by a file in them.
_RECORDINGS = {
    "metadata": "is a session of sigrok: {} makes a capture of it",
    "header": "is a session of DSView: {} makes a capture of it",
    "meta.json": "is a capture of Saleae Logic 2: export its raw data there, as CSV; `sistap import` reads that",
}
# What the library raises of a damaged zip: also of a name that is no UTF-8, and of places behind any end.
ZIP_ERRORS = (BadZipFile, OSError, EOFError, RuntimeError, ValueError, OverflowError, zlib.error)

_BINARY = re.compile(rb"[^\t\n\f\r -~\x80-\xff]")  # no log has such bytes, and every capture begins with some
_HEAD = 4096


def is_text(path: Path) -> bool:
    """Tell whether a file is a text. Wireshark takes short ones for other things. May raise OSError."""
    with path.open("rb") as file:
        head = file.read(_HEAD)
    return bool(head) and not _BINARY.search(head)


def no_capture(path: Path) -> str:
    """Say what to do with a file that is no capture."""
    return unpack(path) or (
        f"{path} is not a capture that tshark can read. First make one: of a log with {making('annotate', path)}, of a "
        f"logic analyser's file with {making('import', path)}"
    )


def making(command: str, path: Path) -> str:
    """Return the command line by which `annotate` or `import` makes a capture of a file, beside it."""
    words = shell_word(str(path)), shell_word(str(path.with_name(f"{path.stem}-sis.pcapng")))
    return f"`sistap {command} {words[0]} -w {words[1]}`"


def unpack(path: Path) -> str:
    """Return what to do with a packed file; empty if it is not packed, or cannot be read."""
    try:
        if not path.is_file():  # opening a pipe would wait for a writer
            return ""
        with path.open("rb") as file:
            head = file.read(6)
    except OSError:
        return ""
    names = zipped(path) if head.startswith(b"PK") else []
    if recording := next((what for name, what in _RECORDINGS.items() if name in names), ""):
        return f"{path} {recording.format(making('import', path))}"
    if head.startswith(b"PK\x03\x04") and not names:
        return f"{path} is a damaged zip: copy it again from where it was recorded"
    command = _unpacking(head)
    return f"{path} is packed: unpack it first, for example with `{command} {shell_word(str(path))}`" if command else ""


def untold(path: Path) -> str:
    """Say that nobody is told whether the end of a packed capture is missing; empty if tshark tells. OSError."""
    with path.open("rb") as file:
        command = _unpacking(file.read(6))
    if command not in _UNTOLD:
        return ""
    return f"{path} is packed: tshark does not say if its end is missing; `{command} {shell_word(str(path))}` does"


def _unpacking(head: bytes) -> str:
    """Return the command that unpacks a file that begins so; empty if it is not packed."""
    return next((command for magic, command in _PACKED.items() if re.match(magic, head)), "")


def zipped(path: Path) -> list[str]:
    """Return what is in a zip; nothing if the file is none, or cannot be read."""
    try:
        with ZipFile(path) as archive:
            return archive.namelist()
    except ZIP_ERRORS:
        return []
