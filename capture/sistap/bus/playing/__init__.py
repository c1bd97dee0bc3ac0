# SPDX-License-Identifier: GPL-2.0-or-later
"""Playing: what masters say, and what becomes of it on a line.

A script is a sequence of actions of a master. conducting passes the word between masters and performs their actions on
a line. player is the simulated line. Faults (collision, and those of a scenario) act on what is sent (sending), and the
result is played: characters with their times. tap_faults and hearing belong to the listener: its branch of the wire,
and its settings. times are the limits that everybody keeps.
"""
