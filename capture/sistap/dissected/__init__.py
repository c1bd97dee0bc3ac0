# SPDX-License-Identifier: GPL-2.0-or-later
"""What tshark says of captures: packets, accesses, episodes. Uses the tap."""
