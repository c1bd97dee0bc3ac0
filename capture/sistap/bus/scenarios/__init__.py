# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenarios: the built-in ones, and the code that reads them. How one is written is in README.md.

scenario reads a file and can play it; steps are those of a master's script, bodies the useful data of their commands,
faults what goes wrong. procedure3964 reads those of 3964R. demo is what the demo's master says.
"""
