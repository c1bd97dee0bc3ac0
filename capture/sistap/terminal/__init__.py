# SPDX-License-Identifier: GPL-2.0-or-later
"""What every command has to do with whoever started it: signals (stop), and what they may not leave (temporary).

It uses nothing else of sistap but the exit codes.
"""
