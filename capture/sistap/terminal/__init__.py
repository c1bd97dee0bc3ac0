# SPDX-License-Identifier: GPL-2.0-or-later
"""What every command shares with its caller.

Messages on standard error (console), and text that is safe to print (visible); standard output (streams, writing); exit
codes (exits); the signals that end a command (stop), and files that no signal may leave behind (temporary); and what
sistap remembers between runs (state). It uses nothing else of sistap.
"""
