# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap report`: what Wireshark's dissector says of a whole capture, on one page."""
