# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap as an extcap: serial ports as interfaces of Wireshark, and a simulated bus.

Wireshark runs `sistap extcap` for every question: the interfaces (interfaces), the options of their dialog (dialog),
the check of a capture filter. Then it runs it for a capture into a pipe (started), with the toolbar (toolbar). command
answers. Wireshark runs all extcaps while it starts, so what only a capture needs is imported when one begins. It may
use all rooms but the other products.
"""
