# SPDX-License-Identifier: GPL-2.0-or-later
"""What was read and written of parameters, according to the dissector.

Each access (access), and the list of parameters with their changes (listing). It may use wireshark.
"""
