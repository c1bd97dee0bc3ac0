# SPDX-License-Identifier: GPL-2.0-or-later
"""The recorder: `sistap record` runs for months, and keeps what matters in separate files.

The command (command), what matters, and its name (reasons), the records around it (keeper), the names and the number
of files (retention), their compression (packing), notifications (notifier), and the thread of all that (recorder). It
may use capture and explain.
"""
