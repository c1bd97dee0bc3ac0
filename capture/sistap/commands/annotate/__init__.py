# SPDX-License-Identifier: GPL-2.0-or-later
"""Logs of other programs, explained.

Where a log comes from (sources, textlog, raw), how its bytes are written and where they stand (choosing among the table
of notations), what a line holds (reading, with stamps and marks; pattern),
its telegrams (cutting), what tshark says about them (explaining, meanings), and the log again (annotator, page). A
capture as a log of this kind (log). It may use all rooms but the other products.
"""
