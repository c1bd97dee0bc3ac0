# SPDX-License-Identifier: GPL-2.0-or-later
"""What the dissector says of the packets of a capture.

Each packet with its telegrams, from tshark (dissection), what was read once (kept), how often times came
(distribution), what can be wrong with a packet (moments). It may use accesses and line.
"""
