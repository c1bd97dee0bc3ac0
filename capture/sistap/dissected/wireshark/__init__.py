# SPDX-License-Identifier: GPL-2.0-or-later
"""The Wireshark that is installed here.

How to run its tshark, also as root (tshark), the rows that it prints (rows), what it says when it fails (trouble), and
where Wireshark keeps its files (folders). `python3 -m sistap.dissected.wireshark ARGUMENTS` runs tshark without root's
rights. It may use terminal.
"""
