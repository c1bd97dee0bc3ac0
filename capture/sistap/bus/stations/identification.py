# SPDX-License-Identifier: GPL-2.0-or-later
"""Service 0x00: identification of a station (IF02 chapter 3)."""

from __future__ import annotations

from collections.abc import Iterable

from sistap.bus.service import Service, Subservice, by_subservice
from sistap.sis.rates import BAUD_MASKS

_SIS_VERSION = b"01V01"  # fig. 3-4
LONGEST = 40  # characters of firmware and type key


def identification(type_key: str, firmware: str, rates: Iterable[int]) -> Service:
    """Return the service; `rates` in Bd, of RATES."""
    masks = 0
    for baud in rates:
        masks |= BAUD_MASKS[baud]
    texts = {1: _SIS_VERSION, 2: firmware.encode("ascii"), 3: type_key.encode("ascii"), 4: bytes([masks])}
    return by_subservice({number: _telling(text) for number, text in texts.items()})


def _telling(text: bytes) -> Subservice:
    return Subservice(0, lambda data, now_ns: text)
