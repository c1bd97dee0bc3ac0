# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says of records: the only place where an explanation comes from.

The fields of an explanation and its sentence (fields), a tshark that runs (running), the telegrams that the next one
has to know (memory), and one after the other for as long as it takes (relay). It may use files and wireshark.
"""
