# SPDX-License-Identifier: GPL-2.0-or-later
"""Codes of services, and what stands in their useful data.

Made by plugin/protocol/generate.py from codes.toml and services.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple


class Item(NamedTuple):
    """A part of the useful data: a field of the dissector without "sis.", and its bytes."""

    field: str
    size: int  # 0: the rest
    may_be_missing: bool = False


class Layout(NamedTuple):
    """What follows a subservice in a command, and in a good reaction."""

    command: Sequence[Item]
    reaction: Sequence[Item]


# Services with a name of their own.
SERVICES = {
    0x00: "Node identification",
    0x01: "Cancel data transmission",
    0x02: "Flash operation",
    0x03: "Initialization of the SIS communication",
    0x04: "Execute a list of SIS services",
    0x0F: "Token passing",
    0x10: "Read parameter",
    0x11: "Read list segment",
    0x12: "Read phase",
    0x1D: "Switch phase",
    0x1E: "Write list segment",
    0x1F: "Write parameter",
    0x80: "Read parameter (ECODRIVE)",
    0x81: "Read list segment (ECODRIVE)",
    0x8E: "Write list segment (ECODRIVE)",
    0x8F: "Write parameter (ECODRIVE)",
    0x90: "Read parameter (SYNAX)",
    0x91: "Read list segment (SYNAX)",
    0x92: "Read phase (SYNAX)",
    0x9D: "Switch phase (SYNAX)",
    0x9E: "Write list segment (SYNAX)",
    0x9F: "Write parameter (SYNAX)",
}

# First and last service of a range, and its name, for services without a name of their own.
RANGES = (
    (0x00, 0x0F, "General service"),
    (0x10, 0x7F, "Reserved service"),
    (0x80, 0x8F, "ECODRIVE service"),
    (0x90, 0x9F, "SYNAX service"),
    (0xA0, 0xAF, "MT-CNC/MTC200 service"),
    (0xB0, 0xBF, "ISP200 service"),
    (0xC0, 0xCF, "CLC-GPS service"),
    (0xD0, 0xDF, "HMI system service"),
    (0xE0, 0xEF, "DISC service"),
    (0xF0, 0xFF, "Reserved service"),
)

# Services whose reactions begin with a status byte (chapter 2.1).
WITH_STATUS = frozenset((*range(0x00, 0x20), *range(0x80, 0xA0)))

# General services with a parameter control byte and a device address first (fig. 8-1).
WITH_CONTROL = frozenset([0x10, 0x11, 0x1E, 0x1F])

# Services of product groups that have the layout of a general one (chapter 8).
LIKE: Mapping[int, int] = {
    0x80: 0x10,
    0x81: 0x11,
    0x8E: 0x1E,
    0x8F: 0x1F,
    0x90: 0x10,
    0x91: 0x11,
    0x92: 0x12,
    0x9D: 0x1D,
    0x9E: 0x1E,
    0x9F: 0x1F,
}

# The same, but only if a preference of the dissector is set.
LIKE_IF_SET: Mapping[str, Mapping[int, int]] = {
    "ecodrive_phases": {0x82: 0x12, 0x8D: 0x1D},
    "clc_as_sercos": {0xC0: 0x10, 0xC1: 0x11, 0xC2: 0x12, 0xCD: 0x1D, 0xCE: 0x1E, 0xCF: 0x1F},
}

# By service and subservice (chapters 3, 5 and 6).
LAYOUTS: Mapping[int, Mapping[int, Layout]] = {
    0x00: {
        0x01: Layout((), (Item("version", 0),)),
        0x02: Layout((), (Item("firmware", 0),)),
        0x03: Layout((), (Item("type_key", 0),)),
        0x04: Layout((), (Item("init.baud_mask", 1),)),
    },
    0x02: {
        0x90: Layout((Item("flash.target", 1), Item("flash.address", 4)), ()),
        0x91: Layout((Item("flash.address", 4),), ()),
        0x92: Layout((Item("flash.address", 4), Item("flash.length", 1)), (Item("data", 0),)),
        0x93: Layout((), (Item("flash.address", 4),)),
        0x94: Layout((Item("flash.address", 4), Item("flash.length", 4)), ()),
        0x96: Layout((Item("flash.address", 4), Item("flash.device_type", 1), Item("data", 0)), ()),
        0x97: Layout((Item("flash.address", 4), Item("flash.length", 4)), (Item("flash.crc32", 4, True),)),
        0x9F: Layout((), ()),
    },
    0x03: {
        0x01: Layout((Item("init.time", 2),), ()),
        0x02: Layout((Item("init.time", 2),), ()),
        0x03: Layout((Item("init.time", 2),), ()),
        0x07: Layout((Item("init.baud_mask", 1),), ()),
        0x08: Layout((Item("init.test_time", 2), Item("init.baud_mask", 1)), ()),
        0xFF: Layout((), ()),
    },
}

# Those without subservices: their one layout is that of all useful data.
WITHOUT_SUBSERVICES: Collection[int] = frozenset([])
