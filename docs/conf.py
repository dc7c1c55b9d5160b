"""Settings of Sphinx for these pages: Markdown by MyST, a plain theme, nothing fetched from the network."""

import sys
from pathlib import Path

import hairpipe

sys.path.insert(0, str(Path(__file__).parent))

project = "hairpipe"
author = "the authors of hairpipe"
copyright = "the authors of hairpipe, Apache-2.0"
version = release = hairpipe.__version__

extensions = [
    "myst_parser",
    "extension.nodes",
    "extension.commands",
    "extension.interface",
    "extension.differences",
    "extension.gallery",
    "extension.includes",
    "extension.ledger",
    "extension.results",
]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 5
highlight_language = "none"
smartquotes = False
# A page that is included begins where its section does, which may be the second level.
suppress_warnings = ["myst.header"]

html_theme = "furo"
html_title = f"hairpipe {version}"
html_static_path = ["static"]
html_css_files = ["pages.css"]
html_show_sourcelink = False
html_copy_source = False
