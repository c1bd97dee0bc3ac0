# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap capture`: a line becomes a file or text.

The command (command), its settings (options), how the parts are put together (running), the loop (session), the lines
and what is read on them (tap), the next rate (rate), hints for the user (hints), and capture filters (filter). It may
use files, records and line.
"""
