# SPDX-License-Identifier: GPL-2.0-or-later
"""Stations: what a master speaks to. Command telegram in, reaction telegram out.

station says what that is. A slave is one (whose telegrams it takes, what is repeated, which edition of the document
it follows), and a router is a slave with others behind it. Each group of services is a file, in the order of the
specification: identification, cancel, flash with its memory, initialization with settings (several in one telegram),
service_list, sercos (parameters; those of phases are with the devices). making makes stations from tables.
"""
