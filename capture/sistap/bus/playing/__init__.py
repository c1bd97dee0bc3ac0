# SPDX-License-Identifier: GPL-2.0-or-later
"""Playing: what masters say and what becomes of it on a line.

A script is what a master does, one action after the other; conducting gives masters the word and does their actions on
a line. player is the simulated line: what is sent (sending) meets what goes wrong (collision, and what a scenario says)
and comes out as played: characters with their times. tap_faults and hearing are the listener's: what its branch of the
wire and its settings make of these. times are those that everybody keeps.
"""
