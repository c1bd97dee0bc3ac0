# SPDX-License-Identifier: GPL-2.0-or-later
"""The virtual bus: a master and two drives that speak SIS, without hardware.

A telegram flows forward: master (what is asked) -> drive, routing (what is answered) -> playing (when each character
arrives, and what disturbs it) -> pseudo_terminal or taps (who hears it), hearing (with which settings); command puts
them together.
"""
