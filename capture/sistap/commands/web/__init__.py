# SPDX-License-Identifier: GPL-2.0-or-later
"""sistap in the page of a browser (lua-fallback/page), where Python runs as WebAssembly.

What the page asks of sistap: logs (opening), what happened in a capture (judging), the virtual bus in real time (play),
a capture at ports that the page reads (listen), and what these two have in common (window). `sistap web` (command)
opens the page.
"""
