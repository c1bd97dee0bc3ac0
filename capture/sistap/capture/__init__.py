# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap capture`: a line becomes a file or text.

The options (command), a running capture (session), which rate next (steering, scan), what to say of it (hints), who may
steer it (remote), and capture filters (filter). It may use files, records and line.
"""
