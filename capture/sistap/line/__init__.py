# SPDX-License-Identifier: GPL-2.0-or-later
"""A serial line, from the port to characters with times.

Which ports there are (ports), their settings (settings), how they are read (reader), when a character came (clock,
measurement, priority), and what a bus in software says to a tap (bus_socket). It may use terminal and sis. What it
passes on is in settings: behind it nothing knows what a serial port is.
"""
