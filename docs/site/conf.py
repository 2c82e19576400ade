"""Sphinx' settings for the documentation site; `cargo xtask site` builds it."""

import os
import sys
from pathlib import Path

# Of tqdm, which other packages import; progress bars are not shown.
os.environ["PYTHONWARNINGS"] = "ignore:IProgress not found"
sys.path.insert(0, str(Path(__file__).parent / "extensions"))

import emitree

project = "emitree"
author = "the emitree authors"
copyright = author
version = release = emitree.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "myst_nb",
    "sphinx_design",
    "sphinx_copybutton",
    "docstrings",
    "mathml",
]
templates_path = [str(Path(__file__).parent / "templates")]
exclude_patterns = ["files"]

# All that is not found is an error.
nitpicky = True

myst_enable_extensions = ["colon_fence", "attrs_inline", "dollarmath"]
myst_heading_anchors = 0
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
# Warnings of a notebook are an error too.
nb_output_stderr = "remove-warn"

autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
maximum_signature_line_length = 88
add_module_names = False
toc_object_entries_show_parents = "hide"
copybutton_exclude = ".linenos, .gp, .go"

html_theme = "pydata_sphinx_theme"
html_title = f"emitree {release}"
html_static_path = [str(Path(__file__).parent / "static")]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False
# Summaries are read by requests, which browsers refuse for local files.
html_show_search_summary = False
html_theme_options = {
    "logo": {"text": "emitree"},
    "header_links_before_dropdown": 6,
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "show_prev_next": False,
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": [], "install": [], "gallery": []}
html_context = {"default_mode": "auto"}
