# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap install` and `uninstall`: the dissector, the interfaces and the profile, where Wireshark looks for them.

What there is to put there (sources, module, launching), and the list of what was put (ledger). It may use all rooms but
the other products.
"""
