# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap import`: captures of other tools, converted into captures of sistap.

The formats and how each is recognised (formats), the characters in them (usb, rtac, saleae, sigrok), and their common
interface (source). USB transfers come from tshark (usb_transfers) or a text (usbmon); a table has the kinds of adapters
(usb_kinds). Levels of logic analysers are read (session, vcd, levels), and become characters (wave). All become a
capture (convert). Whole messages become packets (messages). It may use all rooms but the other products.
"""
