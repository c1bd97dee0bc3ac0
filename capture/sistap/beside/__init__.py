# SPDX-License-Identifier: GPL-2.0-or-later
"""Compares two captures of the same traffic. One has true times; how true are those of the other?

Which telegram of one is which of the other (aligning), how late the times are (lateness), which verdicts differ
(verdicts), and the result as text (comparing) and as a picture (plot, which needs matplotlib).
"""
