# SPDX-License-Identifier: GPL-2.0-or-later
"""Characters become records.

What a record is (record), how characters are cut into records (cut; framer, framer_3964r), in which order records of
two lines come (order), and how all that is put together (assembler). What was seen (counters), and records as text
(text). It may use line and sis.
"""
