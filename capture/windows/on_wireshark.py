# SPDX-License-Identifier: GPL-2.0-or-later
"""Wireshark's side: what install puts there, and the launcher as Wireshark calls it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from wine import CAPTURE, Wine, drive, emptied

from sistap.commands.install.shell import settings
from sistap.dissected.captures.reading import records
from sistap.tap.records.record import Event, Type

FILTER = 'link[5]==0x10&&link[6]==16 %PATH% "a  b" \\'
PROGRAM = Path(".config/wireshark/extcap/sistap.exe")  # in a home
OWN_FOLDERS = {"WIRESHARK_PLUGIN_DIR": ""}  # Wireshark looks for plugins in its own folders
ORDERS = ("data", "toolbar")


def launcher(wine: Wine) -> str:
    """Check that the launcher passes on every argument, and the exit code."""
    folder, stub = emptied(wine.folder / "ex tcap"), emptied(wine.folder / "stub")
    (stub / "sistap").mkdir()
    (stub / "sistap/__init__.py").touch()
    (stub / "sistap/__main__.py").write_text("import sys\nprint(ascii(sys.argv[1:]))\nsys.exit(7)\n")
    shutil.copy(wine.folder / "sistap.exe", folder)
    (folder / "sistap.cfg").write_text(settings(drive(wine.python), Path(drive(stub))), newline="")
    arguments = ["--extcap-capture-filter", FILTER, 'x\\"y', "", "ü"]
    said = wine.run(folder / "sistap.exe", *arguments, code=7)
    assert said.strip() == ascii(["extcap", *arguments]), said
    return f"{len(arguments)} arguments"


def install(wine: Wine) -> str:
    """Install everything, twice: the second time changes nothing."""
    emptied(wine.home)
    said = wine.sistap("install", more=OWN_FOLDERS)
    assert "Wireshark loads sis.lua" in said, said
    there = _files(wine.home)
    assert PROGRAM in there, said
    assert "created" not in wine.sistap("install", more=OWN_FOLDERS)
    assert _files(wine.home) == there
    return f"{len(there)} files"


def uninstall(wine: Wine) -> str:
    """Remove everything again."""
    said = wine.sistap("uninstall")
    assert not _files(wine.home), said
    return ""


def _files(folder: Path) -> set[Path]:
    return {file.relative_to(folder) for file in folder.rglob("*") if file.is_file()}


def asked(wine: Wine) -> str:
    """Answer Wireshark's questions before a capture."""
    program = wine.home / PROGRAM
    said = wine.run(program, "--extcap-interfaces", "--extcap-version=4.0")
    assert "{value=sistap-demo}" in said, said
    assert "control {number=0}" in said, said
    for interface in ("sistap-demo", "sistap-COM5"):
        assert "{call=--format}" in wine.run(program, "--extcap-config", "--extcap-interface", interface)
        assert "{number=252}" in wine.run(program, "--extcap-dlts", "--extcap-interface", interface)
    return ""


def demo(wine: Wine, first: str) -> str:
    """Capture the demo bus into Wireshark's pipe."""
    return _captured(wine, first, "sistap-demo")


def port(wine: Wine, first: str) -> str:
    """Capture a bus at COM5 into Wireshark's pipe."""
    with wine.bus("COM5", "--format", "8N1"):
        return _captured(wine, first, "sistap-COM5", "--format", "8N1")


def _captured(wine: Wine, first: str, interface: str, *more: str) -> str:
    """Capture until Wireshark closes its pipes, `first` before the others; a marker comes from the toolbar."""
    file = wine.folder / "piped.pcapng"
    said = wine.run(
        wine.python,
        drive(CAPTURE / "windows/wireshark.py"),
        drive(file),
        first,
        drive(wine.home / PROGRAM),
        interface,
        *more,
    )
    all_of_it = list(records(file))
    assert any(record.event == Event.MARKER for record in all_of_it), said
    telegrams = sum(record.type == Type.FRAME for record in all_of_it)
    assert telegrams, said
    assert re.search(r"^2 1 [1-9]\d* telegrams", said, re.MULTILINE), f"the toolbar counts nothing: {said}"
    return f"{telegrams} telegrams"
