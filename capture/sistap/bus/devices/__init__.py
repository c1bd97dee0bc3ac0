# SPDX-License-Identifier: GPL-2.0-or-later
"""Devices behind a station: a control itself, and drives (fig. 8-2).

A device has parameters, a phase, and one channel for long data (transfers). procedure has the progress of parameters
that are commands, segments the parts of lists as IndraDrive has them. A drive is a device that moves, and an IndraDrive
is a kind of drive. Gates stand between a station and a device. equipment makes the devices of a station from its table,
parameter_sets their parameters from the sets in sets/.
"""
