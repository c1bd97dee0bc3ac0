# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report`: what Wireshark's dissector says of a whole capture, on one page.

Packets (dissection), what is counted (figures, curves, pauses, windows), what has no limit (unjudged), which curves are
shown (curved), pictures (plots), and the page (page, plain). It may use all rooms but the other products.
"""
