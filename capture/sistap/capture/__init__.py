# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap capture`: a line becomes a file or text.

The command (command), what it is told (options), how the parts are put together (running), the loop (session), what is
read on its lines (tap), which rate next (steering, scan), what to say of it (hints), who may control it (remote), and
capture filters (filter). It may use files, records and line.
"""
