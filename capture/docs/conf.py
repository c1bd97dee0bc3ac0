# SPDX-License-Identifier: GPL-2.0-or-later
"""The settings of Sphinx for the site that site.py makes."""

from pathlib import Path

project = "sistap"
html_title = "SIS in Wireshark"
extensions = ["myst_parser"]
myst_heading_anchors = 4
html_theme = "furo"
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_use_index = False
smartquotes = False  # an option has two hyphens
html_show_search_summary = False  # so that the search works from file://
html_search_scorer = str(Path(__file__).with_name("scorer.js"))
html_static_path = ["static"]
html_css_files = ["narrow.css"]
html_theme_options = {"navigation_with_keys": True}
highlight_language = "none"
pygments_style = "friendly"
