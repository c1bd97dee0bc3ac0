# SPDX-License-Identifier: GPL-2.0-or-later
"""The recorder: `sistap capture --keep` runs for months, and keeps what matters in files of its own.

What matters, and what it is called (reasons), which records are around it (keeper), how files are named and how many
there are (shelf), who is told (telling), and the thread in which all of that happens (recorder). It may use explain.
"""
