# SPDX-License-Identifier: GPL-2.0-or-later
"""The SIS protocol, as much of it as a tap needs.

The header of a telegram (telegram), the names of services (names), the rates (rates), and what the bus is
told of them (follow). It uses nothing else of sistap.
"""
