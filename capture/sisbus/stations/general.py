# SPDX-License-Identifier: GPL-2.0-or-later
"""Services 0x00, 0x01 and 0x04: identification, cancel, and a list of services."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from sisbus.service import (
    Request,
    Service,
    ServiceFailed,
    ServiceRefused,
    Status,
    Subservice,
    by_subservice,
)
from sisbus.stations.sercos import Parameters
from sistap.tap.sis.rates import BAUD_MASKS

_SIS_VERSION = b"01V01"  # fig. 3-4
LONGEST_TEXT = 40  # characters of firmware and type key


def identification(type_key: str, firmware: str, rates: Iterable[int]) -> Service:
    """Return the service; `rates` in Bd, of RATES."""
    masks = 0
    for baud in rates:
        masks |= BAUD_MASKS[baud]
    texts = {1: _SIS_VERSION, 2: firmware.encode("ascii"), 3: type_key.encode("ascii"), 4: bytes([masks])}
    return by_subservice(0x00, {number: _telling(text) for number, text in texts.items()})


def _telling(text: bytes) -> Subservice:
    return lambda data, now_ns: text


# -- Service 0x01: cancel data transmission (IF02 chapter 4) ---------------------------------------------------------


def cancel(parameters: Parameters) -> Service:
    """Return the service. Device and service may be missing; a single byte is the device.

    It succeeds even if there is nothing to cancel. A phase switch continues.
    """

    def execute(request: Request) -> bytes:
        device, service = (*request.body[:2], None, None)[:2]
        parameters.cancel(device, service)
        return request.body[:1]

    return Service(1, 0, execute)


# -- Service 0x04: execute a list of SIS services (IF02 chapter 7) ---------------------------------------------------

LIST = 0x04
_LONGEST = 247  # bytes of the reaction that fit with any header, without the overall status


def service_list(execute: Callable[[Request], bytes]) -> Service:
    """Return the service; `execute` returns the whole body of the reaction to one service of the list."""

    def run(request: Request) -> bytes:
        answers, good = b"", True
        for service, body in _items(request.body):
            answer = _answer(execute, request._replace(service=service, body=body))
            good = good and answer[0] == Status.OK
            item = bytes([1 + len(answer), service]) + answer
            if len(answers) + len(item) > _LONGEST:  # no document covers this: return what fits, without success
                good = False
                break
            answers += item
        if not good:
            raise ServiceFailed(answers)
        return answers

    return Service(0, 1, run)


def _answer(execute: Callable[[Request], bytes], request: Request) -> bytes:
    """Answer one service; a list within a list is not allowed."""
    return bytes([Status.INVALID_SERVICE]) if request.service == LIST else execute(request)


def _items(body: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield service and body of each; raise ServiceRefused for a wrong length."""
    place = 0
    while place < len(body):
        end = place + 1 + body[place]
        if body[place] == 0 or end > len(body):
            raise ServiceRefused(Status.DATA_MISSING)
        yield body[place + 1], body[place + 2 : end]
        place = end
