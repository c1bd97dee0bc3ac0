# SPDX-License-Identifier: GPL-2.0-or-later
"""What was read and written of parameters, as the dissector says it.

Each access (access), and the list of parameters with what has changed (listing). It may use wireshark.
"""
