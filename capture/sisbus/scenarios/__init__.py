# SPDX-License-Identifier: GPL-2.0-or-later
"""Scenarios: the built-in ones, and the code that reads them. README.md explains how to write one.

scenario reads a file and can play it; steps has the steps of a master's script, bodies the useful data of their
commands, faults the disturbances. demo is the script of the demo's master.
"""
