# SPDX-License-Identifier: GPL-2.0-or-later
"""Wires: where a bus is heard, the options for it (place), and a bus of which one half is real.

A wire delivers what is played: at a pseudo terminal, over a socket to taps, at a real port, or, without waiting, into a
capture file (recording). A port can be read and written: a real one, or a pseudo terminal that a real master opens.

Our master meets real stations in talking. Our stations, or one partner of 3964R, meet a real master in answering;
receiver cuts commands out of what they hear, as a slave must.
"""
