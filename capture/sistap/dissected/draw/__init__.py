# SPDX-License-Identifier: GPL-2.0-or-later
"""Pages without a library, and pictures: panels with axes and marks in the units of their data (html, panel, svg)."""
