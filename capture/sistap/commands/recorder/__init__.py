# SPDX-License-Identifier: GPL-2.0-or-later
"""The recorder: `sistap record` runs for months, and keeps what matters in separate files.

The command (command), what matters (reasons), the records around it (keeper), the names, number and compression of
files (retention), notifications (notifier), live values for other programs (values), and the thread of all that
(recorder). It may use capture, explain and episodes.
"""
