# SPDX-License-Identifier: GPL-2.0-or-later
"""Service 0x04: execute a list of SIS services (IF02 chapter 7)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from sistap.bus.service import Request, Service, ServiceFailed, ServiceRefused, Status

SERVICE = 0x04
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
    return bytes([Status.INVALID_SERVICE]) if request.service == SERVICE else execute(request)


def _items(body: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield service and body of each; raise ServiceRefused for a wrong length."""
    place = 0
    while place < len(body):
        end = place + 1 + body[place]
        if body[place] == 0 or end > len(body):
            raise ServiceRefused(Status.DATA_MISSING)
        yield body[place + 1], body[place + 2 : end]
        place = end
