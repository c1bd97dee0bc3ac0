# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters become records.

The record (record), how characters are cut into records (cut; framer, framer_3964r), and putting all that together in
the order of time (assembler). The counters of a capture (counters), and what a file begins with that continues another
(before). It may use line and sis.
"""
