# SPDX-License-Identifier: GPL-2.0-or-later
"""What SERCOS fixes about standard parameters: only forms and bits, never a scale.

Made by plugin/protocol/generate.py from standard.toml: edit there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

# What the values of a parameter are.
FORMS: Mapping[str, str] = {
    "S-0-0390": "diagnosis",
    "S-0-0095": "diagnosis_text",
    "S-0-0011": "error_bits",
    "S-0-0012": "warning_bits",
    "S-0-0134": "control_word",
    "S-0-0135": "status_word",
    "S-0-0403": "referenced",
    "S-0-0013": "bits",
    "S-0-0014": "bits",
    "S-0-0099": "bits",
    "S-0-0047": "position",
    "S-0-0051": "position",
    "S-0-0053": "position",
}

# Measured values, and the commands that they follow.
FOLLOWS: Mapping[str, str] = {
    "S-0-0040": "S-0-0036",
    "S-0-0084": "S-0-0080",
}

# Limits of a drive.
LIMITS: Collection[str] = frozenset(
    (
        "S-0-0038",
        "S-0-0039",
        "S-0-0049",
        "S-0-0050",
        "S-0-0082",
        "S-0-0083",
        "S-0-0091",
        "S-0-0092",
        "S-0-0136",
        "S-0-0137",
        "S-0-0138",
    )
)
