# SPDX-License-Identifier: GPL-2.0-or-later
"""Devices behind a station: a control itself, and drives (fig. 8-2).

What a device has is parameters (with the progress of those that are commands: procedure; parts of lists as IndraDrive
has them: segments), a phase, and one channel for long data (transfers). A drive is a device that moves, and an
IndraDrive one of them. Gates stand between a station and a device. equipment makes the devices of a station from its
table, parameter_sets their parameters from the sets in sets/.
"""
