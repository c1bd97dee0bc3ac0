# SPDX-License-Identifier: GPL-2.0-or-later
"""What the dissector says about the packets of a capture.

Each packet with its telegrams and its faults, from tshark (dissection), rows kept for a second look (kept), how often
times came (distribution), several telegrams of a packet (apart). It may use accesses and line.
"""
