# SPDX-License-Identifier: GPL-2.0-or-later
"""Names of services for lines printed without Wireshark.

The source is plugin/sis/names.c; a test compares the two, so edit there first.
"""

from __future__ import annotations

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

# First and last service of a range, and the name of the range, for services without a name of their own.
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


def service_name(service: int) -> str:
    """Return the name of a service, or its range with its number."""
    name = SERVICES.get(service)
    if name is None:
        kind = next(text for first, last, text in RANGES if first <= service <= last)
        name = f"{kind} 0x{service:02x}"
    return name
