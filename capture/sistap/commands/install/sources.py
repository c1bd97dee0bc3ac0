# SPDX-License-Identifier: GPL-2.0-or-later
"""Finds what can be installed, in a checkout or in an installed package, and for which Wireshark."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import sistap
from sistap.dissected.wireshark.profile import NAME
from sistap.dissected.wireshark.tshark import Version


class ModuleError(Exception):
    """The file is not a readable plugin; the text is the line to show."""


class _Layout(NamedTuple):
    """The layout of an ELF file and of the entries of its tables (names as in the ELF specification)."""

    tables: str  # e_phoff, e_shoff
    counts: int  # positions of e_phentsize, e_phnum, e_shentsize, e_shnum
    segment: str  # p_type, p_offset, p_vaddr, p_filesz
    section: str  # sh_type, sh_offset, sh_size, sh_link
    symbol: str  # st_name, st_value


_LAYOUTS = {  # by EI_CLASS, 32 and 64 bits
    1: _Layout("28xII", 42, "IIIxxxxI", "4xI8xIII", "II8x"),
    2: _Layout("32xQQ", 54, "I4xQQ8xQ", "4xI16xQQI", "I4xQ8x"),
}
_BYTE_ORDERS = {1: "<", 2: ">"}  # by EI_DATA
_LOADED_SEGMENT = 1  # PT_LOAD
_DYNAMIC_SYMBOLS = 11  # SHT_DYNSYM


def wanted_version(file: Path) -> tuple[int, int]:
    """Return the major and minor version of the Wireshark that a plugin needs. Raise ModuleError or OSError."""
    data = file.read_bytes()
    if data[:4] != b"\x7fELF":
        raise ModuleError(f"{file} is no module of this kind of system (ELF)")
    try:
        return _integer(data, b"plugin_want_major"), _integer(data, b"plugin_want_minor")
    except (struct.error, KeyError, IndexError, ValueError, OverflowError):
        raise ModuleError(f"{file} is no plugin of Wireshark, or damaged") from None


def _integer(data: bytes, symbol: bytes) -> int:
    layout, order = _LAYOUTS[data[4]], _BYTE_ORDERS[data[5]]
    programs, sections = struct.unpack_from(order + layout.tables, data)
    program_size, program_count, section_size, section_count = struct.unpack_from(order + "4H", data, layout.counts)
    headers = [
        struct.unpack_from(order + layout.section, data, sections + index * section_size)
        for index in range(section_count)
    ]
    address = next(value for name, value in _symbols(data, headers, order + layout.symbol) if name == symbol)
    for index in range(program_count):
        kind, offset, start, size = struct.unpack_from(order + layout.segment, data, programs + index * program_size)
        if kind == _LOADED_SEGMENT and start <= address < start + size:
            value: int = struct.unpack_from(order + "i", data, offset + address - start)[0]
            return value
    raise ValueError


def _symbols(data: bytes, headers: list[tuple[int, ...]], form: str) -> Iterator[tuple[bytes, int]]:
    for kind, offset, size, link in headers:
        if kind == _DYNAMIC_SYMBOLS:
            names = headers[link][1]
            for name, address in struct.iter_unpack(form, data[offset : offset + size]):
                yield data[names + name : data.index(b"\0", names + name)], address
    raise ValueError


# -- What can be installed -------------------------------------------------------------------------------------------

PACKAGE = Path(sistap.__file__).resolve().parent

_BUILDS = ("build/plugin/sis.so", "build/*/plugin/sis.so")  # cmake -B build, -B build/plugin
_BUILD = (
    "`cmake -S . -B build/plugin && cmake --build build/plugin` in a checkout builds it for the Wireshark whose "
    "headers are installed"
)


class SourceError(Exception):
    """Something to install is missing; the text is the line to show."""


class Dissector(NamedTuple):
    """The module or the script to install."""

    file: Path
    is_module: bool
    notes: list[str]  # modules that were skipped, and why


def lua() -> Path:
    """Return sis.lua. Raise SourceError."""
    for file in (PACKAGE / "sis.lua", _checkout() / "lua-fallback/sis.lua"):
        if file.is_file():
            return file
    raise SourceError(f"sis.lua is missing beside {PACKAGE}: install sistap again, or run it from a whole checkout")


def executable() -> Path | None:
    """Return sistap.exe, the launcher for Windows: from the package, or as capture/launcher/build has made it."""
    places = (PACKAGE / "sistap.exe", _checkout() / "build/windows/sistap.exe")
    return next((file for file in places if file.is_file()), None)


def profile() -> list[Path]:
    """Return the files of the profile. Raise SourceError."""
    files = sorted((PACKAGE / "profile" / NAME).glob("*"))
    if not files:
        raise SourceError(f"the profile is missing in {PACKAGE}: install sistap again")
    return files


def dissector(named: Path | None, wireshark: Version) -> Dissector:
    """Choose the module that the user named, else one built here that fits this Wireshark, else sis.lua.

    SourceError or OSError if there is none at all; module.ModuleError if the named file is not a plugin.
    """
    notes = []
    for file in [named] if named else _built():
        try:
            wanted = wanted_version(file)
        except ModuleError as error:
            if named:
                raise
            notes.append(str(error))
            continue
        if wanted == (wireshark.major, wireshark.minor):
            return Dissector(file, True, notes)
        notes.append(f"{file} was built for Wireshark {wanted[0]}.{wanted[1]}, this is {wireshark.text}: {_BUILD}")
    return Dissector(lua(), False, notes)


def _built() -> Iterator[Path]:
    """Return what cmake has built in this checkout, newest first."""
    found = [file for pattern in _BUILDS for file in _checkout().glob(pattern)]
    return iter(sorted(found, key=lambda file: file.stat().st_mtime, reverse=True))


def _checkout() -> Path:
    """Return the root of the checkout, if this is one."""
    return PACKAGE.parents[1]
