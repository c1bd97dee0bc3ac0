# SPDX-License-Identifier: GPL-2.0-or-later
"""The recorder: `sistap record` runs for months, and keeps what matters in separate files.

The command (command), what matters (reasons: filters; watching: what happens), the records around it (keeper), the
names and the number of files (retention), their compression (packing), notifications (notifier), live values for other
programs (values), and the thread of all that (recorder). It may use capture, explain and episodes.
"""
