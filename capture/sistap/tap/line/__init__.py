# SPDX-License-Identifier: GPL-2.0-or-later
"""A serial line, from the port to characters with times.

Ports (ports) and their drivers (drivers), their settings (settings), how they are read (reader), and when a character
came (clock, measurement, priority). It may use terminal and sis. It passes on only what is defined in settings: no
module behind it knows what a serial port is.
"""
