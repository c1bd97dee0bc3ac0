# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says about records: the only source of explanations.

The fields of an explanation and its sentence (fields), a running tshark (running), the telegrams that the next tshark
must know (memory), and one tshark after the other for as long as needed (relay). It may use files and wireshark.
"""
