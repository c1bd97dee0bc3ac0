# SPDX-License-Identifier: GPL-2.0-or-later
"""Parses several subservices in one telegram of service 0x03, or refuses them."""

from __future__ import annotations

from sistap.bus.service import ServiceRefused, Status
from sistap.sis import subservices
from sistap.sis.subservices import Misfit, Setting

_STATUS = {
    Misfit.ADDRESS: Status.INVALID_ADDRESS,
    Misfit.SUBSERVICE: Status.INVALID_SUBSERVICE,
    Misfit.DATA: Status.DATA_MISSING,
}


def settings(body: bytes) -> list[Setting]:
    """Split a body into subservices.

    Raise ServiceRefused if no layout consumes all bytes, with the status of the layout that went further. Refuse also
    if both do and differ: then the meaning is ambiguous.
    """
    if (found := subservices.settings(body)) is not None:
        return found
    furthest = max(subservices.layouts(body), key=lambda layout: layout.end)
    raise ServiceRefused(_STATUS[furthest.misfit] if furthest.misfit else Status.INVALID_TELEGRAM)
