# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap: a passive tap for the SIS serial protocol that records the time of every character."""

__version__ = "0.1.0"
