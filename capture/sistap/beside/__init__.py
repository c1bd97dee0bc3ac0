# SPDX-License-Identifier: GPL-2.0-or-later
"""Two captures of the same traffic, one of which knows the times: how honest is the other?

Which telegram of one is which of the other (aligning), how late the times are (lateness), which verdicts differ
(verdicts), and all that as text (comparing) and as a picture (plot, which needs matplotlib).
"""
