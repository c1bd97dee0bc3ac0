# SPDX-License-Identifier: GPL-2.0-or-later
"""The parts of the SIS protocol that a tap needs.

The header of a telegram (telegram), the names of services (names), the rates (rates), and rate changes (follow). It
uses nothing else of sistap.
"""
