# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap compare`: what changed between good captures and bad ones.

What is counted on a side (side), how likely chance makes a difference (samples, chance), what happened (happened) and
what else differs (differences), the summary and the tables (findings), text and JSON (plain), page (page). It may use
all rooms but the other products.
"""
