"""The site: every page of docs/, the tutorials executed, and the docstrings.  ``make docs`` builds it."""

import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import isoembed

sys.path.insert(0, str(Path(__file__).parent))

project = "isoembed"
author = "The isoembed contributors"
release = version = isoembed.__version__
html_title = "isoembed"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_copybutton",
    "example_gallery",
    "accessible_html",
]

# The pages are written for GitHub as much as for the site: dollars are math, headings have GitHub's anchors.
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3

# What is between single backticks in a docstring is a name of the library, if there is such a name.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the docstrings say the types, with shapes and units
numpydoc_show_class_members = False

nb_execution_mode = "force"  # the repository has no outputs
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 1200
nb_merge_streams = True

copybutton_exclude = ".linenos, .gp, .go"

# Nothing on the site needs a network.  Of MathJax it takes the one file that draws in SVG and needs no fonts.
_mathjax = Path(find_spec("sphinx-mathjax-offline").origin).parent / "static/mathjax/tex-svg.js"
mathjax_path = _mathjax.name
mathjax3_config = {"options": {"enableMenu": False}}  # its entries would load more
html_static_path = ["_static", str(_mathjax)]

html_theme = "furo"
html_css_files = ["site.css"]
html_show_copyright = False
html_show_sourcelink = False
html_copy_source = False


def bars_are_absolute_values(
    app: Sphinx, what: str, name: str, documented: Any, options: Any, lines: list[str]
) -> None:
    """Keep reStructuredText from taking the bars of |x| for its substitutions, which no docstring has."""
    lines[:] = [re.sub(r"(``.*?``|\\\|)|\|", lambda match: match[1] or r"\|", line) for line in lines]


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", bars_are_absolute_values)
