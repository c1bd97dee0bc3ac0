# SPDX-License-Identifier: GPL-2.0-or-later
"""What several commands share, and a tap does not need.

Output files (writing), temporary files (temporary), what other programs complain of (complaints), local time in every
system (calendar), tables of text (table), and work without Python's search for cycles (garbage). It may use terminal.
"""
