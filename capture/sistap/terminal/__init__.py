# SPDX-License-Identifier: GPL-2.0-or-later
"""What every command has to do with whoever started it.

Lines on standard error (console), and text that is fit for a line (visible); standard output (streams, writing); exit
codes (exits); the signals that end a command (stop), what no signal may leave behind (temporary); and what sistap
remembers from one run to the next (state).
It uses nothing else of sistap.
"""
