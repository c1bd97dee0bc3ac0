# SPDX-License-Identifier: GPL-2.0-or-later
"""The virtual bus: masters and stations that speak SIS, without hardware, or with one half of it.

A scenario (scenario.py) says who is there and what goes wrong. A telegram flows forward: steps (what a master asks) ->
conducting (which master has the word) -> playing (when each character arrives, what the stations answer, what faults
make of it) -> pseudo_terminal, taps, port_wire or recording (who hears it), hearing (with which settings). At a real
port, talking is the line of our master, and answering that of our stations. command puts them together.

A station is a slave (slave.py: who is meant, what is repeated) with a file for each group of services: identification,
cancel, flash with its memory, initialization, service_list, sercos (parameters) and phases. Parameters belong to
devices (device.py, drive.py), behind gates and a channel (transfers.py); stations.py, equipment.py and
parameter_sets.py make all this from tables. routing.py puts stations below others.
"""
