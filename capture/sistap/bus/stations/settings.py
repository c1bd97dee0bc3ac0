# SPDX-License-Identifier: GPL-2.0-or-later
"""What a station makes of several subservices in one telegram of service 0x03, and how it refuses them."""

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
    """Take a body apart.

    ServiceRefused where no layout consumes all bytes, with the status of the one that went further; and where both
    do and differ: then nobody can tell what was meant.
    """
    if (found := subservices.settings(body)) is not None:
        return found
    furthest = max(subservices.layouts(body), key=lambda layout: layout.end)
    raise ServiceRefused(_STATUS[furthest.misfit] if furthest.misfit else Status.INVALID_TELEGRAM)
