# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations: they receive the commands of a master. Command telegram in, reaction telegram out.

station defines the interface. A slave is a station: it knows which telegrams are for it, what to repeat, and which
edition of the document it follows. A router is a slave with others behind it. Each group of services is a file, in the
order of the specification: identification, cancel, flash with its memory, initialization with settings (several in one
telegram), service_list, sercos (parameters; those of phases are with the devices). making makes stations from tables.
"""
