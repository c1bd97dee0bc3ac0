# SPDX-License-Identifier: GPL-2.0-or-later
"""Wires: where a bus is heard, and the options for it (choice).

A wire (serve) delivers what is played: at a pseudo terminal, over a socket to taps, at a real port (port_wire), or,
without waiting, into a capture file (recording). pace has the time, log the text log.

A port can be read and written: a real one (transmitting), or a pseudo terminal that a real master opens (pty_port).
"""
