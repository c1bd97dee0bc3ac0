# SPDX-License-Identifier: GPL-2.0-or-later
"""What the dissector says about the packets of a capture.

Each packet with its telegrams, from tshark (dissection), rows kept for a second look (kept), how often times came
(distribution), what can be wrong with a packet (faults). It may use accesses and line.
"""
