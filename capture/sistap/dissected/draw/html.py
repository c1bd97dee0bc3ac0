# SPDX-License-Identifier: GPL-2.0-or-later
"""The beginning and the end of a page that needs nothing else: no script, no network, light and dark."""

from __future__ import annotations

from html import escape

END = "</body>\n</html>\n"


def begin(title: str, style: str) -> str:
    """Return everything before the first element of the page; `style` begins with the end of a line."""
    return f"""\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{escape(title)}</title>
<style>{style}</style>
</head>
<body>
"""
