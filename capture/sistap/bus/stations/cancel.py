# SPDX-License-Identifier: GPL-2.0-or-later
"""Service 0x01: cancel data transmission (IF02 chapter 4)."""

from __future__ import annotations

from sistap.bus.service import Request, Service
from sistap.bus.stations.sercos import Parameters


def cancel(parameters: Parameters) -> Service:
    """Return the service. Device and service may be missing; a single byte is the device.

    It succeeds even if there is nothing to cancel. A phase switch continues.
    """

    def execute(request: Request) -> bytes:
        device, service = (*request.body[:2], None, None)[:2]
        parameters.cancel(device, service)
        return request.body[:1]

    return Service(1, 0, execute)
