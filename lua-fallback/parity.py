# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares tshark's output with the C plugin and with sis.lua, line by line."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

from sistap.dissected.wireshark.tshark import Tshark

SCRIPT = Path(__file__).parent / "sis.lua"

# One element of PDML is one line, with name, text, position, size and value; the first lines name file and time.
_PACKET, _END = "<packet>\n", "</packet>"
_SHOWN = 5  # packets that differ

# Permitted differences, and how to remove them from both. README.md describes them.
ALLOWED = (
    # In the plugin, milliseconds always have three digits. A script cannot format a number field.
    (re.compile(r'(<field name="[\w.]+\.ms" showname=")[^"]*"'), r'\1"'),
    # Wireshark itself reports that the capture has cut a packet, when C reads past the end; in Lua it is a line of
    # text.
    (
        re.compile(
            r'<proto name="fake-field-wrapper">\n *<field name="_ws.lua.text" '
            r'showname="(\[Packet size limited during capture: [^"]*)"[^\n]*\n *</proto>'
        ),
        r'<proto name="_ws.short" showname="\1" size="0" pos="0"/>',
    ),
    # From 4.6 on, Wireshark itself may say so after Lua, too: where the unit is, never at 0.
    (re.compile(r'<proto name="_ws.short" ([^\n]*) pos="[1-9]\d*"/>\n *(?=<proto name="_ws.short" \1 pos="0"/>)'), ""),
    # Wireshark puts a hidden item before everything that Lua dissects.
    (
        re.compile(
            r'^ *<proto name="fake-field-wrapper">\n *<field name="_ws.lua.fake" [^\n]*\n *</proto>\n', re.MULTILINE
        ),
        "",
    ),
    (re.compile(r'^ *<field name="_ws.lua.fake" [^\n]*\n', re.MULTILINE), ""),
    # A line of the tree without a field is one in Lua as well, without its bytes.
    (
        re.compile(r'<field name="_ws.lua.text" showname="([^"]*)" (size="\d+" pos="\d+") show="" value=""'),
        r'<field name="" show="\1" \2',
    ),
    (re.compile(r'(<field name="" show="[^"]*" size="\d+" pos="\d+") value="[0-9a-f]*"'), r"\1"),
)

# The length of a unit of which the capture has cut the end: TCP gets another one from Lua.
_PDU_SIZE = re.compile(r'^ *<field name="tcp.pdu.size" [^\n]*\n', re.MULTILINE)


def without_allowed(packet: str) -> str:
    """Return a packet without the permitted differences."""
    for pattern, same in ALLOWED:
        packet = pattern.sub(same, packet)
    if '<proto name="_ws.short"' in packet:
        packet = _PDU_SIZE.sub("", packet)
    for name in ("sis", "sisascii"):  # with that hidden item, Wireshark names a protocol of which it shows nothing
        if f'<proto name="{name}"' not in packet:
            packet = packet.replace(f':{name}"', '"')
    return packet


def packets(tshark: Tshark, capture: Path, *options: str) -> list[str]:
    """Return the whole trees of all packets, as PDML. AssertionError if tshark complains."""
    done = tshark.run(["-r", str(capture), *options, "-T", "pdml"])
    assert done.returncode == 0, done.stderr
    assert all(line.startswith("sis.lua: ") for line in done.stderr.splitlines()), done.stderr
    assert not re.findall('Lua Error[^"]*', done.stdout)
    return [without_allowed(packet.partition(_END)[0]) for packet in done.stdout.split(_PACKET)[1:]]


def difference(expected: list[str], found: list[str], *, whose: Callable[[int], object] = str) -> str:
    """Return how packets differ: empty, or how many of them, and the first of them line by line.

    `whose` names a packet by its number.
    """
    pairs = list(zip_longest(expected, found, fillvalue=""))
    differing = [(number, *pair) for number, pair in enumerate(pairs, 1) if pair[0] != pair[1]]
    if not differing:
        return ""
    words = [f"{len(differing)} of {len(pairs)} packets differ"]
    for number, one, two in differing[:_SHOWN]:
        name = whose(number)
        words += difflib.unified_diff(one.splitlines(), two.splitlines(), f"{name} C", f"{name} Lua", "", "", 1, "")
    return "\n".join(words)


def listed(tshark: Tshark, capture: Path, *options: str) -> list[str]:
    """Return the packet list, which needs no tree. What a capture has cut is said once: see ALLOWED."""
    words = tshark.output("-r", str(capture), *options)
    return re.sub(r"(\[Packet size limited during capture\])\1", r"\1", words).splitlines()


def check(plugin: Tshark, script: Tshark, capture: Path, *options: str, whose: Callable[[int], object] = str) -> None:
    """Dissect a capture with both. AssertionError has the difference, if there is one."""
    for view in (packets, listed):
        words = difference(view(plugin, capture, *options), view(script, capture, *options), whose=whose)
        assert not words, words
