# SPDX-License-Identifier: GPL-2.0-or-later
"""One half of the bus is real: our master with real stations (talking), or our stations with a real master.

For the latter, receiver cuts commands out of what is heard, as a slave must, and answering decides when to send. noting
logs both.
"""
