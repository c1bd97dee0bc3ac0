# SPDX-License-Identifier: GPL-2.0-or-later
"""Several subservices in one telegram of service 0x03 (chapter 6.1), and the limits that they set."""

from __future__ import annotations

import re

from sistap.dissected.wireshark.tshark import Tshark
from tables import HERE, check

FIELDS = "device subservice init.time init.baud_mask raw tza.limit tza.set_in trs.limit trs.set_in bus.baud"
_LIMITS_2 = "tza.limit=0.006000000; tza.set_in=5"
_ALL_2 = f"{_LIMITS_2}; trs.limit=0.030000000; trs.set_in=5; bus.baud=19200"
_COMMAND_2 = f"{_LIMITS_2}; bus.baud=19200"

TABLE = {
    1: "device=3; subservice=0x01,0x02,0xff; init.time=0.020000000,0.005000000",
    # A slave reacts to 0xFF with the new values already (chapter 6.1)
    2: "device=3; subservice=0x01,0x02,0xff; "
    "tza.limit=0.005000000; tza.set_in=1; trs.limit=0.020000000; trs.set_in=1",
    3: "tza.limit=0.005000000; tza.set_in=1",
    4: "tza.limit=0.005000000; tza.set_in=1; trs.limit=0.020000000; trs.set_in=1",
    5: "device=3,3,3,3; subservice=0x01,0x07,0x02,0xff; init.time=0.030000000,0.006000000; init.baud_mask=0x01; "
    "tza.limit=0.005000000; tza.set_in=1",
    6: f"device=3; subservice=0x01; {_ALL_2}",
    7: _COMMAND_2,
    8: _ALL_2,
    # 01 07 02 is TrS = 519 ms, or a baud rate of device 1
    9: f"device=1; subservice=0x01; init.time=0.005000000; raw=010702; body.note; {_COMMAND_2}",
    10: f"device=1; subservice=0x01; {_ALL_2}",
    11: f"device=3; subservice=0x01; init.time=0.020000000; raw=0500; body.note; {_COMMAND_2}",
    12: f"device=3; subservice=0x01; {_ALL_2}",
    13: f"device=3; subservice=0x02,0xff; init.time=0.010000000; {_COMMAND_2}",
    14: f"device=3; subservice=0x02; {_ALL_2}",
    15: _COMMAND_2,
    16: _ALL_2,
    # A broadcast has the limits that were set for all: none so far
    17: "device=255; subservice=0x01,0x02,0xff; init.time=0.040000000,0.008000000",
    18: "tza.limit=0.008000000; tza.set_in=17; bus.baud=19200",
    19: "tza.limit=0.008000000; tza.set_in=17; trs.limit=0.040000000; trs.set_in=17; bus.baud=19200",
}


def test_several_subservices(tshark: Tshark) -> None:
    check(tshark, "initialization", FIELDS, "body.note", TABLE)


def test_experts_without_a_tree(tshark: Tshark) -> None:
    """Frames 6 to 16, 18 and 19 belong to a station that was told 19200 Bd; the tap listens at 9600 Bd."""
    capture = str(HERE / "initialization.pcapng")
    assert re.search(r"^ +13 .* 19200 Bd, the tap ", tshark.output("-q", "-z", "expert", "-r", capture), re.MULTILINE)
