# SPDX-License-Identifier: GPL-2.0-or-later
"""The parts of the SIS protocol that a tap needs.

The telegram and its services (telegram), the rates (rates), the limits of the user (limits), service 0x03, which
changes rates and limits (initialization), and facts that explain later telegrams (told).
It uses nothing else of sistap.
"""
