# SPDX-License-Identifier: GPL-2.0-or-later
"""Phase switches: begun, polled, reached, failed or given up."""

from __future__ import annotations

from sistap.dissected.wireshark.tshark import Tshark
from tables import Table, check

PHASES: Table = {
    # Reached: 25 + 8 + 25 + 7 + 25 + 9 + 25 + 7 + 25 ms after the command, the numbers without point times 1.145833
    1: "phase=4",
    4: "phase=2; phase.switch_in=1",
    6: "phase=4; phase.switch_in=1; phase.switch_time=0.160520823",
    8: "phase=4",
    # Failed while polled: the master axis turns; 25 + 9 + 25 + 7 + 25 ms
    9: "phase=2",
    10: "phase=4",
    12: "phase=4; error=0xd007; phase.switch_in=9; phase.switch_time=0.093333328",
    14: "phase=4",
    # Refused at once: there is no such phase
    15: "phase=5",
    16: "phase=4; error=0x8004",
    18: "phase=4",
    # Given up by another switch; 25 + 8 + 25 + 7 + 25 ms
    19: "phase=2",
    22: "phase=4; phase.switch_in=19",
    23: "phase=4",
    26: "phase=4; phase.switch_in=23; phase.switch_time=0.092187495",
    # Another is refused while one is active: the first goes on
    27: "phase=2",
    29: "phase=4",
    30: "phase=3; error=0xd005",
    32: "phase=2; phase.switch_in=27; phase.switch_time=0.163958322",
    # Two controls at once, with the services of SYNAX
    33: "phase=2",
    35: "phase=4",
    38: "phase=4; phase.switch_in=35; phase.switch_time=0.092187495",
    40: "phase=2; phase.switch_in=33; phase.switch_time=0.228854151",
    # The acknowledgement was damaged, the command repeated: from the command that was answered
    41: "phase=4",
    43: "phase=4",
    46: "phase=4; phase.switch_in=43; phase.switch_time=0.092187495",
    # A poll of status 0xF0 tells nothing of the phase: the switch goes on
    47: "phase=2",
    52: "phase=2; phase.switch_in=47; phase.switch_time=0.159374990",
    # Cancelling all that is under way does not cancel a phase switch (chapter 8.5)
    53: "phase=4",
    58: "phase=4; phase.switch_in=53; phase.switch_time=0.159374990",
}

PHASES_ROUTED: Table = {
    1: "phase=4",
    4: "phase=4",
    6: "phase=4; phase.switch_in=1; phase.switch_time=0.165104155",
}


def test_phases(tshark: Tshark) -> None:
    check(tshark, "phases", "phase error phase.switch_in phase.switch_time", "", PHASES)


def test_phases_routed(tshark: Tshark) -> None:
    check(tshark, "phases-routed", "phase phase.switch_in phase.switch_time", "", PHASES_ROUTED)
