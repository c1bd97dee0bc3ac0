# SPDX-License-Identifier: GPL-2.0-or-later
"""What `sistap` does: a room a command, which begins in its command.py. Uses the tap and what is dissected."""
