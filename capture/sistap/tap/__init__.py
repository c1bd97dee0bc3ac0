# SPDX-License-Identifier: GPL-2.0-or-later
"""The tap: characters with times, records, files. A library of its own, which uses nothing else of sistap."""
