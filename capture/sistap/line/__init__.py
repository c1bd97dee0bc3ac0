# SPDX-License-Identifier: GPL-2.0-or-later
"""A serial line, from the port to characters with times.

Ports (ports), their settings (settings), how they are read (reader), when a character came (clock, measurement,
priority), and the messages of a simulated bus to a tap (bus_socket). It may use terminal and sis. It passes on only
what is defined in settings: no module behind it knows what a serial port is.
"""
