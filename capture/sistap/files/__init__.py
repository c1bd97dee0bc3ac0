# SPDX-License-Identifier: GPL-2.0-or-later
"""Records in files.

The bytes of a pcapng file (pcapng), records as its blocks (writer), blocks in a file, a ring of files or a pipe
(output), and reading files (reading). It may use records and the rooms that records uses.
"""
