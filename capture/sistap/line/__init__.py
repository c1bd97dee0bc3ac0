# SPDX-License-Identifier: GPL-2.0-or-later
"""A serial line, from the port to characters with times.

Which ports there are (ports), their settings (settings), how they are read (reader), when a character came (clock,
measurement, priority), and a line in software (wire). It may use terminal and sis. Only this room knows what a serial
port is; what it passes on is in settings.
"""
