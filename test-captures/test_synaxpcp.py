# SPDX-License-Identifier: GPL-2.0-or-later
"""Interbus PCP: which answer belongs to which request, and to which object, worked out by hand from the facts."""

from __future__ import annotations

from sistap.dissected.wireshark.tshark import Tshark
from tables import Table, check

FIELDS = (
    "synaxpcp.request_in synaxpcp.response_in synaxpcp.count synaxpcp.invoke synaxpcp.reference synaxpcp.index "
    "synaxpcp.length synaxpcp.data synaxpcp.error synaxpcp.raw synax.request_in synax.answer_in synaxobj.index"
)
EXPERTS = "synax.note synax.short synax.unexpected synax.error"


def message(count: int, reference: int, *rest: str, invoke: int = 0) -> str:
    head = f"synaxpcp.count={count}", f"synaxpcp.invoke={invoke}", f"synaxpcp.reference={reference}"
    return "; ".join([*head, *rest])


def request(index: str) -> str:
    return f"synaxpcp.index=0x{index}; synaxobj.index=0x{index}"


MESSAGES: Table = {
    # The write request of L242 (0082 000C 0002), its confirmation, and the telegram that is read from the same object
    1: message(12, 2, request("5e71"), "synaxpcp.length=17; synaxpcp.response_in=2; synax.answer_in=4"),
    2: message(2, 2, "synaxpcp.request_in=1; synaxobj.index=0x5e71"),
    3: message(3, 2, request("5e71"), "synaxpcp.response_in=4"),
    4: message(19, 2, "synaxpcp.length=32; synaxpcp.request_in=3; synax.request_in=1; synaxobj.index=0x5e71"),
    # At the device, two of them at a time
    5: message(4, 3, request("5ff6"), "synaxpcp.length=2; synaxpcp.response_in=7"),
    6: message(3, 2, request("5ff6"), "synaxpcp.response_in=8"),
    7: message(2, 3, "synaxpcp.request_in=5; synaxobj.index=0x5ff6"),
    8: message(4, 2, "synaxpcp.length=2; synaxpcp.request_in=6; synaxobj.index=0x5ff6; synax.note; synax.error"),
    # Invoke id 1; the second response has no request left
    9: message(3, 4, request("5ff2"), "synaxpcp.response_in=10", invoke=1),
    10: message(4, 4, "synaxpcp.length=2; synaxpcp.request_in=9; synaxobj.index=0x5ff2", invoke=1),
    11: message(4, 4, "synaxpcp.length=2; synaxpcp.data=0008; synax.note", invoke=1),
    # ABB's own examples, of objects that are not SYNAX'
    12: message(3, 2, "synaxpcp.index=0x3bcb; synaxpcp.response_in=13"),
    13: message(4, 2, "synaxpcp.length=2; synaxpcp.data=03e8; synaxpcp.request_in=12; synax.note"),
    14: message(
        4, 2, "synaxpcp.index=0x3836; synaxpcp.length=2; synaxpcp.data=03e8", "synaxpcp.response_in=15; synax.note"
    ),
    # Negative answers
    15: message(3, 2, "synaxpcp.error=0x08000010; synaxpcp.request_in=14; synax.error"),
    16: message(3, 2, request("5e70"), "synaxpcp.response_in=17"),
    17: message(3, 2, "synaxpcp.error=0x06050011; synaxpcp.request_in=16; synax.error"),
    18: message(4, 2, "synaxpcp.index=0x5e70; synaxpcp.length=2; synaxpcp.data=0203; synax.note"),
    # Services that are named only; codes that are not
    19: message(2, 2, "synaxpcp.raw=0000; synax.note"),
    20: message(1, 2),
    21: message(9, 2, "synaxpcp.raw=0000000c0101860831002af800012345; synax.note"),
    22: message(2, 2, "synaxpcp.raw=0000; synax.note"),
    # 4 bytes of data and none there; a byte too many; 5 words and 3 there; no subindex; answers without their words
    23: message(3, 2, request("5e70"), "synaxpcp.length=4; synax.short"),
    24: message(4, 2, request("5e70"), "synaxpcp.length=1; synaxpcp.raw=00; synax.unexpected"),
    25: message(5, 2, request("5e70"), "synaxpcp.response_in=27; synax.short"),
    26: message(2, 2, "synaxpcp.raw=5e70; synax.short"),
    27: message(1, 2, "synaxpcp.request_in=25; synax.short"),
    28: message(2, 2, "synaxpcp.raw=0600; synax.short"),
    29: message(2, 2, "synax.short"),
    30: "synaxpcp.count=0; synax.short",
    31: "synaxpcp.raw=018100; synax.short",
    32: "synaxpcp.raw=0081; synax.short",
}


def test_messages(tshark: Tshark) -> None:
    check(tshark, "synaxpcp", FIELDS, EXPERTS, MESSAGES, prefix="")
