# SPDX-License-Identifier: GPL-2.0-or-later
"""What every command shares with its caller.

Messages, and text that is safe to print (console); how files are opened for writing (writing); exit codes (exits); the
signals that end a command (stop); what sistap remembers between runs (state); other programs (programs); and cures in
the words of each system (advice). It uses nothing else of sistap.
"""
