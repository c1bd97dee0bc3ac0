# SPDX-License-Identifier: GPL-2.0-or-later
"""What happened, and when: episodes, made of packets and values as they come, in bounded memory.

The table of the kinds and their thresholds (rules), an episode (episode) and what makes one of many hits (book), what
looks for them: faults of single telegrams (faults), silences (silence), masters and writes (masters), states of the
bus and of the tap (states), values (values, with levels and trend), values beside those of a good capture (baseline).
All of it (engine), also while it happens (live), and the five lines that answer (lines). It may use packets.
"""
