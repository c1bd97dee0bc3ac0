# SPDX-License-Identifier: GPL-2.0-or-later
"""Devices behind a station: a control itself, and drives (fig. 8-2).

A device has parameters, a phase, and one channel for long data. A drive is a device that moves, and an IndraDrive is a
kind of drive. equipment makes the devices of a station from its table, with a gate before each; parameter_sets makes
their parameters from the sets in sets/.
"""
