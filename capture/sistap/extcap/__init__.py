# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap as an extcap: serial ports among the interfaces of Wireshark, a distant tap, and a bus in software.

Wireshark runs `sistap extcap` for every question: which interfaces there are (interfaces), which options their dialog
has (dialog), whether a capture filter is right; and then for a capture into a pipe (started), with the toolbar beside
it (toolbar). command answers. All extcaps are run while Wireshark starts: what only a capture needs is imported when
one begins. It may use all rooms but the other products.
"""
