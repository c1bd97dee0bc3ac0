# SPDX-License-Identifier: GPL-2.0-or-later
"""What the decoder of the wire refuses."""

from __future__ import annotations

import pytest

from sistap.tap.line.settings import Read
from sistap.tap.wire import protocol

YEAR_2226_NS = 8_100_000_000_000_000_000
STRANGER = "the other end of the socket is not a sistap bus"


@pytest.mark.attack("the clock of a distant tap is set to a year that no capture can hold", "one line says so")
@pytest.mark.parametrize(
    ("time_ns", "said"),
    [(4_000_000_000_000_000_000, "clock .* set it there$"), (YEAR_2226_NS, "set it there$"), (2**64 - 1, STRANGER)],
)
def test_a_time_that_no_capture_can_hold_is_refused(time_ns: int, said: str) -> None:
    assert protocol.Decoder().feed(protocol.pack_read(Read(0, 3_999_999_999_999_999_999, b"x", b"\0"))) != []
    with pytest.raises(ValueError, match=said):
        protocol.Decoder().feed(protocol.pack_read(Read(0, time_ns, b"x", b"\0")))
