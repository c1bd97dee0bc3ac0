# SPDX-License-Identifier: GPL-2.0-or-later
"""Capture filters in libpcap's language, compiled and run by libpcap itself (through ctypes).

A filter sees the plain telegram: `link[5] == 0x10` is the service "Read parameter".
"""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import PureWindowsPath

from sistap.tap.files.pcapng import LINKTYPE_USER0
from sistap.tap.terminal.advice import advice
from sistap.tap.terminal.exits import Refusal

_SNAPLEN = 0xFFFF


class _Program(ctypes.Structure):
    _fields_ = [("length", ctypes.c_uint), ("instructions", ctypes.c_void_p)]


class _PacketHeader(ctypes.Structure):
    _fields_ = [
        ("seconds", ctypes.c_long),
        ("microseconds", ctypes.c_long),
        ("captured", ctypes.c_uint32),
        ("length", ctypes.c_uint32),
    ]


def candidates(system: str = sys.platform) -> Iterator[str]:
    """Yield the possible names of libpcap; on Windows it is Npcap's, which is in a folder of its own beside
    Packet.dll.
    """
    if system == "win32":
        yield str(PureWindowsPath(os.environ.get("SYSTEMROOT", r"C:\Windows"), "System32", "Npcap", "wpcap.dll"))
        yield "wpcap.dll"  # Npcap, installed instead of WinPcap
    else:
        yield ctypes.util.find_library("pcap") or "libpcap.so.0.8"


def opened(names: Iterable[str], load: Callable[[str], ctypes.CDLL] | None = None) -> ctypes.CDLL:
    """Load the first library that exists. Raise Refusal."""
    for name in names:
        with suppress(OSError):
            return (load or ctypes.CDLL)(name)
    raise Refusal(f"a capture filter needs libpcap: {advice().libpcap}")


def _load() -> ctypes.CDLL:
    pcap = opened(candidates())
    pcap.pcap_open_dead.restype = ctypes.c_void_p
    pcap.pcap_open_dead.argtypes = [ctypes.c_int, ctypes.c_int]
    program = ctypes.POINTER(_Program)
    pcap.pcap_compile.argtypes = [ctypes.c_void_p, program, ctypes.c_char_p, ctypes.c_int, ctypes.c_uint32]
    pcap.pcap_geterr.restype = ctypes.c_char_p
    pcap.pcap_geterr.argtypes = [ctypes.c_void_p]
    pcap.pcap_close.argtypes = [ctypes.c_void_p]
    pcap.pcap_offline_filter.argtypes = [program, ctypes.POINTER(_PacketHeader), ctypes.c_char_p]
    return pcap


class Filter:
    """A compiled filter. It lives as long as the capture, so libpcap's memory for it is never freed."""

    def __init__(self, text: str) -> None:
        """Compile; Refusal has libpcap's own message."""
        self.text = text
        self._pcap = _load()
        self._program = _Program()
        self._header = _PacketHeader()
        pcap = self._pcap.pcap_open_dead(LINKTYPE_USER0, _SNAPLEN)
        try:
            if self._pcap.pcap_compile(pcap, ctypes.byref(self._program), os.fsencode(text), 1, 0xFFFFFFFF):
                message = self._pcap.pcap_geterr(pcap).decode(errors="replace")
                raise Refusal(f"filter '{text}': {message}")
        finally:
            self._pcap.pcap_close(pcap)

    def matches(self, telegram: bytes) -> bool:
        """Tell whether the filter lets a telegram pass."""
        self._header.captured = self._header.length = len(telegram)
        return bool(self._pcap.pcap_offline_filter(ctypes.byref(self._program), ctypes.byref(self._header), telegram))
