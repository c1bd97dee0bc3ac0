# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap install` and `uninstall`: the dissector, the interfaces and the profile, where Wireshark looks for them.

And the command with its completion, where a shell does. What there is to put there (sources, module, launching; shell,
completion), and the list of what was put (ledger). It may use all rooms but
the other products.
"""
