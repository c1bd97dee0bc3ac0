# SPDX-License-Identifier: GPL-2.0-or-later
"""Playing: what masters say, and what becomes of it on a line.

conducting has the scripts of masters, passes the word between them and performs their actions on a line. player is the
simulated line, with the times that everybody keeps. characters are what is sent and heard, and where faults act on it.
"""
