# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap install` and `uninstall`: the dissector, the interfaces and the profile for Wireshark.

Also the command and its completion for a shell. What can be installed (sources; shell, completion), and the list of
what was installed (ledger). It may use all rooms but the other products.
"""
