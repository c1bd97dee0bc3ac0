# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap parameters`: the list of parameters in captures, and their changes.

Captures read (reading), rows and changes as text or CSV (writing), the command line (command). Backups of drives
(backup, values) become Wireshark's table (writing), or are compared with a capture (against). It may use all rooms
but the other products.
"""
