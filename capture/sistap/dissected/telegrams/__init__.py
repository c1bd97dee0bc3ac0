# SPDX-License-Identifier: GPL-2.0-or-later
"""What telegrams say, as far as this is known without Wireshark.

Stations, service, parameter (interpreter), and values (values) by the attribute of their parameter (attribute). It may
use records.
"""
