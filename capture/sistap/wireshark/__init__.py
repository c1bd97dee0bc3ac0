# SPDX-License-Identifier: GPL-2.0-or-later
"""The Wireshark that is installed here.

How to run its tshark, also as root (tshark), what that prints of packets (rows), and where Wireshark keeps its files
(folders). `python3 -m sistap.wireshark ARGUMENTS` is tshark that drops its rights first. It may use terminal.
"""
