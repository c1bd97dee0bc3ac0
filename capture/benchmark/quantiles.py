# SPDX-License-Identifier: GPL-2.0-or-later
"""The quantiles in the tables."""

from __future__ import annotations

from collections.abc import Sequence

QUANTILES = {"p50": 0.5, "p90": 0.9, "p99": 0.99, "p99.9": 0.999, "max": 1.0}


def quantiles(values: Sequence[int]) -> dict[str, int]:
    """Return each of QUANTILES, keyed by its name."""
    ordered = sorted(values)
    return {name: ordered[min(int(share * len(ordered)), len(ordered) - 1)] for name, share in QUANTILES.items()}
