# SPDX-License-Identifier: GPL-2.0-or-later
"""Pictures without a library: panels with axes and marks in the units of their data, drawn as SVG (panel, svg)."""
