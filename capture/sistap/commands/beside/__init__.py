# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares two captures of the same traffic. One has true times; how true are those of the other?

Which telegram of one is which of the other (aligning), how late the times are, also as a picture (lateness), and the
result as text, with the verdicts that differ (comparing).
"""
