# SPDX-License-Identifier: GPL-2.0-or-later
"""An S5 and a PPC that talk over procedure 3964R: the bus of SYNAX200 without SIS.

partner is one side of the procedure: it requests, grants, sends, repeats. rk512 makes and parses the telegrams in its
blocks. controls has both ends, the S5 and the PPC; link is the line between them, with its times. procedure reads their
tables in a scenario, and plays them.
"""
