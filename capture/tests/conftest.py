# SPDX-License-Identifier: GPL-2.0-or-later
"""Signals as a terminal has them, also where the tests run without one."""

from __future__ import annotations

import signal

# What nohup ignores, children ignore: they would not end when their terminal goes.
signal.signal(signal.SIGHUP, signal.SIG_DFL)
