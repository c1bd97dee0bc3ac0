# SPDX-License-Identifier: GPL-2.0-or-later
"""The quantile of values that are all there."""

from __future__ import annotations

import math
from collections.abc import Sequence

_ROUNDING = 1e-9  # 0.07 * 100 is a little more than 7


def quantile(ordered: Sequence[float], share: float) -> float:
    """Return the smallest of the sorted values that is not below `share` of them."""
    return ordered[max(0, math.ceil(share * len(ordered) - _ROUNDING) - 1)]
