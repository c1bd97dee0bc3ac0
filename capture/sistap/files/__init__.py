# SPDX-License-Identifier: GPL-2.0-or-later
"""Records in files.

The bytes of a pcapng file (pcapng), records into its blocks (writer), blocks into a file, a ring of files or a pipe
(output), and the way back (reading). It may use records and what that may use.
"""
