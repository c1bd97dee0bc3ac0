# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says about records: the only source of explanations.

The fields of an explanation and its sentence (fields), a running tshark (running), one tshark after the other for as
long as needed (relay), and a live capture as text (live; plain without
tshark). It may use files and wireshark.
"""
