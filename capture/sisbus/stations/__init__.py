# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations: they receive the commands of a master. Command telegram in, reaction telegram out.

station has the station itself: which telegrams are for it, what it repeats, which edition it follows, and what it
routes further. Its services: general has identification, cancel and the list of services, flash and initialization
have theirs, sercos has parameters; those of phases are with the devices. making makes stations from tables.
"""
