# SPDX-License-Identifier: GPL-2.0-or-later
"""Records in files.

The bytes of a pcapng file (pcapng), records as its blocks (writer), and blocks in a file, a ring of files or a pipe
(output), made to last (lasting). It may use records and the rooms that records uses.
"""
