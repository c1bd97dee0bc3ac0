# SPDX-License-Identifier: GPL-2.0-or-later
"""Captures of other tools, made into captures of ours: `sistap import`.

The formats and how each is recognised (formats), the characters in them (usb, rtac, saleae, sigrok), and what all of
them are to the rest (source). Then they become a capture (convert). Whole messages become packets (messages). It may
use all rooms but the other products.
"""
