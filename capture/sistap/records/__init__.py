# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters become records.

The record (record), how characters are cut into records (cut; framer, framer_3964r), the order of records of two lines
(order), and putting all that together (assembler). The counters of a capture (counters), and records as text (text). It
may use line and sis.
"""
