# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap install` and `uninstall`: the dissector, the interfaces and the profile, where Wireshark looks for them."""
