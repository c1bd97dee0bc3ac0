# SPDX-License-Identifier: GPL-2.0-or-later
"""What the decoder of the wire refuses."""

from __future__ import annotations

import pytest

from sistap.line import bus_socket
from sistap.line.settings import Read


@pytest.mark.parametrize("time_ns", [4_000_000_000_000_000_000, 2**64 - 1])
def test_a_time_that_no_capture_can_hold_is_refused(time_ns: int) -> None:
    assert bus_socket.Decoder().feed(bus_socket.pack_read(Read(0, 3_999_999_999_999_999_999, b"x", b"\0"))) != []
    with pytest.raises(ValueError, match="the other end of the socket is not a sistap bus"):
        bus_socket.Decoder().feed(bus_socket.pack_read(Read(0, time_ns, b"x", b"\0")))
